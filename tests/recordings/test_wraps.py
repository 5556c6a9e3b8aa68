"""Angles that wrap by a whole turn become continuous; others stay as they are."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import said
from tests.entries import read_and_check
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.recordings.wraps import TURN, unwrapped, without_wraps
from ur5lib.records.codes import Found
from ur5lib.robots.description import Robot
from ur5lib.tables import channel, named
from ur5lib.timeseries.arrays import Array

NOISE = 2e-4  # rad
START = [0.5, 4.7, 1.6, -1.6, 3.0, 0.3]  # rad


def moving(rate: float, speed: float, seed: int, seconds: float = 20.0) -> tuple[Array, Array]:
    """Times, and an angle that swings so far that it wraps, with noise."""
    draw = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 1 / rate) + draw.uniform(-0.1, 0.1) / rate
    parts = draw.uniform(0.5, 1.0, 3)
    phases = np.outer(time, draw.uniform(0.3, 0.9, 3)) + draw.uniform(0, TURN, 3)
    swing = np.sin(phases) @ (parts / parts.sum())
    angle = speed / max(np.abs(np.gradient(swing, time)).max(), 1e-9) * swing
    return time, angle + draw.uniform(-3, 3) + draw.normal(0, NOISE, len(time))


def wrapped(angle: Array, low: float) -> Array:
    return low + np.mod(angle - low, TURN)


@settings(max_examples=60)
@given(
    st.sampled_from([10.0, 50.0, 125.0, 500.0]),
    st.floats(0.05, 2.0),
    st.integers(0, 10_000),
    st.sampled_from([0.0, -np.pi, 1.0]),
    st.sampled_from([1.0, 180 / np.pi]),
)
def test_a_wrapped_angle_returns_but_for_whole_turns(
    rate: float, speed: float, seed: int, low: float, unit: float
) -> None:
    time, angle = moving(rate, speed, seed)
    cut = unit * wrapped(angle, low)
    whole, count = unwrapped(cut, time, unit * TURN)
    jumps = np.abs(np.diff(cut)) > unit * np.pi
    assert count == jumps.sum()
    np.testing.assert_allclose(np.diff(whole), unit * np.diff(angle), atol=1e-9)
    assert not count or abs(whole[0]) <= unit * (np.pi + 1e-9)


@settings(max_examples=60)
@given(st.sampled_from([10.0, 125.0, 500.0]), st.floats(0.01, 4.0), st.integers(0, 10_000))
def test_an_angle_that_does_not_wrap_stays(rate: float, speed: float, seed: int) -> None:
    time, angle = moving(rate, speed, seed)
    whole, count = unwrapped(angle, time)
    assert count == 0
    np.testing.assert_array_equal(whole, angle)


def test_rows_that_were_lost_hide_no_wrap() -> None:
    time, angle = moving(125.0, 2.0, 3)
    cut = wrapped(angle, -np.pi)
    at = np.flatnonzero(np.abs(np.diff(cut)) > np.pi)
    assert len(at)
    holes = np.concatenate([at + k for k in range(-6, 7)])
    for lost in (
        np.random.default_rng(1).random(len(cut)) < 0.2,
        np.isin(np.arange(len(cut)), holes),
    ):
        whole, count = unwrapped(np.where(lost, np.nan, cut), time)
        assert count == len(at)
        np.testing.assert_array_equal(np.isnan(whole), lost)
        np.testing.assert_allclose(np.diff(whole[~lost]), np.diff(angle[~lost]), atol=1e-9)
        kept, count = unwrapped(cut[~lost], time[~lost])
        np.testing.assert_allclose(np.diff(kept), np.diff(angle[~lost]), atol=1e-9)


def test_an_angle_that_rests_at_the_border_rests() -> None:
    draw = np.random.default_rng(2)
    angle = np.pi + draw.normal(0, NOISE, 800)
    whole, count = unwrapped(wrapped(angle, -np.pi), np.arange(800) / 100)
    assert count > 100
    assert np.ptp(whole) < 20 * NOISE


def test_damaged_rows_of_an_angle_that_wraps_stay_damaged() -> None:
    time, angle = moving(125.0, 2.0, 3)
    cut = wrapped(angle, -np.pi)
    whole, count = unwrapped(cut, time)
    assert count
    spikes = np.arange(40, len(cut), 250)
    spikes = spikes[np.abs(cut[spikes]) < 2.8]
    for off in (-5.2, -4.0, np.pi, 5.2):
        damaged = cut.copy()
        damaged[spikes] += off
        mended, _ = unwrapped(damaged, time)
        np.testing.assert_allclose(np.delete(mended, spikes), np.delete(whole, spikes))
        np.testing.assert_allclose(mended[spikes] - whole[spikes], off)


DRAW = np.random.default_rng(7)
LONG = np.linspace(-3.0, 3.0, 2000) + DRAW.normal(0, NOISE, 2000)
NO_WRAPS = {
    "random postures": DRAW.uniform(-np.pi, np.pi, 3000),
    "postures in steps": np.repeat(DRAW.uniform(-np.pi, np.pi, 30), 100),
    "a jump by half a turn": np.where(np.arange(2000) < 900, LONG, LONG - np.pi),
    "a reset to zero": np.where(np.arange(2000) < 1900, 1.5 + LONG, 0.0),
    "a reset while it rests": np.where(np.arange(2000) < 900, 6.0, 0.0),
    "rows of zeros": np.where(np.isin(np.arange(2000), [500, 501, 1800, 1801]), 0.0, LONG + 2.5),
    "damaged rows": np.where(DRAW.random(2000) < 0.004, DRAW.uniform(-9, 9, 2000), LONG),
    "huge values": np.where(np.arange(2000) % 500 == 7, 1e300, LONG),
    "turns of a motor": 100 * np.sin(np.arange(2000) / 35),
    "two rows": np.array([-3.1, 3.1]),
    "one row": np.array([1.0]),
    "nothing": np.full(9, np.nan),
}


@pytest.mark.parametrize("kind", NO_WRAPS)
def test_what_is_no_wrap_stays(kind: str) -> None:
    angle = NO_WRAPS[kind]
    whole, count = unwrapped(angle, np.arange(len(angle)) / 125)
    assert count == 0
    np.testing.assert_array_equal(whole, angle)


def robot_rows(low: float, targets: bool | None) -> pd.DataFrame:
    """Rows whose joint 1 wraps; targets: whether they wrap, too, None without them."""
    time = np.arange(3000) / 125
    q = np.array(START) + np.outer(np.sin(time), [3.5, 0.3, 0.2, 0.3, 0.2, 0.4]) + [TURN, *[0] * 5]
    cut = np.column_stack([wrapped(q[:, 0], low), q[:, 1:]])
    columns = {"time": time, **named(cut, "actual_q")}
    if targets is not None:
        columns |= named(cut if targets else q, "target_q")
    return pd.DataFrame(columns)


@pytest.mark.parametrize("low", [0.0, -np.pi])
def test_positions_and_targets_are_in_one_turn(low: float) -> None:
    for targets, turn in ((None, 0.0), (True, 0.0), (False, TURN)):
        table, (note,) = without_wraps(robot_rows(low, targets))
        assert (note.code, note.severity) == (Found.WRAPPED_ANGLES, "note")
        assert said(note) == "angles that wrap around by a whole turn, of joint 1; made continuous"
        q = channel(table, "actual_q")
        assert q[0, 0] == pytest.approx(START[0] + turn)
        assert np.abs(np.diff(q, axis=0)).max() < 0.05
        if targets is not None:
            np.testing.assert_allclose(channel(table, "target_q"), q, atol=1e-9)


def test_a_file_with_angles_from_0_to_360_degrees_is_imported_and_read(
    tmp_path: Path, ur5: Robot
) -> None:
    made = robot_rows(0.0, None)
    q = channel(made, "actual_q")
    rates = np.gradient(np.unwrap(q, axis=0), made["time"], axis=0)
    degrees = {f"position_{k}": np.degrees(np.mod(q[:, k], TURN)) for k in range(6)}
    speeds = {f"velocity_{k}": np.degrees(rates[:, k]) for k in range(6)}
    path = tmp_path / "run.csv"
    pd.DataFrame({"time": made["time"], **degrees, **speeds}).to_csv(path, index=False)
    (found,) = import_files([path], UserStatement("ur5"))
    assert found.entry["units"] == {"actual_q": "deg", "actual_qd": "deg/s"}
    rows = {row.taken_for: row for row in found.account}
    assert "wraps by 360° in columns 1" in rows["actual_q [deg]"].reason
    assert rows["actual_qd [deg/s]"].confidence == "proven"
    taken = read_and_check(found.entry, ur5, 0.1)
    (note,) = (one for one in taken.quality.findings if one.code == Found.WRAPPED_ANGLES)
    assert note.severity == "note"
    cut = np.column_stack([*degrees.values()])
    assert note.count == np.count_nonzero(np.abs(np.diff(cut, axis=0)) > 180)
    assert np.abs(np.diff(channel(taken.robot, "actual_q"), axis=0)).max() < 0.05
