"""Motion of the end effector from the joints, beside the dynamics' own; and its IMU's record."""

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from tests.smoothing.test_smoothing import POINT, Motion, kinematics, random_states
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import acceleration, velocity
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Mounting, Robot
from ur5lib.robots.end_effector import (
    euler_acceleration,
    felt_acceleration,
    point_acceleration,
    point_velocity,
)
from ur5lib.signals.clock import clock_from_stamps
from ur5lib.signals.device_clock import device_clock
from ur5lib.signals.imu_calibration import ImuRecord
from ur5lib.signals.imu_samples import imu_samples
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth
from ur5lib.timeseries.sampling import interpolated

PERIOD = 0.008
GRAVITY = np.array([0.1, -0.2, -9.8])


def swings(count: int, period: float = PERIOD) -> tuple[Array, Motion]:
    """Time (N,), and q, q̇, q̈ of slow swings about a pose."""
    time = period * np.arange(float(count))
    pace, phase = np.array([0.5, 0.7, 0.9, 1.1, 0.8, 0.6]), np.arange(6.0)
    angle = pace * time[:, None] + phase
    home = np.array([0.3, -1.2, 1.1, -0.9, 1.4, 0.2])
    return time, (
        home + 0.4 * np.sin(angle),
        0.4 * pace * np.cos(angle),
        -0.4 * pace**2 * np.sin(angle),
    )


def of_point(ur5: Robot, motion: Motion, point: Array) -> tuple[Array, Array]:
    """Velocity and acceleration (N, 6) of a point of frame 6, by recursion over the links."""
    arm, place = build_arm(ur5, "C"), torch.from_numpy(point)
    q, qd, qdd = (torch.from_numpy(values.copy()) for values in motion)
    resting = acceleration(arm, q, 0 * qd, qd, 6, place).numpy()  # J q̇, as without velocity
    return resting, acceleration(arm, q, qd, qdd, 6, place).numpy()


@pytest.mark.parametrize("point", [np.zeros(3), POINT, np.array([0.1, -0.2, 0.3])])
def test_a_point_moves_as_the_dynamics_have_it(ur5: Robot, point: Array) -> None:
    motion = random_states()
    R, J = kinematics(ur5, motion[0])
    moving, accelerated = of_point(ur5, motion, point)
    np.testing.assert_allclose(point_velocity(R, J, motion[1], point), moving, atol=1e-12)
    found = point_acceleration(R, J, motion[1], motion[2], point)
    np.testing.assert_allclose(found, accelerated, atol=1e-12)
    arm = build_arm(ur5, "C")
    q, qd = (torch.from_numpy(values.copy()) for values in motion[:2])
    np.testing.assert_allclose(moving[:, 3:], velocity(arm, q, qd)[:, 3:].numpy(), atol=1e-12)


def test_what_an_imu_feels_is_turned_and_freed_of_gravity() -> None:
    random = np.random.default_rng(0)
    rotation = Rotation.random(20, random_state=0).as_matrix()
    motion, turning, up = *random.normal(size=(2, 20, 3)), np.array([0.1, 0.2, 9.8])
    felt = np.einsum("nji,nj->ni", rotation, motion + up)
    own = np.einsum("nji,nj->ni", rotation, turning)
    found = felt_acceleration(rotation, felt, own, up)
    np.testing.assert_allclose(found, np.concatenate([motion, turning], axis=1), atol=1e-12)


@pytest.mark.parametrize("printed", [False, True])
def test_euler_angles_accelerate_as_their_rates_change(ur5: Robot, printed: bool) -> None:
    """ω = B (φ̇, ϑ̇, ψ̇) for z, y', z'' in turn; as printed, with ψ in the place of φ."""
    time, (q, qd, qdd) = swings(500, 0.002)
    R, J = kinematics(ur5, q)
    found = euler_acceleration(R, J, qd, qdd, np.zeros(500, int), 0.002, printed)
    phi, theta, psi = Rotation.from_matrix(R).as_euler("ZYZ").T
    first = psi if printed else phi
    about_z = np.tile([0.0, 0.0, 1.0], (500, 1))
    about_y = np.column_stack([-np.sin(first), np.cos(first), 0 * first])
    tip = np.column_stack(
        [np.cos(first) * np.sin(theta), np.sin(first) * np.sin(theta), np.cos(theta)]
    )
    B = np.stack([about_z, about_y, tip], axis=2)
    twist = (J @ qd[..., None])[..., 0]
    rates = np.linalg.solve(B, twist[:, 3:, None])[..., 0]
    if not printed:
        angles = np.unwrap(np.stack([phi, theta, psi], axis=1), axis=0)
        np.testing.assert_allclose(np.gradient(angles, time, axis=0)[1:-1], rates[1:-1], atol=1e-4)
    change = np.gradient(np.concatenate([twist[:, :3], rates], axis=1), time, axis=0)
    np.testing.assert_allclose(found[2:-2], change[2:-2], atol=2e-4)


def readings(ur5: Robot, motion: Motion) -> Array:
    """Specific force and angular rate (N, 6) of an IMU along frame 6."""
    R, _ = kinematics(ur5, motion[0])
    moving, accelerated = of_point(ur5, motion, POINT)
    force = np.einsum("nji,nj->ni", R, accelerated[:, :3] - GRAVITY)
    return np.concatenate([force, np.einsum("nji,nj->ni", R, moving[:, 3:])], axis=1)


def sampled(
    ur5: Robot, recorded: tuple[Array, ...], readings: Array, place: Array, design: Butterworth
) -> ImuRecord:
    """Samples of joints and an IMU; recorded: time, segment and q, place: of the IMU [m]."""
    time, segment, q = recorded
    R, J = kinematics(ur5, q)
    ones, zeros = np.ones(len(time)), np.zeros((len(time), 3))
    frames = Kinematics(
        time=time, origin=zeros, rotation=R, jacobian=J, smallest_singular_value=ones
    )
    signals = Signals(
        time=time, segment=segment.astype(np.int64), interpolated=ones == 0, actual_q=q,
        accelerometer=readings[:, :3], gyroscope=readings[:, 3:],
    )  # fmt: skip
    robot = ur5.model_copy(update={"mounting": Mounting(imu=tuple(place))}).mounted(GRAVITY)
    return imu_samples(robot, signals, frames, design)


def test_a_record_holds_predictions_and_readings_alike(ur5: Robot) -> None:
    """Of slow swings, that a low-pass leaves; without the ends, and without what is missing."""
    time, motion = swings(1500)
    segment = np.repeat([0, 1], [700, 800])
    felt = readings(ur5, motion)
    felt[1000] = np.nan
    design = Butterworth(order=4, cutoff=5.0)
    record = sampled(ur5, (time, segment, motion[0]), felt, POINT, design)
    assert 0.5 < len(record.time) / 1500 < 0.95
    assert (np.diff(record.time) > 0).all()
    rows = np.round(record.time / PERIOD).astype(int)
    assert not np.isin([0, 699, 700, 1000, 1499], rows).any()
    np.testing.assert_array_equal(record.rotation, kinematics(ur5, motion[0])[0][rows])
    np.testing.assert_array_equal(record.gravity, GRAVITY)
    for found, exact in (
        (record.specific_force, felt[rows, :3]),
        (record.accelerometer, felt[rows, :3]),
        (record.angular_rate, felt[rows, 3:]),
        (record.gyroscope, felt[rows, 3:]),
    ):
        np.testing.assert_allclose(found, exact, atol=5e-3)


def test_a_gyroscope_tells_the_clock_of_its_device(ur5: Robot) -> None:
    """Whose axes are those of frame 6; a device without one has its stamps."""
    time, motion = swings(3000)
    own = np.arange(0, 23.0, 1 / 200)
    late = 0.06
    rate = readings(ur5, motion)[:, 3:]
    gyroscope = interpolated(own + late, time, rate)
    robot = time, np.zeros(3000, int), motion[0]
    start = clock_from_stamps(0.0, 0.05)
    clock, reason = device_clock(own, gyroscope, start, robot, kinematics(ur5, motion[0]))
    assert reason is None
    assert clock.offset == pytest.approx(late, abs=1e-3)
    assert clock.drift == pytest.approx(0.0, abs=1e-4)
    without, reason = device_clock(own, None, start, robot, kinematics(ur5, motion[0]))
    assert (without.offset, without.offset_std, without.drift, reason) == (0.0, 0.05, None, None)
