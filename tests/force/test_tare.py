"""The tare: an untouched span of a recording counts as zero, for as long as the arm rests there."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import torch
import yaml

from benchmarks.slow_presses import COLUMNS, seed_rows
from tests.command import Command
from tests.conftest import said
from tests.made_records import motion_of, stretch
from tests.made_up_torques import MODEL
from tests.synthetic import poor_log
from ur5lib.errors import InputError
from ur5lib.force.external_torque import JointState
from ur5lib.force.problem import fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.tare import tare_doubts, tared
from ur5lib.records.codes import Found
from ur5lib.records.currents import Currents
from ur5lib.records.motion import Motion
from ur5lib.records.signals import SENSOR_COLUMNS, Signals
from ur5lib.robots.description import Robot
from ur5lib.study.reading import parse_study
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import extrapolated_samples

TIME: Array = 0.01 * np.arange(1500.0)
OFFSET = np.array([3.0, -2, 1, 0.5, 0.2, 0.1])


def resting(moves_at: float = np.inf) -> tuple[Currents, Motion]:
    """A constant torque of an arm at rest, which turns joint 1 after some seconds."""
    q = np.zeros((len(TIME), 6))
    q[:, 0] = np.clip(TIME - moves_at, 0, 1)
    torque = np.tile(OFFSET, (len(TIME), 1))
    currents = Currents(**stretch(TIME), external_torque=torque)
    return currents, motion_of(TIME, q, np.diff(q, axis=0, append=q[-1:]) / 0.01)


def test_the_torque_of_the_span_is_zero_until_the_arm_is_elsewhere() -> None:
    known, motion = resting(moves_at=8.0)
    found = tared(known, motion, (0.0, 1.5), 2.0)
    torque = found.external_torque
    assert torque is not None
    np.testing.assert_allclose(torque[TIME < 8], 0, atol=1e-12)
    np.testing.assert_array_equal(torque[TIME > 8.1], np.tile(OFFSET, (689, 1)))


@pytest.mark.parametrize("usual", [True, False])
def test_a_tared_background_stays_with_fits_as_without(usual: bool) -> None:
    known, motion = resting(moves_at=8.0)
    found = tared(known, motion, (0.0, 1.5), 2.0)
    problem = fmap_problem(motion, found, Residuals(tau_ext=replace(MODEL, usual=usual)))
    assert problem is not None
    assert (problem.input.states[TIME < 5] == JointState.TARED).all()
    assert (problem.input.states[TIME > 12] == JointState.STILL).all()


def test_a_tared_background_is_no_less_certain() -> None:
    own = MODEL.with_tare()
    assert (own.spread[JointState.TARED] <= own.spread[JointState.STILL]).all()
    assert (own.change[JointState.TARED] <= own.change[JointState.STILL]).all()


def resting_signals(arm: Robot, moves_at: float = np.inf, **more: Any) -> Signals:
    _, motion = resting(moves_at)
    noise = 1e-5 * np.random.default_rng(1).normal(size=motion.q.shape)
    grid = stretch(TIME) | {"interpolated": np.zeros(len(TIME), bool)}
    return Signals(**grid, actual_q=motion.q + noise, **more)


def doubts(span: tuple[float, float], signals: Signals, arm: Robot) -> list[str]:
    return [finding.code for finding in tare_doubts(span, signals, arm, 2.0)]


@pytest.mark.parametrize("span", [(20.0, 21.0), (8.0, 9.0), (0.0, 0.3)])
def test_a_span_outside_or_in_motion_or_too_short_is_no_tare(
    ur5: Robot, span: tuple[float, float]
) -> None:
    """The recording costs its tare, and no other recording anything."""
    known, motion = resting(moves_at=8.0)
    assert tared(known, motion, span, 2.0) is known
    signals = resting_signals(ur5, moves_at=8.0)
    (finding,) = tare_doubts(span, signals, ur5, 2.0)
    assert finding.severity == "error"
    assert f"`untouched` [{span[0]:g}, {span[1]:g}]" in said(finding)


def test_a_span_at_rest_is_a_tare(ur5: Robot) -> None:
    assert doubts((0.0, 1.5), resting_signals(ur5, moves_at=8.0), ur5) == []


def test_half_a_second_of_known_torque_is_a_tare(ur5: Robot) -> None:
    """What the filter leaves unknown at the start does not count."""
    unknown, signals = 0.01 * extrapolated_samples(2.0, 0.01), resting_signals(ur5)
    short, long = ((0.0, unknown + seconds) for seconds in (0.4, 0.6))
    assert doubts(short, signals, ur5) == [Found.UNUSABLE_TARE]
    assert doubts(long, signals, ur5) == []


PRESS = np.clip(TIME - 0.3, 0, 0.5)[:, None] * np.array([0.0, 30.0, 50.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("channel", ["force_sensor", "actual_current"])
def test_a_press_in_the_span_is_told_by_sensor_or_currents(ur5: Robot, channel: str) -> None:
    """Before, 28 N at its end were taken for zero."""
    noise = 0.05 * np.random.default_rng(2).normal(size=PRESS.shape)
    pressed = resting_signals(ur5, **{channel: 3.0 + PRESS + noise})
    assert doubts((0.0, 0.8), pressed, ur5) == [Found.TOUCHED_TARE]
    assert doubts((0.9, 3.0), pressed, ur5) == []


def test_a_check_says_what_is_wrong_with_a_tare(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command, ur5: Robot
) -> None:
    """With a sensor that has a clock of its own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "500")
    log = poor_log(ur5, 20.0, seed=1)  # which rests at its end
    host = log["time"] + 1.7e9
    log.rename(columns={"time": "timestamp"}).assign(host_time=host).to_csv("run.csv", index=False)
    noise = 0.05 * np.random.default_rng(3).normal(size=(len(log), 6))
    pressed = pd.DataFrame(noise, columns=SENSOR_COLUMNS["force"])
    pressed["ft_fz"] += 28 * np.clip(log["time"] - 17.5, 0, 1)
    pressed.insert(0, "time", host)
    pressed.to_csv("force.csv", index=False)
    entry = ENTRY | {"role": "contact", "format": "rtde-csv", "folder": ".", "file": "run.csv"}
    sensor = {"file": "force.csv", "columns": ["time", *SENSOR_COLUMNS["force"]]}
    entry |= {"force_sensor": sensor | {"time": "host_s"}}
    del entry["simulate"]
    for span, status, told in (
        ([0, 0.15], 1, "is no tare"),
        ([17, 18.5], 0, "touched tare (warning)"),
    ):
        study = {"study": "s", "title": "t", "recordings": [entry | {"untouched": span}]}
        Path("study.yaml").write_text(yaml.safe_dump(study))
        answer = run_ur5("check", "study.yaml")
        assert (answer.status, told in answer.line) == (status, True), answer


ENTRY: dict[str, Any] = {
    "name": "a",
    "robot": "ur5",
    "format": "thesis-csv",
    "simulate": {"trajectory": {"kind": "standstill"}},
}


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ({"role": "contact", "untouched": [1.5, 0]}, "a start and a later end"),
        ({"role": "fit", "untouched": [0, 1.5]}, "nothing touches"),
    ],
)
def test_a_span_that_means_nothing_is_explained(more: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told):
        parse_study({"study": "s", "title": "t", "recordings": [ENTRY | more]}, "study.yaml")


@pytest.mark.slow
def test_a_slow_press_without_a_recording_to_fit_on() -> None:
    """Before, the background followed the press: bands held 0.5 of it, and half went unnoticed."""
    torch.set_num_threads(1)
    rows = pd.DataFrame([row for seed in range(2) for row in seed_rows(seed)], columns=COLUMNS)
    pooled = rows.groupby("by").sum()
    held, lost = (pooled.loc[name] for name in ("with an untouched span", "without"))
    assert held["square"] < lost["square"]
    assert held["inside"] / held["samples"] > 0.85
    assert lost["inside"] / lost["samples"] > 0.85
    assert rows.loc[rows["by"] == "with an untouched span", "late"].max() < 1.0
