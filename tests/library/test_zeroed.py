"""Cells that a file lost, which read as zeros."""

import numpy as np
import pandas as pd
import pytest

from ur5lib.recordings.plausibility import drop_zeroed
from ur5lib.recordings.quality import Finding

COUNT = 300
NOISE = np.random.default_rng(0).uniform(0.1, 1.0, (COUNT, 6))  # A
CURRENTS = [f"actual_current_{joint}" for joint in range(6)]


def lost(columns: dict[str, np.ndarray]) -> tuple[np.ndarray, int]:
    """Return which cells are not used (N, k), and how many rows are reported; the others stay."""
    findings: list[Finding] = []
    table = pd.DataFrame(columns)
    kept = drop_zeroed(table, findings)
    wrong = kept.isna().to_numpy()
    np.testing.assert_array_equal(kept.to_numpy()[~wrong], table.to_numpy()[~wrong])
    return wrong, sum(finding.count for finding in findings)


@pytest.mark.parametrize("rows", [slice(0, 4), slice(1, 4), slice(120, 121), slice(290, COUNT)])
def test_positions_that_fall_to_zero_were_lost(rows: slice) -> None:
    """Also at the beginning and at the end, and those of one joint only."""
    q = np.linspace(1.0, 2.0, COUNT)
    fallen = q.copy()
    fallen[rows] = 0.0
    wrong, reported = lost({"actual_q_0": q, "actual_q_1": fallen, "actual_q_2": 0 * q})
    np.testing.assert_array_equal(wrong[:, 1], fallen == 0.0)
    assert not wrong[:, [0, 2]].any()
    assert reported == (fallen == 0.0).sum()


def test_rows_that_lost_a_cell_are_counted_once() -> None:
    columns = {f"actual_q_{joint}": np.linspace(1.0, 2.0, COUNT) for joint in range(2)}
    columns["actual_q_0"][10:20] = columns["actual_q_1"][15:30] = 0.0
    assert lost(columns)[1] == 20


def test_a_motion_through_zero_is_received() -> None:
    """And one that rests there for a while."""
    q = 0.01 * np.concatenate([np.arange(-100, 0), np.zeros(100), np.arange(100)])
    assert not lost({"actual_q_0": q})[0].any()


@pytest.mark.parametrize("beside", [5.0, 5.1])
def test_a_leap_is_more_than_five_usual_steps(beside: float) -> None:
    """Of values that change by one each time; some that are no numbers of a robot do not count."""
    column = beside + np.arange(COUNT) % 2.0
    column[100:110] = 0.0
    column[[99, 110]] = beside
    column[200:210] = 1e300
    wrong, _ = lost({"tool_acceleration": column})
    np.testing.assert_array_equal(wrong[:, 0], (column == 0.0) & (beside > 5.0))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("first", [1, 100])
def test_a_leap_on_one_side_is_enough(first: int, turned: bool) -> None:
    """The values slowly leave zero on the other side."""
    q = np.concatenate([np.ones(first), np.zeros(10), 1e-3 * np.arange(1, COUNT - first - 9)])
    q = q[::-1] if turned else q
    np.testing.assert_array_equal(lost({"actual_q_0": q})[0][:, 0], q == 0.0)


@pytest.mark.parametrize(("speed", "gone"), [(0.09, False), (0.11, True)])
def test_slow_velocities_are_rounded_to_zero(speed: float, gone: bool) -> None:
    values = np.full(COUNT, speed)
    values[100:110] = 0.0
    wrong, _ = lost({"actual_qd_0": values, "actual_q_0": values})
    assert wrong[:, 0].sum() == 10 * gone
    assert wrong[:, 1].sum() == 10


def test_stray_bytes_are_no_values() -> None:
    values = np.tile([-1e-60, 1e-50, 1.5e-50, 1e-45, 1.0], COUNT // 5)
    np.testing.assert_array_equal(lost({"actual_q_0": values})[0][:, 0], np.abs(values) < 1e-50)


@pytest.mark.parametrize("rows", [4, 5])
def test_a_current_of_zero_for_five_rows_was_lost(rows: int) -> None:
    """But not those of a joint that has none at all."""
    currents = NOISE.copy()
    currents[100 : 100 + rows, 2] = currents[:, 5] = 0.0
    wrong, _ = lost(dict(zip(CURRENTS, currents.T, strict=True)))
    expected = np.zeros_like(wrong)
    expected[100 : 100 + rows, 2] = rows == 5
    np.testing.assert_array_equal(wrong, expected)


@pytest.mark.parametrize("rows", [49, 50])
def test_an_arm_without_power_has_no_current_for_long(rows: int) -> None:
    """For fifty rows and more; for fewer, all six were lost."""
    currents = NOISE.copy()
    currents[100 : 100 + rows] = 0.0
    wrong, reported = lost(dict(zip(CURRENTS, currents.T, strict=True)))
    np.testing.assert_array_equal(wrong, (currents == 0.0) & (rows < 50))
    assert reported == (rows if rows < 50 else 0)
