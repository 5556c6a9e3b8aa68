"""Extended Kalman filter, smoother, noise and the IMU's equation."""

import tracemalloc
from collections import deque
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy import signal
from scipy.linalg import solve_continuous_lyapunov
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import acceleration, jacobian, link_frames, velocity
from ur5lib.robots.description import Robot
from ur5lib.smoothing.encoders import (
    SmoothedJoints,
    SmoothedMotion,
    encoder_system,
    smooth_encoders,
)
from ur5lib.smoothing.imu_fusion import (
    ALL_STATES,
    LinearImu,
    add_imu,
    imu_noise,
    linearise_imu,
    smooth_with_imu,
)
from ur5lib.smoothing.noise import (
    EncoderNoise,
    encoder_noise,
    motion_step,
    moving_mean,
    quantum,
)
from ur5lib.timeseries import kalman
from ur5lib.timeseries.kalman import LinearSystem, System, innovation_test, smooth

PERIOD, SAMPLES = 0.008, 3000
POINT = np.array([0.01735, 0.00605, 0.0095])
AXES = Rotation.from_rotvec([-0.009, -0.002, 0.002]).as_matrix()
UP = np.array([0.02, -0.01, 9.81])
# Of the UR5's recordings: steps of the encoders, noise, and how late velocities are.
STEP = np.repeat([4.8e-5, 1.6e-5], 3)
POSITION, VELOCITY = np.repeat([6e-5, 1e-4], 3), np.repeat([4e-3, 1.4e-2], 3)
LAG = np.repeat([2e-3, 0], 3)
IMU_NOISE = np.repeat([0.1, 0.01], 3)
IMU_BIAS = np.array([0.03, -0.05, 0.02, -0.031, 0.024, 0.027])

Motion = tuple[np.ndarray, np.ndarray, np.ndarray]


def joint_moves(random: np.random.Generator, samples: int = SAMPLES, ramp: float = 0.04) -> Motion:
    """q, q̇, q̈ of synchronised moves with trapezoidal speed, as `movej` makes them, and rests.

    The accelerations rise and fall in `ramp` seconds.
    """
    fine, fastest, hardest = 20, 1.05, 1.4  # samples a period, rad/s, rad/s²
    step = PERIOD / fine
    qdd, at = np.zeros((samples * fine, 6)), round(0.5 / step)
    while True:
        way = random.uniform(-1.5, 1.5, 6)
        longest = np.abs(way).max()
        rise = min(fastest / hardest, np.sqrt(longest / hardest))
        rising, moving = round(rise / step), round((longest / (hardest * rise) + rise) / step)
        if at + moving > len(qdd) - fine * 10:
            break
        qdd[at : at + rising] = hardest * way / longest
        qdd[at + moving - rising : at + moving] = -hardest * way / longest
        at += moving + round(random.uniform(0, 1.6) / step)
    qdd = signal.lfilter(np.full(round(ramp / step), step / ramp), 1, qdd, axis=0) if ramp else qdd
    qd = np.cumsum(qdd, axis=0) * step
    q = np.cumsum(qd, axis=0) * step + [0.3, -1.2, 1.1, -0.9, 1.4, 0.2]
    return q[::fine], qd[::fine], qdd[::fine]


def encoders(random: np.random.Generator, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    q, qd, qdd = motion
    rounded = np.round((q + POSITION * random.normal(size=q.shape)) / STEP) * STEP
    return rounded, qd - LAG * qdd + VELOCITY * random.normal(size=q.shape)


def kinematics(robot: Robot, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    arm = build_arm(robot, "C")
    positions = torch.from_numpy(q.copy())
    return link_frames(arm, positions)[0][:, 6].numpy(), jacobian(arm, positions).numpy()


def true_readings(robot: Robot, motion: Motion) -> np.ndarray:
    """Specific force and angular rate, without bias or noise, by the dynamics' own kinematics."""
    arm = build_arm(robot, "C")
    q, qd, qdd = (torch.from_numpy(values.copy()) for values in motion)
    linear = acceleration(arm, q, qd, qdd, 6, torch.from_numpy(POINT))[:, :3].numpy() + UP
    angular = velocity(arm, q, qd)[:, 3:].numpy()
    to_sensor = AXES.T @ kinematics(robot, motion[0])[0].swapaxes(1, 2)
    return np.concatenate([np.einsum("nij,nj->ni", to_sensor, x) for x in (linear, angular)], 1)


def model_at(robot: Robot, q: np.ndarray, qd: np.ndarray) -> LinearImu:
    return linearise_imu(*kinematics(robot, q), qd, POINT, AXES, UP)


def model_of(robot: Robot, q: np.ndarray, qd: np.ndarray, rows: slice) -> LinearImu:
    return model_at(robot, q[rows], qd[rows])


def clock(samples: int) -> tuple[np.ndarray, np.ndarray]:
    return np.arange(samples) * PERIOD, np.zeros(samples, dtype=np.int64)


@pytest.fixture(scope="module")
def truth() -> Motion:
    return joint_moves(np.random.default_rng(1))


@pytest.fixture(scope="module")
def measured(truth: Motion) -> tuple[np.ndarray, np.ndarray]:
    return encoders(np.random.default_rng(2), truth)


@pytest.fixture(scope="module")
def by_encoders(measured: tuple[np.ndarray, np.ndarray]) -> SmoothedJoints:
    return smooth_encoders(*clock(SAMPLES), *measured)


@pytest.fixture(scope="module")
def by_both(
    ur5: Robot,
    truth: Motion,
    measured: tuple[np.ndarray, np.ndarray],
    by_encoders: SmoothedJoints,
) -> SmoothedMotion:
    noise = np.random.default_rng(3).normal(size=(SAMPLES, 6))
    readings = true_readings(ur5, truth) + IMU_BIAS + IMU_NOISE * noise
    readings[500:600] = np.nan
    model = partial(model_of, ur5, *measured)
    return smooth_with_imu(*clock(SAMPLES), *measured, readings, model, by_encoders.known())


def random_states(count: int = 50) -> Motion:
    random = np.random.default_rng(0)
    return random.uniform(-3, 3, (count, 6)), *random.normal(size=(2, count, 6))


def test_linear_readings_are_exact_at_the_motion_they_belong_to(ur5: Robot) -> None:
    motion = random_states()
    model, nothing = model_at(ur5, *motion[:2]), np.zeros((50, 18))
    predicted, _ = model.predict(np.hstack(motion), nothing, nothing[:, :6])
    np.testing.assert_allclose(predicted, true_readings(ur5, motion), atol=1e-12)


def test_jacobian_of_the_readings(ur5: Robot) -> None:
    """By central differences in q̇ and q̈; q, which is left out, matters less than the noise."""
    q, qd, qdd = random_states()
    H = model_at(ur5, q, qd).H
    for joint in range(6):
        change = 1e-5 * np.eye(6)[joint]
        by_rate = true_readings(ur5, (q, qd + change, qdd))
        by_rate -= true_readings(ur5, (q, qd - change, qdd))
        by_acceleration = true_readings(ur5, (q, qd, qdd + change))
        by_acceleration -= true_readings(ur5, (q, qd, qdd - change))
        np.testing.assert_allclose(H[:, :, 6 + joint], by_rate / 2e-5, atol=1e-7)
        np.testing.assert_allclose(H[:, :, 12 + joint], by_acceleration / 2e-5, atol=1e-7)
    moved = true_readings(ur5, (q + 1e-4, qd, qdd)) - true_readings(ur5, (q, qd, qdd))
    assert np.sqrt(np.mean(moved**2, axis=0)).max() < 0.03 * IMU_NOISE[0]


@pytest.mark.parametrize("step", [0.002, 0.008, 0.024])
def test_a_held_jerk_moves_all_three_together(step: float) -> None:
    """So positions and velocities change by the integral of accelerations, and nothing else."""
    F, driven = motion_step(step, 100.0, 0.1)
    np.testing.assert_allclose(F[:3, :3], [[1, step, step**2 / 2], [0, 1, step], [0, 0, 1]])
    gained = np.array([step**3 / 6, step**2 / 2, step])
    np.testing.assert_allclose(driven[:3, 0], gained / np.sqrt(step))
    assert not F[:3, 3:].any()
    assert not F[3:, :3].any()
    assert not driven[:3, 1].any()
    assert not driven[3:, 0].any()


def test_a_vibration_swings_at_its_frequency_and_dies_away() -> None:
    """The poles of δ: −ω and −ω (ζ ± i sqrt(1 − ζ²))."""
    frequency, damping, step = 2 * np.pi * 17, 0.1, 0.008
    F, driven = motion_step(step, frequency, damping)
    poles = np.sort_complex(np.log(np.linalg.eigvals(F[3:, 3:]).astype(complex)) / step)
    swing = frequency * (-damping + 1j * np.sqrt(1 - damping**2))
    expected = np.sort_complex([-frequency + 0j, swing, swing.conjugate()])
    np.testing.assert_allclose(poles, expected, rtol=1e-9)
    fine = motion_step(step / 1000, frequency, damping)
    state = np.zeros(6)
    for _ in range(1000):
        state = fine[0] @ state + fine[1][:, 1] * np.sqrt(step / 1000)
    np.testing.assert_allclose(driven[:, 1] * np.sqrt(step), state, rtol=1e-9)


def test_smoother_is_weighted_least_squares(ur5: Robot) -> None:
    """Of all states at once, with irregular steps, gaps, missing values, two segments, biases."""
    random, count = np.random.default_rng(4), 24
    motion = tuple(values[600 : 600 + count] for values in joint_moves(random, 700))
    q, qd = encoders(random, motion)
    noise = encoder_noise(*clock(count), q, qd)
    time = np.cumsum(random.uniform(0.004, 0.03, count))
    segment = np.repeat([0, 1], [15, count - 15])
    model = partial(model_of, ur5, q.copy(), qd.copy())
    q[5], qd[7], q[17:20] = np.nan, np.nan, np.nan
    readings = true_readings(ur5, motion)
    readings[8:11] = np.nan
    joints = encoder_system(time, segment, q, qd, noise)
    system = add_imu(joints, time, readings, model, np.tile(IMU_NOISE, (count, 1)))
    states, covariances = smoothed(system, count)

    expected, std = least_squares(system(slice(None)))
    np.testing.assert_allclose((states[:, 0] - expected) / std, 0, atol=1e-4)
    deviations = np.sqrt(np.diagonal(covariances[:, 0], axis1=1, axis2=2))
    np.testing.assert_allclose(deviations, std, rtol=1e-4)


def smoothed(system: System, count: int) -> tuple[np.ndarray, np.ndarray]:
    """States and covariances of all samples."""
    states, covariances = zip(*[part.states for part in smooth(system, count)][::-1], strict=True)
    return np.concatenate(states), np.concatenate(covariances)


def least_squares(system: LinearSystem) -> tuple[np.ndarray, np.ndarray]:
    """States (N, X) and standard deviations of all equations at once, each over its noise's.

    The unknowns are what drives the states, in units of its deviation: states = G unknowns.
    """
    F, Q, H, z, R = (values[:, 0] for values in vars(system).values())
    roots = [driving(covariance) for covariance in Q]
    ends = np.cumsum([root.shape[1] for root in roots])
    G = np.zeros((len(z), F.shape[1], ends[-1]))
    equations, values = [np.eye(ends[-1])], [np.zeros(ends[-1])]
    for k, root in enumerate(roots):
        G[k] = F[k] @ G[k - 1]
        G[k, :, ends[k] - root.shape[1] : ends[k]] = root
        seen = np.isfinite(z[k])
        deviation = np.sqrt(R[k, seen])
        equations.append(H[k, seen] @ G[k] / deviation[:, None])
        values.append(z[k, seen] / deviation)
    orthogonal, triangle = np.linalg.qr(np.vstack(equations))
    G = G @ np.linalg.inv(triangle)
    return G @ (orthogonal.T @ np.concatenate(values)), np.linalg.norm(G, axis=2)


def driving(covariance: np.ndarray) -> np.ndarray:
    """The root (X, rank) of a covariance."""
    scale = np.sqrt(np.diagonal(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = values > 1e-9
    return scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])


def best_differences(values: np.ndarray, times: int, truth: np.ndarray) -> np.ndarray:
    """RMSE (6,) of central differences, low-passed at each joint's best cut-off."""
    for _ in range(times):
        values = np.gradient(values, PERIOD, axis=0)
    designs = [signal.butter(4, f, fs=1 / PERIOD, output="sos") for f in np.geomspace(1, 50, 40)]
    errors = [signal.sosfiltfilt(sos, values, axis=0) - truth for sos in designs]
    return np.sqrt(np.mean(np.square(errors), axis=1)).min(axis=0)


@pytest.fixture(scope="module")
def baseline(truth: Motion, measured: tuple[np.ndarray, np.ndarray]) -> float:
    """The better of both for each joint: from velocities, and twice from positions."""
    of_each = [
        best_differences(measured[1], 1, truth[2]),
        best_differences(measured[0], 2, truth[2]),
    ]
    return float(np.sqrt(np.mean(np.min(of_each, axis=0) ** 2)))


@pytest.mark.parametrize("estimate", ["by_encoders", "by_both"])
def test_accelerations_beat_differences(
    estimate: str, truth: Motion, baseline: float, request: pytest.FixtureRequest
) -> None:
    motion: SmoothedMotion = request.getfixturevalue(estimate)
    assert np.sqrt(np.mean((motion.qdd - truth[2]) ** 2)) < 0.7 * baseline


@pytest.mark.parametrize("ramp", [0.0, 0.1])
def test_accelerations_beat_differences_of_velocities_however_they_rise(ramp: float) -> None:
    random = np.random.default_rng(11)
    truth = joint_moves(random, ramp=ramp)
    q, qd = encoders(random, truth)
    best = best_differences(qd, 1, truth[2])
    error = smooth_encoders(*clock(SAMPLES), q, qd).qdd - truth[2]
    assert np.sqrt(np.mean(error**2)) < 0.7 * np.sqrt(np.mean(best**2))


@pytest.mark.parametrize("estimate", ["by_encoders", "by_both"])
def test_two_standard_deviations_hold_the_truth(
    estimate: str, truth: Motion, request: pytest.FixtureRequest
) -> None:
    motion: SmoothedMotion = request.getfixturevalue(estimate)
    inside = np.abs(motion.state[:, :18] - np.hstack(truth)) < 2 * motion.std[:, :18]
    shares = inside.reshape(SAMPLES, 3, 6).mean(axis=(0, 2))
    assert (shares > 0.90).all()
    assert (shares < 0.99).all()


def typical(noise: EncoderNoise) -> tuple[np.ndarray, np.ndarray]:
    """Root mean squares (6,) over all samples."""
    position, velocity = (
        np.sqrt(np.mean(each**2, axis=0)) for each in (noise.position, noise.velocity)
    )
    return position, velocity


def test_noise_is_found(by_encoders: SmoothedMotion) -> None:
    noise = by_encoders.encoders
    position, velocity = typical(noise)
    np.testing.assert_allclose(position, np.hypot(POSITION, STEP / np.sqrt(12)), rtol=0.1)
    np.testing.assert_allclose(velocity, VELOCITY, rtol=0.1)
    np.testing.assert_allclose(noise.lag, LAG, atol=0.0015)


@pytest.mark.parametrize("missing", [True, False], ids=["frames missing", "short segments"])
def test_noise_is_not_taken_for_less_where_the_record_is_broken(
    missing: bool, measured: tuple[np.ndarray, np.ndarray]
) -> None:
    """Of every fifth frame, or into stretches of three: what is filled in says nothing of noise."""
    count = 1500 if missing else 300
    q, qd = (values[:count].copy() for values in measured)
    time, segment = clock(count)
    if missing:
        q[4::5] = qd[4::5] = np.nan
    else:
        segment = np.arange(count) // 3
    noise = encoder_noise(time, segment, q, qd)
    position, velocity = typical(noise)
    assert 0.9 < np.mean(position / np.hypot(POSITION, STEP / np.sqrt(12))) < 1.15
    assert 0.9 < np.mean(velocity / VELOCITY) < 1.15


def test_biases_are_found(by_both: SmoothedMotion) -> None:
    assert (np.abs(by_both.state[:, 18:] - IMU_BIAS) < 4 * by_both.std[:, 18:]).all()
    assert (by_both.std[:, 18:] < np.repeat([0.01, 0.001], 3)).all()


def test_an_imu_leaves_less_open(by_encoders: SmoothedMotion, by_both: SmoothedMotion) -> None:
    assert (by_both.std[:, 12:18].mean(axis=0) < by_encoders.std[:, 12:].mean(axis=0)).all()


def test_what_is_missing_is_bridged_and_less_sure(
    truth: Motion, measured: tuple[np.ndarray, np.ndarray]
) -> None:
    q, qd = (values[:600].copy() for values in measured)
    whole = smooth_encoders(*clock(600), q, qd)
    q[300:310] = qd[300:310] = np.nan
    motion = smooth_encoders(*clock(600), q, qd, whole.encoders)
    assert (np.abs(motion.q - truth[0][:600]) < 6 * motion.std[:, :6]).all()
    assert (motion.std[305] > whole.std[305]).all()
    assert np.isnan(motion.innovations[300:310]).all()


@pytest.mark.parametrize("rate", [1.0, 2.0, 5.0])
def test_a_recording_is_smoothed_whose_steps_are_longer_than_the_window_of_its_noise(
    rate: float,
) -> None:
    time = np.arange(120) / rate
    random, phase = np.random.default_rng(16), 0.2 * time[:, None] + np.arange(6)
    q, qd = np.sin(phase), 0.2 * np.cos(phase)
    measured = q + 1e-4 * random.normal(size=q.shape), qd + 1e-3 * random.normal(size=q.shape)
    motion = smooth_encoders(time, np.zeros(120, np.int64), *measured)
    np.testing.assert_allclose(motion.q, q, atol=1e-3)
    np.testing.assert_allclose(motion.qdd[5:-5], -0.04 * q[5:-5], atol=0.02)


def test_a_joint_without_velocities_is_refused() -> None:
    with pytest.raises(ValueError, match="no position or no velocity"):
        smooth_encoders(*clock(300), np.zeros((300, 6)), np.full((300, 6), np.nan))


def test_noise_of_an_imu_grows_where_the_arm_shakes() -> None:
    random = np.random.default_rng(5)
    level = np.where(np.arange(2000) < 1000, 0.05, 0.8)[:, None]
    explained = np.full((2000, 1), 0.3**2)
    residual = level * random.normal(size=(2000, 1)) + 7
    residual[1000:] += 0.3 * random.normal(size=(1000, 1))
    noise = imu_noise(*clock(2000), residual, np.where(level > 0.1, explained, 0))
    assert np.median(noise[:900]) == pytest.approx(0.05, rel=0.1)
    assert np.median(noise[1100:]) == pytest.approx(0.8, rel=0.1)


def test_an_imu_is_no_quieter_than_in_its_quietest_twentieth() -> None:
    """Though what the encoders leave open explains all of its residual; in windows of 0.5 s."""
    random = np.random.default_rng(7)
    residual = np.where(np.arange(4000) < 400, 0.1, 0.4)[:, None] * random.normal(size=(4000, 1))
    explained = np.full((4000, 1), 1.0)
    noise = imu_noise(*clock(4000), residual, explained)
    assert np.ptp(noise) == 0
    assert noise[0, 0] == pytest.approx(0.1, rel=0.1)
    sharp = imu_noise(*clock(4000), residual, 0 * explained)[:, 0]
    assert (sharp[:368] < 0.15).all()
    assert (sharp[432:] > 0.25).all()
    assert ((sharp[380:420] > 0.12) & (sharp[380:420] < 0.38)).all()
    hole = residual.copy()
    hole[1000:1200] = np.nan
    np.testing.assert_allclose(
        imu_noise(*clock(4000), hole, 0 * explained)[1300:, 0], sharp[1300:], rtol=0.05
    )


def test_innovations_are_judged_by_their_numbers() -> None:
    """χ² of their count for the variance; ten lags of Ljung and Box, within segments only."""
    random = np.random.default_rng(8)
    values = random.normal(size=(400, 2))
    values[100:110, 1] = np.nan
    segment = np.repeat([0, 1], 200)
    test = innovation_test(values, segment)
    for column, known in ((0, 400), (1, 390)):
        own = values[:, column]
        variance = np.nanmean(own**2)
        assert test.variance[column] == pytest.approx(variance)
        limits = chi2.ppf([0.025, 0.975], known) / known
        np.testing.assert_allclose(test.variance_limits[column], limits)
        total = 0.0
        for lag in range(1, 11):
            product = np.concatenate([part[lag:] * part[:-lag] for part in np.split(own, 2)])
            total += (np.nanmean(product) / variance) ** 2 / (known - lag)
        assert test.portmanteau[column] == pytest.approx(known * (known + 2) * total)
    assert test.portmanteau_limit == pytest.approx(chi2.ppf(0.95, 10))


def test_the_system_is_what_its_equations_say(ur5: Robot) -> None:
    """q⁺ = q + T q̇ + T²/2 q̈ and so on, anew in each segment; encoders with their lag; biases
    that walk across segments by 1 mm/s²/√s and 0.1 mrad/s/√s, known at first to 0.5 and 0.1."""
    count, random = 6, np.random.default_rng(10)
    motion = tuple(values[:count] for values in joint_moves(random, 700))
    q, qd = encoders(random, motion)
    time, segment = np.array([0.0, 0.01, 0.03, 0.04, 0.08, 0.1]), np.repeat([0, 1], 3)
    noise = EncoderNoise(
        jerk=random.uniform(1, 2, (count, 6)),
        vibration=random.uniform(1, 2, (count, 6)),
        frequency=random.uniform(60, 120, 6),
        damping=random.uniform(0.1, 0.5, 6),
        position=random.uniform(1, 2, (count, 6)),
        velocity=random.uniform(3, 4, (count, 6)),
        lag=random.uniform(0, 0.01, 6),
    )
    model, eye = model_at(ur5, q, qd), np.eye(6)
    readings = true_readings(ur5, motion)
    joints = encoder_system(time, segment, q, qd, noise)
    imu = readings, partial(model_of, ur5, q, qd), np.tile(IMU_NOISE, (count, 1))
    system = add_imu(joints, time, *imu)
    F, Q, H, z, R = (values[:, 0] for values in vars(system(slice(None))).values())
    for k in range(count):
        step = time[k] - time[k - 1] if k else 0.008
        joint_steps = [
            motion_step(step, *joint) for joint in zip(noise.frequency, noise.damping, strict=True)
        ]
        fresh = k in (0, 3)
        for joint, (moved, gained) in enumerate(joint_steps):
            own = np.ix_(range(joint, 36, 6), range(joint, 36, 6))
            driven = gained * [noise.jerk[k, joint], noise.vibration[k, joint]]
            expected = np.zeros((6, 6)) if fresh else moved
            np.testing.assert_allclose(F[k][own], expected, atol=1e-9)
            if not fresh:
                np.testing.assert_allclose(Q[k][own], driven @ driven.T, rtol=1e-9, atol=1e-15)
            else:
                np.testing.assert_allclose(np.diag(Q[k][own])[:3], [100.0, 100, 10_000])
                sustained = sustained_vibration(noise.frequency[joint], noise.damping[joint])
                sustained *= noise.vibration[k, joint] ** 2
                scale = np.sqrt(np.outer(np.diag(sustained), np.diag(sustained)))
                np.testing.assert_allclose(Q[k][own][3:, 3:] / scale, sustained / scale, atol=0.02)
        walk = step * np.repeat([1e-6, 1e-8], 3) if k else np.repeat([0.25, 0.01], 3)
        np.testing.assert_allclose(Q[k, 36:, 36:], np.diag(walk))
        np.testing.assert_allclose(F[k, 36:, 36:], eye * bool(k))
        assert not F[k, :36, 36:].any()
        assert not Q[k, :36, 36:].any()
    nothing = 0 * eye
    measured = np.block(
        [
            [eye, nothing, nothing, eye, nothing, nothing],
            [nothing, eye, -np.diag(noise.lag), nothing, nothing, nothing],
        ]
    )
    np.testing.assert_allclose(H[:, :12, :36], np.tile(measured, (count, 1, 1)))
    assert not H[:, :12, 36:].any()
    # the IMU moves with the link: motion and vibration alike
    of_link = np.concatenate([model.H[..., :18], model.H], axis=2)
    np.testing.assert_array_equal(H[:, 12:], of_link)
    np.testing.assert_allclose(z, np.hstack([q, qd, readings - model.offset]))
    deviations = np.hstack([noise.position, noise.velocity, np.tile(IMU_NOISE, (count, 1))])
    np.testing.assert_allclose(R, deviations**2)
    for of in (joints, system):
        part, whole = of(slice(2, 5)), of(slice(None))
        for name, values in vars(part).items():
            np.testing.assert_array_equal(values, getattr(whole, name)[2:5])


def sustained_vibration(frequency: float, damping: float) -> np.ndarray:
    """The covariance of δ, δ̇ and δ̈ that a white jerk of one sustains, in continuous time."""
    # (d/dt + ω) (d²/dt² + 2 ζ ω d/dt + ω²) δ = jerk
    equation = np.polymul([1, frequency], [1, 2 * damping * frequency, frequency**2])
    A = np.eye(3, k=1)
    A[2] = -equation[:0:-1]
    return solve_continuous_lyapunov(A, -np.diag([0.0, 0, 1]))


def usual_noise(count: int) -> EncoderNoise:
    ones = np.ones((count, 6))
    swing = 2 * np.pi * 17 * np.ones(6), np.full(6, 0.1)
    return EncoderNoise(ones, ones, *swing, POSITION * ones, VELOCITY * ones, LAG)


@pytest.fixture(scope="module")
def broken_system(ur5: Robot, measured: tuple[np.ndarray, np.ndarray]) -> System:
    """Joints and an IMU, with values missing and a second segment."""
    q, qd = (values.copy() for values in measured)
    model = partial(model_of, ur5, *measured)
    readings = np.random.default_rng(12).normal(size=q.shape)
    q[190:200], qd[300], readings[395:420] = np.nan, np.nan, np.nan
    time, segment = clock(SAMPLES)
    segment[450:] = 1
    joints = encoder_system(time, segment, q, qd, usual_noise(SAMPLES))
    return add_imu(joints, time, readings, model, np.tile(IMU_NOISE, (SAMPLES, 1)))


def test_chunks_make_no_difference(broken_system: System, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kalman, "LANE_SAMPLES", 600)  # one lane: a plain filter
    mean, std = with_deviations(*smoothed(broken_system, 600))
    for size, lane in ((7, 7), (100, 25), (599, 256)):
        monkeypatch.setattr(kalman, "CHUNK_NUMBERS", size * ALL_STATES**2)
        monkeypatch.setattr(kalman, "LANE_SAMPLES", lane)
        part, deviations = with_deviations(*smoothed(broken_system, 600))
        np.testing.assert_allclose(part / std, mean / std, rtol=0, atol=1e-7)
        np.testing.assert_allclose(deviations, std, rtol=1e-10)


def with_deviations(mean: np.ndarray, covariance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return mean, np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))


def test_memory_of_the_smoother_does_not_grow(
    broken_system: System, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kalman, "CHUNK_NUMBERS", 100 * ALL_STATES**2)
    monkeypatch.setattr(kalman, "LANE_SAMPLES", 50)
    peaks = [peak_memory(partial(deque, smooth(broken_system, n), 0)) for n in (300, 1200)]
    assert peaks[1] < 1.1 * peaks[0]


def peak_memory(function: Callable[[], object]) -> int:
    """The most that a call holds at once [bytes]."""
    tracemalloc.start()
    function()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def test_a_moving_mean_is_of_what_is_known_in_its_segment() -> None:
    """Of three rows; the ends count for those beyond; zero where nothing is known."""
    values = np.array([1.0, 2, 6, np.nan, np.nan, np.nan, 3, 5])[:, None]
    segment = np.repeat([0, 1], [6, 2])
    expected = [4 / 3, 3, 4, 6, 0, 0, 11 / 3, 13 / 3]
    np.testing.assert_allclose(moving_mean(values, segment, 3)[:, 0], expected, atol=1e-12)


def test_no_encoder_is_better_than_the_last_digit_of_a_recording() -> None:
    """A millionth; and an arm that never moves is driven by next to no jerk."""
    noise = encoder_noise(*clock(300), np.full((300, 6), 0.7), np.zeros((300, 6)))
    np.testing.assert_array_equal(noise.position, 1e-6)
    assert (noise.velocity >= 1e-6).all()
    assert (noise.jerk < 0.5).all()


def test_a_hard_start_takes_a_large_jerk() -> None:
    """A joint of little noise that accelerates by 37 rad/s²: far beyond what drives it before."""
    random = np.random.default_rng(9)
    time, segment = clock(600)
    speed = 1.5 * np.clip((time - 2.4) / 0.04, 0, 1)
    q = np.cumsum(speed)[:, None] * PERIOD + 1e-6 * random.normal(size=(600, 6))
    qd = speed[:, None] + 1e-5 * random.normal(size=(600, 6))
    jerk = encoder_noise(time, segment, q, qd).jerk
    start = np.argmin(np.abs(time - 2.4))
    assert (jerk[start : start + 8] > 20).all()
    assert (jerk[: start - 30] < 1.0).all()
    assert (jerk[start + 40 :] < 1.0).all()


def test_a_glitch_beside_a_gap_is_no_motion() -> None:
    """One position that is 3 mrad off, before a pause in the record: no vibration follows."""
    random = np.random.default_rng(14)
    truth = joint_moves(random, 600)
    q, qd = encoders(random, truth)
    q[300] += 3e-3
    q[301:310] = qd[301:310] = np.nan
    motion = smooth_encoders(*clock(600), q, qd)
    assert np.abs(motion.qdd[290:320] - truth[2][290:320]).max() < 15


@pytest.mark.parametrize("name", ["Movement_No9_Singularity_Free_NoDist"])
def test_real_innovations_are_not_white(name: str, thesis_data: Path) -> None:
    """A bound on what is left: of about the right size, though the arm's own shaking colours it."""
    folder = thesis_data / name / "csv_files"
    q, qd = (
        np.genfromtxt(folder / f"log_{channel}_actual.csv", delimiter=",", max_rows=2500)[:, 1:7]
        for channel in ("q", "qd")
    )
    motion = smooth_encoders(*clock(2500), q, qd)
    assert (np.abs(motion.test.variance - 1) < 0.35).all()
    assert not motion.test.white.any()


def test_the_step_of_an_encoder_is_found_whatever_it_visits() -> None:
    """At rest and in motion, with a few odd values, as in the thesis's recordings."""
    random, step = np.random.default_rng(13), 9e-6
    moving = np.round(np.cumsum(random.uniform(0, 5e-5, 3000)) / step) * step
    trembling = 0.7 + step * random.integers(0, 6, 300)
    sparse = np.round(random.uniform(-2, 2, 200) / step) * step
    assert quantum(moving) == pytest.approx(step, abs=1e-6)
    assert quantum(trembling) == pytest.approx(step, abs=1e-6)
    moving[700] += 4e-6
    assert quantum(moving) == pytest.approx(step, abs=1e-6)
    assert quantum(sparse) < 1e-3
    assert quantum(np.full(50, 0.3)) == 0


def shaken(step: float, frequency: float, damping: float, intensity: np.ndarray) -> np.ndarray:
    """What the encoder (N, 2) of a joint at rest measures as its link vibrates, q and q̇."""
    random = np.random.default_rng(16)
    F, driven = motion_step(step, frequency, damping)
    state, states = np.zeros(6), []
    for size in intensity:
        state = F @ state + driven[:, 1] * size * random.normal()
        states.append(state[[3, 1]])
    return np.array(states) + [1e-5, 1e-3] * random.normal(size=(len(states), 2))


def test_a_vibration_is_found_with_its_frequency_and_where_it_is_strong() -> None:
    time, segment = clock(3000)
    intensity = np.where(time < 16, 100.0, 400.0)
    q, qd = shaken(PERIOD, 2 * np.pi * 15, 0.25, intensity).T[:, :, None]
    found = encoder_noise(time, segment, q, qd)
    assert found.frequency[0] == pytest.approx(2 * np.pi * 15, rel=0.1)
    assert found.damping[0] == pytest.approx(0.25, rel=0.25)
    weak, strong = (np.median(found.vibration[part]) for part in (slice(1900), slice(2100, None)))
    assert strong / weak == pytest.approx(4, rel=0.2)


def test_vibrations_of_a_slow_recording_stay_below_its_nyquist_frequency() -> None:
    """Of 20 Hz, up to 7."""
    q, qd = shaken(0.05, 2 * np.pi * 5, 0.1, np.full(400, 10.0)).T[:, :, None]
    found = encoder_noise(0.05 * np.arange(400), np.zeros(400, np.int64), q, qd)
    assert 3 < found.frequency[0] / (2 * np.pi) <= 7 + 1e-9


def test_what_is_constant_comes_from_where_a_joint_moves_most(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Only motion shows how late velocities are; here, a joint rests before and after it."""
    monkeypatch.setattr("ur5lib.smoothing.noise.TUNING_DURATION", 3.0)
    random, lag = np.random.default_rng(15), 4e-3
    time, segment = clock(1200)

    def moving(at: np.ndarray) -> np.ndarray:
        return np.clip(at - 3, 0, 3) * 2 * np.pi / 1.5

    q = 0.3 * (1 - np.cos(moving(time))) + 6e-5 * random.normal(size=1200)
    qd = 1.26 * np.sin(moving(time - lag)) + 4e-3 * random.normal(size=1200)
    found = encoder_noise(time, segment, q[:, None], qd[:, None])
    assert found.lag[0] == pytest.approx(lag, abs=5e-4)


def test_noise_of_a_joint_that_rests_comes_from_where_it_was_measured() -> None:
    """The first minute is missing, and what follows stands still."""
    count = 12_500
    q, qd = np.full((count, 6), 0.7), np.zeros((count, 6))
    q[:7500] = qd[:7500] = np.nan
    noise = encoder_noise(*clock(count), q, qd)
    assert np.isfinite(noise.position).all()
    assert (noise.position < 1e-5).all()


def test_the_noise_of_a_joint_is_that_of_the_joint_alone() -> None:
    """Joints are searched together, and each as if it were alone."""
    time, segment = clock(800)
    joints = [
        shaken(PERIOD, 2 * np.pi * at, 0.1, np.full(800, 50.0)).T for at in (12.0, 18.0, 25.0)
    ]
    q, qd = np.stack(joints, axis=-1)
    together = encoder_noise(time, segment, q, qd)
    for joint in range(3):
        alone = encoder_noise(time, segment, q[:, [joint]], qd[:, [joint]])
        for quantity in ("jerk", "vibration", "frequency", "damping", "position", "lag"):
            found, own = getattr(together, quantity), getattr(alone, quantity)
            np.testing.assert_array_equal(found[..., joint], own[..., 0])
