"""The tare: an untouched span of a recording counts as zero, for as long as the arm rests there."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import torch

from benchmarks.slow_presses import COLUMNS, seed_rows
from tests.library.made_up_torques import MODEL
from tests.made_records import motion_of, stretch
from ur5lib.errors import InputError
from ur5lib.force.external_torque import JointState
from ur5lib.force.problem import fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.records.currents import Currents
from ur5lib.records.motion import Motion
from ur5lib.steps.predict_currents import tared
from ur5lib.study.reading import parse_study
from ur5lib.timeseries.arrays import Array

TIME: Array = 0.01 * np.arange(1500.0)
OFFSET = np.array([3.0, -2, 1, 0.5, 0.2, 0.1])


def resting(moves_at: float = np.inf) -> tuple[Currents, Motion]:
    """A constant torque of an arm at rest, which turns joint 1 after some seconds."""
    q = np.zeros((len(TIME), 6))
    q[:, 0] = np.clip(TIME - moves_at, 0, 1)
    torque = np.tile(OFFSET, (len(TIME), 1))
    currents = Currents(**stretch(TIME), external_torque=torque, causal_torque=torque)
    return currents, motion_of(TIME, q, np.diff(q, axis=0, append=q[-1:]) / 0.01)


def test_the_torque_of_the_span_is_zero_until_the_arm_is_elsewhere() -> None:
    known, motion = resting(moves_at=8.0)
    found = tared(known, motion, (0.0, 1.5), "own")
    torque = found.external_torque
    assert torque is not None
    np.testing.assert_array_equal(torque, found.causal_torque)
    np.testing.assert_allclose(torque[TIME < 8], 0, atol=1e-12)
    np.testing.assert_array_equal(torque[TIME > 8.1], np.tile(OFFSET, (689, 1)))


@pytest.mark.parametrize(("usual", "state"), [(True, JointState.TARED), (False, JointState.STILL)])
def test_a_background_that_no_recording_shows_is_held(usual: bool, state: int) -> None:
    known, motion = resting(moves_at=8.0)
    found = tared(known, motion, (0.0, 1.5), "own")
    problem = fmap_problem(motion, found, Residuals(tau_ext=replace(MODEL, usual=usual)))
    assert problem is not None
    assert (problem.input.states[TIME < 5] == state).all()
    assert (problem.input.states[TIME > 12] == JointState.STILL).all()


def test_a_tared_background_is_no_less_certain() -> None:
    own = MODEL.with_tare()
    assert (own.spread[JointState.TARED] <= own.spread[JointState.STILL]).all()
    assert (own.change[JointState.TARED] <= own.change[JointState.STILL]).all()


@pytest.mark.parametrize("span", [(20.0, 21.0), (8.0, 9.0), (0.0, 0.3)])
def test_a_span_outside_or_in_motion_or_too_short_is_refused(span: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"`untouched` of own .* at rest"):
        tared(*resting(moves_at=8.0), span, "own")


ENTRY: dict[str, Any] = {
    "name": "a",
    "robot": "ur5",
    "format": "thesis-csv",
    "simulate": {"trajectory": {"kind": "standstill"}},
}


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"role": "contact", "untouched": [1.5, 0]}, "a start and a later end"),
        ({"role": "fit", "untouched": [0, 1.5]}, "nothing touches"),
    ],
)
def test_a_span_that_means_nothing_is_explained(more: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        parse_study({"study": "s", "title": "t", "recordings": [ENTRY | more]}, "study.yaml")


@pytest.mark.slow
def test_a_slow_press_without_a_recording_to_fit_on() -> None:
    """Before, the background followed the press: bands held 0.5 of it, and half went unnoticed."""
    torch.set_num_threads(1)
    rows = pd.DataFrame([row for seed in range(4) for row in seed_rows(seed)], columns=COLUMNS)
    pooled = rows.groupby("by").sum()
    held, lost = (pooled.loc[name] for name in ("with an untouched span", "without"))
    assert held["square"] < lost["square"]
    assert held["inside"] / held["samples"] > 0.85
    assert lost["inside"] / lost["samples"] > 0.85
    assert rows.loc[rows["by"] == "with an untouched span", "late"].max() < 1.0
