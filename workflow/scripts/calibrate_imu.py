"""Mounting, tilt and gyroscope bias of an arm's IMU, from its recordings for fitting."""

from typing import Any

import numpy as np
import pandas as pd

from ur5lib.robots.description import Robot, load_robot
from ur5lib.signals.imu_calibration import ImuRecord, calibrate_without_each
from ur5lib.signals.imu_record import has_valid_imu, imu_record
from ur5lib.steps import run_step
from ur5lib.tables import read_json, read_table, write_json


def calibrate_imu(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    recordings = zip(
        params.recordings,
        params.gravities,
        input.signals,
        input.kinematics,
        input.clocks,
        strict=True,
    )
    records = {
        name: record_of(robot.mounted(gravity), read_table(signals), read_table(kinematics), params)
        for name, gravity, signals, kinematics, clocks in recordings
        if has_valid_imu(read_json(clocks))
    }
    write_json(calibrate_without_each(records), output.calibration)


def record_of(
    robot: Robot, signals: pd.DataFrame, kinematics: pd.DataFrame, params: Any
) -> ImuRecord:
    """What the IMU of an arm and its joints tell, low-passed alike."""
    place = np.array(robot.mounting.imu), np.array(robot.gravity)
    return imu_record(signals, kinematics, *place, params.order, params.cutoff_hz)


if __name__ == "__main__":
    run_step(calibrate_imu, snakemake)  # type: ignore[name-defined]  # noqa: F821
