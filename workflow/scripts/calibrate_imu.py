"""Mounting, tilt and gyroscope bias of an arm's IMU, from its `fit` recordings."""

from typing import Any

from ur5lib.pipeline.imu_samples import all_imu_samples
from ur5lib.robots.description import load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.signals.imu_calibration import calibrate_without_each
from ur5lib.tables import read_record, write_json
from ur5lib.timeseries.lowpass import Butterworth


def calibrate_imu(input: Any, output: Any, params: Any) -> None:
    recordings = zip(
        params.recordings,
        params.gravities,
        input.signals,
        input.kinematics,
        [read_record(dict[str, SettledClock], path) for path in input.clocks],
        strict=True,
    )
    design = Butterworth(params.order, params.cutoff_hz)
    records = all_imu_samples(load_robot(input.arm), recordings, design)
    write_json(calibrate_without_each(records), output.calibration)
