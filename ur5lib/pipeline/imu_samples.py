"""Samples of a recording's IMU and joints for the calibration."""

from collections.abc import Iterable, Mapping

import numpy as np

from ur5lib.pipeline.records.dynamics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.signals.clock import BY_HOST, BY_MOTION, Clock
from ur5lib.signals.imu_calibration import ImuRecord
from ur5lib.signals.imu_record import imu_record
from ur5lib.timeseries.lowpass import Butterworth


def has_valid_imu(clocks: Mapping[str, Clock]) -> bool:
    """Return whether a recording has an IMU with a clock that motion or its host's stamps show."""
    return "imu" in clocks and clocks["imu"].method in (BY_MOTION, BY_HOST)


def imu_samples(
    robot: Robot, signals: Signals, kinematics: Kinematics, design: Butterworth
) -> ImuRecord:
    """Return joints and IMU, low-passed alike; robot: under the recording's gravity."""
    return imu_record(
        signals.time,
        signals.segment,
        signals.actual_q,
        (kinematics.rotation, kinematics.jacobian),
        signals.imu,
        (np.array(robot.mounting.imu), np.array(robot.gravity)),
        design,
    )


def all_imu_samples(
    robot: Robot,
    recordings: Iterable[tuple[str, list[float] | None, str, str, Mapping[str, Clock]]],
    design: Butterworth,
) -> dict[str, ImuRecord]:
    """Return the same of each recording with a valid IMU, by name.

    recordings: name, gravity, paths of signals and kinematics, and the devices' clocks.
    """
    return {
        name: imu_samples(
            robot.mounted(gravity), Signals.read(signals), Kinematics.read(kinematics), design
        )
        for name, gravity, signals, kinematics, clocks in recordings
        if has_valid_imu(clocks)
    }
