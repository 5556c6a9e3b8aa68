"""What two runs of one path leave of an error."""

import numpy as np
import pytest

from ur5lib.identification.repetition import PathRun, path_run, repetition
from ur5lib.records.motion import Motion
from ur5lib.records.repetition import Repeated
from ur5lib.timeseries.arrays import Array

PERIOD = 0.01  # s
TIME = PERIOD * np.arange(2000)
NOISE = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])


def motion(turn: float = 1.0, start: float = 0.0) -> Motion:
    """A joint turns to and fro; start: [s], later on the same path."""
    phase = 2 * np.pi * (TIME + start) / 10
    q, qd = np.zeros((2, len(TIME), 6))
    q[:, 0], qd[:, 0] = turn * np.sin(phase), turn * np.cos(phase) * 2 * np.pi / 10
    same = {name: np.zeros_like(q) for name in ("qdd", "q_std", "qd_std", "qdd_std")}
    segment = np.zeros(len(TIME), np.int64)
    return Motion(time=TIME, segment=segment, q=q, qd=qd, motor_qd=qd, **same)


def by_motion(moved: Motion) -> Array:
    """An error that the state of motion determines."""
    return 5 * moved.q[:, :1] + 3 * moved.qd[:, :1] + np.zeros(6)


def run(seed: int, moved: Motion) -> PathRun:
    noise = NOISE * np.random.default_rng(seed).standard_normal((len(TIME), 6))
    error = by_motion(moved) + noise
    return path_run(moved, {"current": error, "force": error[:, :3], "torque": None})


def floors(rows: list[Repeated], quantity: str) -> list[float]:
    return [row.floor for row in rows if row.quantity == quantity]


def test_what_the_motion_explains_is_no_part_of_the_floor() -> None:
    """Though it is most of the error, and the second run begins later on the path."""
    rows = [*repetition([run(0, motion()), run(1, motion(start=3.0))])]
    assert floors(rows, "current") == pytest.approx(NOISE, rel=0.1)
    assert floors(rows, "force") == pytest.approx(NOISE[:3] * np.sqrt(2 / np.pi), rel=0.1)
    assert floors(rows, "torque") == []
    assert [row.component for row in rows if row.quantity == "force"] == ["Fx", "Fy", "Fz"]
    assert all(row.error > 3 for row in rows if row.quantity == "current")
    assert {row.paths for row in rows} == {1}


def test_runs_without_noise_leave_nothing() -> None:
    moved = motion()
    same = [path_run(moved, {"current": by_motion(moved)}) for _ in range(3)]
    assert floors([*repetition(same)], "current") == pytest.approx([0.0] * 6, abs=1e-12)


def test_other_paths_tell_nothing() -> None:
    assert [*repetition([run(0, motion()), run(1, motion(turn=0.5))])] == []
    assert [*repetition([run(0, motion())])] == []


def test_a_quantity_of_one_run_alone_has_no_floor() -> None:
    moved = motion()
    torque = path_run(moved, {"current": by_motion(moved), "torque": by_motion(moved)})
    for runs in ([torque, run(1, moved)], [run(1, moved), torque]):
        assert {row.quantity for row in repetition(runs)} == {"current"}
