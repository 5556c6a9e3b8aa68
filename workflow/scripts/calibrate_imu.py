"""Mounting, tilt and gyroscope bias of an arm's IMU, from its `fit` recordings."""

from typing import Any

from ur5lib.pipeline.imu_samples import has_valid_imu, imu_samples
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.signals.imu_calibration import calibrate_without_each
from ur5lib.tables import read_record, write_json
from ur5lib.timeseries.lowpass import Butterworth


def calibrate_imu(input: Any, output: Any, params: Any) -> None:
    robot, design = load_robot(input.arm), Butterworth(params.order, params.cutoff_hz)
    known = zip(params.recordings, params.gravities, input.clocks, strict=True)
    files = zip(known, input.signals, input.kinematics, strict=True)
    records = {
        name: imu_samples(
            robot.mounted(gravity), Signals.read(signals), Kinematics.read(kinematics), design
        )
        for (name, gravity, clocks), signals, kinematics in files
        if has_valid_imu(read_record(dict[str, SettledClock], clocks))
    }
    write_json(calibrate_without_each(records), output.calibration)
