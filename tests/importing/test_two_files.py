"""A sensor's file beside the robot's: clocks are matched by efforts and forces, and said."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.checks.test_commanded import CONSTANTS, motion
from tests.entries import read_recording
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import geometric_jacobian, link_frames
from ur5lib.tables import channel, named

LATE, FAST = 0.84, 800e-6  # s, and share, of the sensor's clock


def write(folder: Path, pushed: bool = True) -> tuple[Path, Path]:
    """The files of a pushed UR5e, and of a sensor that starts later, on another clock."""
    arm = load_robot(robot_path("ur5e"))
    table, gravity, rubbing = motion(arm)
    time, q = table["time"].to_numpy(), channel(table, "actual_q")
    draw = np.random.default_rng(3)
    force = np.zeros((len(time), 6))
    for start in (3.0, 8.0, 14.0, 19.0):
        shape = np.clip(1 - np.abs(time - start - 0.7) / 0.7, 0, 1)[:, None]
        force[:, :3] += 40 * shape * draw.normal(size=3) * pushed
    rotation = link_frames(arm, q)[0][:, -1]
    torque = np.einsum("nij,ni->nj", geometric_jacobian(arm, q), force)
    currents = named((gravity + rubbing - torque) / CONSTANTS, "actual_current")
    robot = table.drop(columns=["segment", "interpolated"]).assign(**currents)
    robot.rename(columns={"time": "timestamp"}).to_csv(folder / "robot.csv", index=False)
    own = np.arange(LATE, time[-1], 0.002)
    halves = np.einsum("nji,nkj->nki", rotation, force.reshape(-1, 2, 3)).reshape(-1, 6)
    rows = np.stack([np.interp(own, time, column) for column in halves.T], axis=1) + 3.0
    clock = 77.0 + (own - LATE) / (1 + FAST)
    sensor = pd.DataFrame(rows, columns=["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"])
    sensor.insert(0, "time", clock)
    sensor.to_csv(folder / "sensor.csv", index=False)
    return folder / "robot.csv", folder / "sensor.csv"


@pytest.mark.parametrize("named_by_option", [True, False])
def test_two_files_are_one_recording(tmp_path: Path, named_by_option: bool) -> None:
    robot, sensor = write(tmp_path)
    stated = UserStatement("ur5e", sensor=sensor if named_by_option else None)
    (found,) = import_files([robot] if named_by_option else [robot, sensor], stated)
    assert found.entry["role"] == "contact"
    part = found.entry["force_sensor"]
    assert part["offset_s"] == pytest.approx(LATE, abs=0.03)
    assert "opposite" not in str(part)
    (row,) = (row for row in found.account if row.subject == "force sensor")
    assert "its first sample is" in row.reason
    raw = read_recording(found.entry)
    assert raw.sensors["force"].table["time"].iloc[0] == pytest.approx(part["offset_s"])


def test_a_sensor_that_no_effort_follows_is_refused_with_a_remedy(tmp_path: Path) -> None:
    robot, sensor = write(tmp_path)
    table = pd.read_csv(sensor)
    rest = np.random.default_rng(1).normal(size=(len(table), 6))
    table.iloc[:, 1:] = rest
    table.to_csv(sensor, index=False)
    found = import_files([robot, sensor], UserStatement("ur5e"))
    assert [one.entry["name"] for one in found] == ["robot"]
    assert "has a force and no positions" in found.refused[0]
    with pytest.raises(InputError, match="has a force and no positions"):
        import_files([robot], UserStatement("ur5e", sensor=sensor))
