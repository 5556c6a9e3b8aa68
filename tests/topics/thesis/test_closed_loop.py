"""The closed loop: its simulation is exact, its gains come with what the data do not tell."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter, lsim
from scipy.stats import f as fisher

from tests.real_arms import RealRecording, RealStudy
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import mean_absolute_error
from ur5lib.timeseries.sampling import interpolated
from ur5lib.topics.thesis import gains as closed_loop
from ur5lib.topics.thesis import rows
from ur5lib.topics.thesis.closed_loop import gain_summary, published_gains, simulated, tracking_of
from ur5lib.topics.thesis.gains import (
    Tracking,
    estimate_gains,
    simulate_closed_loop,
    tracking_cost,
)
from ur5lib.topics.thesis.records import ClosedLoop, JointGains

TABLE_5_5 = "Movement_No5_Acc_slow_no_disturbance"
PERIOD = 0.008
MOTION = ("target_q", "target_qd", "target_qdd", "actual_q", "actual_qd")
K0, K1 = np.full(6, 400.0), np.full(6, 30.0)
PRINTED_POSITION = {  # Table 5.5 [1e-4 rad]
    "A": [1, 2, 4, 5, 2, 3],
    "B": [1, 2, 4, 4, 2, 3],
    "C": [1, 2, 4, 4, 2, 3],
}
PRINTED_VELOCITY = {  # Table 5.5 [1e-4 rad/s]
    "A": [28, 35, 33, 111, 63, 148],
    "B": [28, 35, 33, 110, 63, 148],
    "C": [26, 31, 31, 85, 56, 129],
}


def smooth_targets(count: int = 800, leap: float = 0.0) -> tuple[Array, Array, Array]:
    """Joints that swing, told consistently but for a leap [rad/s] of the speed half-way."""
    time = PERIOD * np.arange(count)
    speeds = np.linspace(0.5, 1.5, 6)
    phase = np.outer(time, speeds)
    after = np.where(np.arange(count) >= count // 2, time - time[count // 2], 0.0)[:, None]
    q = 0.3 * (1 - np.cos(phase)) + leap * after
    qd = 0.3 * speeds * np.sin(phase) + leap * (after > 0)
    return q, qd, 0.3 * speeds**2 * np.cos(phase)


def tracking(leap: float, seed: int, memory: float = 0.0) -> Tracking:
    """A recording of the loop with K0 and K1, its noise correlated as memory**lag."""
    random = np.random.default_rng(seed)
    targets = smooth_targets(leap=leap)
    q, qd, _ = simulate_closed_loop(*targets, PERIOD, K0, K1)
    white = random.normal(size=(2, *q.shape))
    noise = np.sqrt(1 - memory**2) * lfilter([1.0], [1.0, -memory], white, axis=1)
    segment = np.zeros(len(q), dtype=np.int64)
    return Tracking(*targets, q + 1e-4 * noise[0], qd + 3e-3 * noise[1], segment, PERIOD)


@cache
def estimated_gains(seed: int, memory: float = 0.0) -> list[JointGains]:
    """Of a recording whose targets leap."""
    return estimate_gains(tracking(0.5, seed, memory))


def test_of_a_long_recording_the_part_that_moves_is_enough(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Here 6.4 s that leap, after 12.8 s and before 3.2 s in which the target hardly moves."""
    moving = tracking(leap=0.3, seed=3)
    count = len(moving.segment)
    resting = {name: np.repeat(getattr(moving, name)[:1], count, axis=0) for name in MOTION}
    resting["target_qdd"] = 0 * resting["target_qdd"]
    parts = [resting, resting, vars(moving), {k: v[: count // 2] for k, v in resting.items()}]
    whole = {name: np.concatenate([part[name] for part in parts]) for name in MOTION}
    long = Tracking(**whole, segment=np.zeros(count * 7 // 2, np.int64), period=PERIOD)
    monkeypatch.setattr(closed_loop, "MAX_MOTION_DURATION", count * PERIOD)
    found, expected = estimate_gains(long), estimate_gains(moving)
    for own, alone in zip(found, expected, strict=True):
        assert (own.position.best, own.velocity.best) == (alone.position.best, alone.velocity.best)
        assert own.cost == alone.cost


# Simulation


@settings(max_examples=25)
@given(
    st.lists(st.floats(-3, 5), min_size=6, max_size=6),
    st.lists(st.floats(-2, 2.9), min_size=6, max_size=6),
)
def test_the_simulation_is_scipys(position: list[float], velocity: list[float]) -> None:
    """Random targets; gains over decades, under- and overdamped."""
    random = np.random.default_rng(0)
    gains = 10.0 ** np.array([position, velocity])
    targets = random.normal(size=(3, 200, 6))
    q, qd, qdd = simulate_closed_loop(*targets, PERIOD, *gains)
    time = PERIOD * np.arange(200)
    for joint, (k0, k1) in enumerate(gains.T):
        told = targets[:, :, joint]
        drive = told[2] + k0 * told[0] + k1 * told[1]
        loop = ([[0, 1], [-k0, -k1]], [[0], [1]], np.eye(2), np.zeros((2, 1)))
        states = lsim(loop, drive, time, told[:2, 0])[1]
        scale = np.abs(states).max(axis=0) + 1
        assert (np.abs(q[:, joint] - states[:, 0]) < 1e-9 * scale[0]).all()
        assert (np.abs(qd[:, joint] - states[:, 1]) < 1e-9 * scale[1]).all()
    error, rate = q - targets[0], qd - targets[1]
    np.testing.assert_allclose(qdd, targets[2] - gains[0] * error - gains[1] * rate, atol=1e-6)


# Estimation


@pytest.mark.parametrize("seed", [0, 7])
def test_smooth_targets_determine_no_gain(seed: int) -> None:
    """Nothing then depends on the gains; the range holds what they are. A loop that rings fits the
    noise better than the true one by chance, since so many are tried."""
    for joint in estimate_gains(tracking(leap=0.0, seed=seed)):
        for gain, truth in ((joint.position, 400.0), (joint.velocity, 30.0)):
            assert not gain.determined
            assert gain.low < truth < gain.high
            assert gain.high > 10 * gain.low
        assert joint.cost == pytest.approx(joint.stiff, rel=0.05)


@pytest.mark.parametrize(("memory", "most"), [(0.0, 0.1), (0.9, 0.3)])
def test_standard_errors_and_ranges_hold_what_they_promise(memory: float, most: float) -> None:
    """Noise that remembers widens them: 24 estimates of the same two gains."""
    estimates = [joint for seed in range(4) for joint in estimated_gains(seed, memory)]
    for name, truth in (("position", 400.0), ("velocity", 30.0)):
        gains = [getattr(joint, name) for joint in estimates]
        assert all(gain.determined and gain.std_error < most * truth for gain in gains)
        scores = np.array([(gain.best - truth) / gain.std_error for gain in gains])
        assert 0.4 < np.sqrt(np.mean(scores**2)) < 1.6
        assert np.mean([gain.low < truth < gain.high for gain in gains]) > 0.9


def profiles(recording: Tracking, joint: int, found: JointGains) -> list[Array]:
    """The least cost over the other gain at each value of the grid, of both gains of a joint."""
    motion = {name: getattr(recording, name)[:, [joint]] for name in MOTION}
    alone = replace(recording, **motion)

    def cost(k0: float, k1: float) -> float:
        return tracking_cost(alone, np.array([k0]), np.array([k1]), found.noise[None]).item()

    def least(of: Callable[[float], float], grid: Array, costs: Array) -> float:
        around = np.clip(np.array([-1, 1]) + costs.argmin(), 0, len(grid) - 1)
        return minimize_scalar(lambda log: of(np.exp(log)), bounds=np.log(grid[around])).fun

    position, velocity = found.position.grid, found.velocity.grid
    costs = np.array([[cost(k0, k1) for k1 in velocity] for k0 in position])
    rows, columns = zip(position, costs, strict=True), zip(velocity, costs.T, strict=True)
    return [
        np.array([least(partial(cost, k0), velocity, row) for k0, row in rows]),
        np.array([least(partial(cost, k1=k1), position, row) for k1, row in columns]),
    ]


@pytest.mark.parametrize("joint", [0, 5])
def test_least_squares_finds_the_bottom_of_the_profile(joint: int) -> None:
    found = estimated_gains(seed=1)[joint]
    both = profiles(tracking(0.5, seed=1), joint, found)
    for gain, profile in zip((found.position, found.velocity), both, strict=True):
        assert profile.min() >= found.cost - 1e-9 * found.cost
        inside = (gain.grid > gain.low) & (gain.grid < gain.high)
        assert (profile[inside] <= found.limit).all()
        assert (profile[~inside] >= found.limit).all()


def test_cost_is_the_least_at_the_estimate() -> None:
    recording = tracking(leap=0.5, seed=2)
    joints = estimated_gains(seed=2)
    best = [np.array([getattr(j, name).best for j in joints]) for name in ("position", "velocity")]
    noise = np.array([joint.noise for joint in joints])
    least = tracking_cost(recording, *best, noise)
    np.testing.assert_allclose(least, [joint.cost for joint in joints])
    for factor in (0.8, 1.25):
        assert (tracking_cost(recording, factor * best[0], best[1], noise) > least).all()
        assert (tracking_cost(recording, best[0], factor * best[1], noise) > least).all()


def test_noise_counts_as_many_times_as_it_lasts() -> None:
    """(1 + a) / (1 - a) samples of an autoregressive process; the limit is that of Fisher. Gains
    are searched from one radian over the longest stretch up to Nyquist's frequency."""
    lasting, segment = 19.0, np.repeat([0, 1], [300, 500])
    recording = replace(tracking(0.5, seed=5, memory=0.9), segment=segment)
    joints = estimate_gains(recording)
    frequency = np.geomspace(1 / (500 * PERIOD), np.pi / PERIOD, 31)
    np.testing.assert_allclose(joints[0].position.grid, frequency**2)
    np.testing.assert_allclose(joints[0].velocity.grid, 2 * frequency)
    noise = np.array([joint.noise for joint in joints])
    np.testing.assert_allclose(noise.mean(axis=0) / [1e-4, 3e-3], np.sqrt(lasting), rtol=0.1)
    pairs = (
        (recording.actual_q, recording.target_q),
        (recording.actual_qd, recording.target_qd),
    )
    late = np.stack([actual - target for actual, target in pairs], axis=2)
    stiff = np.sum((late / noise) ** 2, axis=(0, 2))
    np.testing.assert_allclose([joint.stiff for joint in joints], stiff)
    free = 2 * len(recording.segment) / lasting - 2
    rise = [joint.limit / joint.cost - 1 for joint in joints]
    assert np.mean(rise) == pytest.approx(2 / free * fisher.ppf(0.95, 2, free), rel=0.15)


def test_noise_without_memory_is_that_of_each_sample() -> None:
    noise = np.array([joint.noise for joint in estimated_gains(seed=1)])
    np.testing.assert_allclose(noise.mean(axis=0), [1e-4, 3e-3], rtol=0.1)


def test_nothing_is_fitted_across_a_gap() -> None:
    """Two stretches count as much when told apart by a label or by a row of NaN."""
    one, two = tracking(0.5, 3), tracking(0.5, 4)
    names = ("target_q", "target_qd", "target_qdd", "actual_q", "actual_qd")
    missing = np.full((1, 6), np.nan)
    halves = [(getattr(one, name), getattr(two, name)) for name in names]
    labels = np.repeat([0, 1], len(one.segment))
    split = Tracking(*(np.concatenate(pair) for pair in halves), labels, PERIOD)
    holed = [np.concatenate([a, missing, b]) for a, b in halves]
    holed = Tracking(*holed, np.zeros(len(holed[0]), dtype=np.int64), PERIOD)
    gains = K0, K1, np.full((6, 2), 1e-3)
    np.testing.assert_allclose(tracking_cost(holed, *gains), tracking_cost(split, *gains))
    joined = replace(split, segment=np.zeros_like(labels))
    assert (tracking_cost(joined, *gains) > 2 * tracking_cost(split, *gains)).all()


def test_a_joint_that_follows_perfectly_determines_nothing() -> None:
    still = np.zeros((100, 6))
    segment = np.zeros(100, dtype=np.int64)
    for joint in estimate_gains(Tracking(still, still, still, still, still, segment, PERIOD)):
        assert not joint.position.determined
        assert not joint.velocity.determined


def test_a_joint_whose_target_rests_determines_nothing_whatever_it_does() -> None:
    """Wandering by itself; its neighbours, whose targets leap, determine their gains as before."""
    moving, expected = tracking(leap=0.5, seed=3), estimated_gains(seed=3)
    rest = {name: getattr(moving, name).copy() for name in ("target_q", "target_qd", "target_qdd")}
    for values in rest.values():
        values[:, 2] = 0.0
    wandering = moving.actual_q.copy()
    wandering[:, 2] = 1e-3 * np.sin(np.arange(len(wandering)) / 30)
    recording = replace(moving, **rest, actual_q=wandering)
    found = estimate_gains(recording)
    summary = gain_summary(recording, found, {"some": (K0, K1)})
    assert [row.joint for row in rows.published_gains(summary)] == [1, 2, 4, 5, 6]
    for gain in (found[2].position, found[2].velocity):
        assert not gain.determined
        assert (gain.low, gain.high) == (gain.grid[0], gain.grid[-1])
    assert np.array_equal(found[2].position.grid, expected[0].position.grid)
    assert np.array_equal(found[2].velocity.grid, expected[0].velocity.grid)
    stiff = np.stack([wandering[:, 2], moving.actual_qd[:, 2]], axis=1) / found[2].noise
    assert found[2].cost == pytest.approx((stiff**2).sum())
    for joint in (0, 1, 3, 4, 5):
        assert found[joint].position.best == expected[joint].position.best


def test_no_two_successive_samples_are_refused() -> None:
    empty = np.full((10, 6), np.nan)
    recording = Tracking(*[empty] * 5, np.zeros(10, dtype=np.int64), PERIOD)
    with pytest.raises(ValueError, match="no two successive"):
        estimate_gains(recording)


# The thesis's recording


def recorded(one: RealRecording) -> Tracking:
    found = tracking_of(one.signals)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def slow(real_ur5: RealStudy) -> RealRecording:
    return real_ur5.recording(TABLE_5_5)


@pytest.fixture(scope="module")
def loop(slow: RealRecording) -> ClosedLoop:
    """It with each model's published gains."""
    return simulated(slow.signals, slow.robot, recorded(slow), published_gains(slow.robot))


def errors(slow: RealRecording, q: Array, qd: Array) -> tuple[Array, Array]:
    """Mean absolute errors in units of the last printed digit: [1e-4 rad, 1e-4 rad/s]."""
    actual_qd = slow.signals.actual_qd
    assert actual_qd is not None
    return (
        1e4 * mean_absolute_error(q, slow.signals.actual_q),
        1e4 * mean_absolute_error(qd, actual_qd),
    )


def test_table_5_5_of_model_b_to_the_last_digit(slow: RealRecording, loop: ClosedLoop) -> None:
    q, qd = errors(slow, loop.q["B"], loop.qd["B"])
    np.testing.assert_array_equal(np.round(q), PRINTED_POSITION["B"])
    np.testing.assert_array_equal(np.round(qd), PRINTED_VELOCITY["B"])


def test_model_a_was_simulated_with_other_gains(slow: RealRecording) -> None:
    """Erratum 14: where (C.2) repeats (C.3), K1 = K0 + 0.6 gives all that Table 5.5 prints."""
    position, velocity = published_gains(slow.robot)["A"]
    velocity[2:] = position[2:] + 0.6
    loop = simulated(slow.signals, slow.robot, recorded(slow), {"A": (position, velocity)})
    q, qd = errors(slow, loop.q["A"], loop.qd["A"])
    np.testing.assert_array_equal(np.round(q), PRINTED_POSITION["A"])
    np.testing.assert_array_equal(np.round(qd), PRINTED_VELOCITY["A"])


def test_model_c_was_compared_between_samples(slow: RealRecording, loop: ClosedLoop) -> None:
    """Its printed velocities are better as interpolation averages the noise of what is measured."""
    error = loop.qd["C"] - recorded(slow).actual_qd
    at = np.arange(0, len(error) - 1, 1 / 8)
    between = interpolated(at, np.arange(len(error)), error)
    printed = np.array(PRINTED_VELOCITY["C"])
    assert (1e4 * np.abs(error).mean(axis=0) > 1.05 * printed).all()
    np.testing.assert_allclose(1e4 * np.abs(between).mean(axis=0), printed, rtol=0.05)


def test_rounded_lengths_would_raise_the_errors_of_joint_2(
    slow: RealRecording, loop: ClosedLoop
) -> None:
    """Equation 5.2 beside Table 5.2: by 5 to 9 mNm."""
    links = [link.model_dump() for link in slow.robot.denavit_hartenberg]
    links[2]["a"], links[3]["d"], links[4]["d"] = -0.392, 0.1092, 0.0947
    rounded = Robot.model_validate(slow.robot.model_dump() | {"denavit_hartenberg": links})
    moment = slow.signals.target_moment
    assert moment is not None
    for model in "ABC":
        states = loop.q[model], loop.qd[model], loop.qdd[model]
        torque = LinkModel(rounded, model).inverse_dynamics(*states)
        rise = mean_absolute_error(torque, moment) - mean_absolute_error(loop.torque[model], moment)
        assert 0.0045 < rise[1] < 0.0095
