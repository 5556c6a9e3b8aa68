"""Acceleration of the end effector: from joints, through Euler angles, and from an IMU."""

from functools import partial
from typing import Any

from ur5lib.pipeline.clocks import by_stamps
from ur5lib.pipeline.end_effector import (
    BesideImu,
    acceleration_errors,
    at_the_imu,
    by_range,
    compared,
    differences,
)
from ur5lib.pipeline.imu_samples import has_valid_imu
from ur5lib.pipeline.smoothed_motion import measured
from ur5lib.recordings.quality import Quality
from ur5lib.records.accelerations import Accelerations, ImuComparison
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import FusedMotion, Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.signals.imu_calibration import ImuCalibration, calibration_for
from ur5lib.smoothing.plain_filter import FilteredMotion, filter_encoders
from ur5lib.tables import read_record, read_table, write_json
from ur5lib.timeseries.lowpass import Butterworth


def compare_accelerations(input: Any, output: Any, params: Any) -> None:
    signals, robot = Signals.read(input.signals), load_robot(input.arm)
    accelerations = Accelerations(time=signals.time, segment=signals.segment)
    compared_with_imu = ImuComparison()
    if has_valid_imu(read_record(dict[str, SettledClock], input.clocks)):
        design = Butterworth(params.order, params.cutoff_hz)
        known = read_record(dict[str, ImuCalibration], input.calibration)
        calibration = calibration_for(params.recording, known)
        motion, fused = Motion.read(input.motion), FusedMotion.read(input.fused)
        motions: dict[str, Motion | FilteredMotion] = {
            "encoders": motion,
            "encoders+imu": fused,
            "filterpy": filter_encoders(signals.segment, *measured(signals), signals.period),
        }
        start = read_record(Quality, input.quality).starts["imu"]
        placed = by_stamps(read_table(input.imu), start, signals.time, "imu")
        kinematics = Kinematics.read(input.kinematics)
        modelled = at_the_imu(robot, kinematics, motions, calibration)
        arm = robot.mounted(params.gravity)
        own = BesideImu(arm, signals, kinematics, modelled, calibration)
        accelerations, bias = compared(own, design, placed)
        ranged = {"ranges": modelled["encoders"], "plain_ranges": modelled["filterpy"]}
        compared_with_imu = ImuComparison(
            errors=acceleration_errors(accelerations),
            calibrated_on=[*calibration.from_],
            accelerometer_bias=bias,
            **by_range(partial(differences, own._replace(modelled=ranged)), motion.qd),
        )
    accelerations.write(output.accelerations)
    write_json(compared_with_imu, output.summary)
