"""The end effector's acceleration through Euler angles, as in Section 5.5 of the thesis."""

from functools import partial

import numpy as np

from ur5lib.records.dynamics import Kinematics
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.robots.end_effector import euler_acceleration, felt_acceleration
from ur5lib.signals.imu_calibration import NOMINAL_CALIBRATION
from ur5lib.signals.imu_samples import derivative, lowpassed
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, causal_lowpass

CAUSAL = Butterworth(8, 4.7)  # N_b and Ω_c of Equation 5.12, which is Hz (erratum 4)
EULER = {"euler": True, "euler, B corrected": False}  # by name: is Equation 2.33 used as printed?


def by_euler_angles(
    robot: Robot, signals: Signals, kinematics: Kinematics, by_stamps: Array
) -> tuple[Array, dict[str, Array]]:
    """Return accelerations (N, 6) by the IMU and through Euler angles, as in the thesis.

    The IMU is not calibrated and counts as at the origin of frame 6, the filter is causal, and
    angles are by Equation 2.33 as printed and as corrected. robot: under the recording's gravity;
    by_stamps: the IMU's reading (N, 6), placed by its start stamp.
    """
    up = NOMINAL_CALIBRATION.up(np.array(robot.gravity))
    turning = derivative(signals, by_stamps[:, 3:])
    felt = felt_acceleration(kinematics.rotation, by_stamps[:, :3], turning, up)
    smooth = partial(lowpassed, signals, causal_lowpass, CAUSAL)
    angles = {
        name: smooth(through_angles(signals, kinematics, printed))
        for name, printed in EULER.items()
    }
    return smooth(felt), angles


def through_angles(signals: Signals, kinematics: Kinematics, printed: bool) -> Array:
    """Return the acceleration through Euler angles (N, 6), without a filter.

    printed: whether Equation 2.33 is used as printed.
    """
    qd = signals.actual_qd
    if qd is None:
        qd = derivative(signals, signals.actual_q)
    frames, qdd = (kinematics.rotation, kinematics.jacobian), derivative(signals, qd)
    return euler_acceleration(*frames, qd, qdd, signals.segment, signals.period, printed)
