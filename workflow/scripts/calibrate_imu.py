"""Mounting, tilt and gyroscope bias of an arm's IMU, from its recordings for fitting."""

from typing import Any

import numpy as np

from ur5lib.robots.description import load_robot
from ur5lib.signals.imu_calibration import calibrate_without_each
from ur5lib.signals.imu_record import has_valid_imu, imu_record
from ur5lib.steps import run_step
from ur5lib.tables import read_json, read_table, write_json


def calibrate_imu(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    place = np.array(robot.mounting.imu), np.array(robot.gravity)
    recordings = zip(params.recordings, input.signals, input.kinematics, input.clocks, strict=True)
    records = {
        name: imu_record(
            read_table(signals), read_table(kinematics), *place, params.order, params.cutoff_hz
        )
        for name, signals, kinematics, clocks in recordings
        if has_valid_imu(read_json(clocks))
    }
    write_json(calibrate_without_each(records), output.calibration)


if __name__ == "__main__":
    run_step(calibrate_imu, snakemake)  # type: ignore[name-defined]  # noqa: F821
