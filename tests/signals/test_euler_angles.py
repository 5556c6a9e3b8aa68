"""The end effector's acceleration as in the thesis: of an ideal IMU, and through Euler angles."""

import numpy as np
import pytest

from tests.robots.test_end_effector import GRAVITY, PERIOD, of_point, swings
from tests.smoothing.test_smoothing import kinematics
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.signals.euler_angles import CAUSAL, by_euler_angles
from ur5lib.timeseries.lowpass import causal_lowpass

SEGMENT = np.repeat([0, 1], [700, 800])


@pytest.mark.parametrize("recorded", [False, True])  # the velocities
def test_imu_and_euler_angles_show_the_motion_through_the_thesis_s_filter(
    ur5: Robot, recorded: bool
) -> None:
    """From rest in each segment, near the start of which differences of positions err most."""
    time, motion = swings(len(SEGMENT))
    q, qd, _ = motion
    R, J = kinematics(ur5, q)
    moving, accelerated = of_point(ur5, motion, np.zeros(3))
    felt = [accelerated[:, :3] - GRAVITY, moving[:, 3:]]
    reading = np.concatenate([np.einsum("nji,nj->ni", R, part) for part in felt], axis=1)
    signals = Signals(
        time=time, segment=SEGMENT, interpolated=time < 0, actual_q=q,
        actual_qd=qd if recorded else None,
    )  # fmt: skip
    frames = Kinematics(
        time=time, origin=felt[0], rotation=R, jacobian=J, smallest_singular_value=1 + 0 * time
    )
    of_imu, by_angles = by_euler_angles(ur5.mounted(GRAVITY), signals, frames, reading)
    parts = [accelerated[k == SEGMENT] for k in (0, 1)]
    expected = np.concatenate([causal_lowpass(part, 1 / PERIOD, *CAUSAL) for part in parts])
    np.testing.assert_allclose(of_imu, expected, atol=0.02)
    for found in by_angles.values():
        np.testing.assert_allclose(found[:, :3], expected[:, :3], atol=0.02)
