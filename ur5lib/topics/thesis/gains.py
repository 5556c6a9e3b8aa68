"""The closed loop of Equation 2.80, simulated exactly, and its PD gains from a recording.

Under feedback linearisation the model of the links cancels (2.70): each joint is a double
integrator of its own, driven by a_q = q̈_d - K0 (q - q_d) - K1 (q̇ - q̇_d) (2.71). So the gains do
not depend on the model, and the gains of n joints are n problems of two.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import chain, product
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.ndimage import minimum_filter
from scipy.optimize import OptimizeResult, least_squares, minimize_scalar
from scipy.signal import lfilter
from scipy.special import fdtri

from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import chunks, unbroken
from ur5lib.topics.thesis.records import Gain, JointGains

GRID_NODES = 31  # of the grid of gains, on each axis
DESCENT_STARTS = 5  # least squares start from this many local minima of the grid
PROFILE_STEP = 1e-3  # tolerance of a profile's minima, in log gain
CONFIDENCE_LEVEL = 0.95
CACHED_SAMPLES = 64  # states of so many samples under all gains of the grid fit into a cache
MAX_MOTION_DURATION = 120.0  # s; with more, errors of the loop's model would exceed the ranges
MAX_RANGE_FACTOR = 10.0  # largest high / low of a determined gain's range


@dataclass(frozen=True)
class Tracking:
    """Target and measured motion of an arm on a uniform grid.

    target_q, target_qd, target_qdd, actual_q, actual_qd: (N, 6) [rad, rad/s, rad/s²];
    segment: (N,) labels of unbroken stretches; period: [s]. Rows with NaN divide a stretch.
    """

    target_q: Array
    target_qd: Array
    target_qdd: Array
    actual_q: Array
    actual_qd: Array
    segment: Labels
    period: float


def simulate_closed_loop(
    target_q: Array,
    target_qd: Array,
    target_qdd: Array,
    period: float,
    position_gains: Array,
    velocity_gains: Array,
) -> tuple[Array, Array, Array]:
    """Simulate the loop (2.80): q̂ [rad], q̂̇ [rad/s] and a_q = q̂̈ [rad/s²], (N, 6) each.

    targets: (N, 6), uniform and without gaps; period: [s]; gains: (6,), the diagonals of K0 [1/s²]
    and K1 [1/s]. The loop starts on its target, as the UR5's recordings do. Between samples,
    targets change linearly (first-order hold), which the matrix exponential solves exactly.
    Constant targets (zero-order hold) delay by half a step, and the position errors would be two to
    six times those of Table 5.5.
    """
    # q̂̈ = u - K0 q̂ - K1 q̂̇ with u = q̈_d + K0 q_d + K1 q̇_d
    drive = target_qdd + position_gains * target_q + velocity_gains * target_qd  # (N, 6)
    starts = np.stack([target_q[0], target_qd[0]], axis=1)
    steps = [_step(*gains, period) for gains in zip(position_gains, velocity_gains, strict=True)]
    states = [_run(*joint) for joint in zip(steps, drive.T, starts, strict=True)]  # (2, N) each
    q, qd = np.stack(states, axis=2)
    return q, qd, drive - position_gains * q - velocity_gains * qd


def tracking_cost(
    tracking: Tracking, position_gains: Array, velocity_gains: Array, noise: Array
) -> Array:
    """Return the cost J (6,) of positive gains (6,), dimensionless, one for each joint.

    (2.83) adds rad² and rad²/s², so that the velocities' noise dominates. Here J = Σ r²/(σ² t) over
    the residuals r of positions and velocities. noise: (6, 2), σ √t of `JointGains`, where σ² is
    the residuals' mean square with the best gains and t their correlation time in samples.
    """
    gains = np.log(np.stack([position_gains, velocity_gains], axis=1))
    columns = zip(_joints(tracking), gains, noise, strict=True)
    return np.array([joint.cost(pair, scale) for joint, pair, scale in columns])


def estimate_gains(tracking: Tracking) -> list[JointGains]:
    """Return the gains of each joint by nonlinear least squares (2.84), with 95 % ranges.

    Natural frequencies are searched from one radian over the longest stretch up to Nyquist's,
    critically damped (2.74). Least squares start from the deepest local minima of a grid in the
    logarithm of both gains; the noise is first that of a joint that follows exactly, then that with
    the gains found. The 95 % range is J <= J_min [1 + 2/(n - 2) F(2, n - 2)]: F is the 95 % point
    of Fisher's distribution, n the number of independent samples. J_min is the cost of a joint that
    follows exactly if noise alone explains that the best gains of the grid cost less. In a
    recording longer than MAX_MOTION_DURATION, only the parts are used in which a joint's target
    accelerates most. A joint with a target at rest throughout has no determined gains. Raises
    ValueError if no two successive samples are complete.
    """
    return [_estimate(joint) for joint in _joints(tracking)]


# The loop of one joint


class _LoopStep(NamedTuple):
    """x[k+1] = A x[k] + B0 u[k] + B1 u[k+1], x = [q, q̇]; for one loop or for many (P, ...)."""

    A: Array
    B0: Array
    B1: Array


def _step(position_gain: Array | float, velocity_gain: Array | float, period: float) -> _LoopStep:
    """Return q̈ = u - K0 q - K1 q̇ discretised over one period with linear u (Van Loan 1978)."""
    # d/dt [q, q̇, u, Δu] = G [q, q̇, u, Δu], with u' = Δu / T
    generator = np.zeros((*np.shape(position_gain), 4, 4))
    generator[..., :2, 1:3] = np.eye(2)
    generator[..., 1, 0], generator[..., 1, 1] = -position_gain, -velocity_gain
    generator[..., 2, 3] = 1 / period
    # exp(G T) gives x[k+1] = A x[k] + C0 u[k] + C1 (u[k+1] - u[k])
    flow = expm(generator * period)
    response_to_value, response_to_change = flow[..., :2, 2], flow[..., :2, 3]
    return _LoopStep(flow[..., :2, :2], response_to_value - response_to_change, response_to_change)


def _run(step: _LoopStep, drive: Array, start: Array) -> Array:
    """Return the states (2, N) with input u (N,) from a start (2,).

    By A² = tr(A) A - det(A) I (Cayley and Hamilton), x[k+1] = A x[k] + w[k+1] decouples into one
    recursion per state: x[k+2] = tr(A) x[k+1] - det(A) x[k] + w[k+2] + (A - tr(A) I) w[k+1].
    """
    A, B0, B1 = step
    # w[0] = x[0], w[k+1] = B0 u[k] + B1 u[k+1]
    pushes = np.empty((2, len(drive)))  # one row per state: rows are faster than columns
    pushes[:, 0] = start
    pushes[:, 1:] = B0[:, None] * drive[:-1] + B1[:, None] * drive[1:]
    # w[k+2] + (A - tr(A) I) w[k+1]
    trace, determinant = A[0, 0] + A[1, 1], A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    inputs = pushes.copy()
    inputs[:, 1:] += (A - np.diag([trace, trace])) @ pushes[:, :-1]
    # x[k+2] - tr(A) x[k+1] + det(A) x[k] = inputs

    return np.asarray(lfilter([1.0], [1.0, -trace, determinant], inputs))


# The gains of one joint


@dataclass(frozen=True)
class _JointLoop:
    """The control loop of one joint in a recording.

    stretches: unbroken parts, (5, K) each: target q, q̇, q̈, measured q, q̇; period: [s].
    """

    stretches: list[Array]
    period: float

    def errors(self, gains: Array) -> Array:
        """Return the errors of q̂ and q̂̇, (2, N); gains: (2,), the logarithms of K0 and K1."""
        position_gain, velocity_gain = np.exp(gains)
        step = _step(position_gain, velocity_gain, self.period)
        errors = []
        for stretch in self.stretches:
            q, qd, qdd = stretch[:3]
            drive = qdd + position_gain * q + velocity_gain * qd
            errors.append(stretch[3:] - _run(step, drive, stretch[:2, 0]))
        return np.concatenate(errors, axis=1)

    def squares(self, gains: Array) -> Array:
        """Return the sums of squared errors (P, 2) with P pairs of log gains (P, 2).

        All pairs advance together, sample by sample: one filter per pair takes several times as
        long.
        """
        position_gain, velocity_gain = np.exp(gains).T
        A, B0, B1 = _step(position_gain, velocity_gain, self.period)
        # u = K0 q_d + K1 q̇_d + q̈_d; effect of both targets of a step on the state: (6, 2, P)
        drive = np.stack([position_gain, velocity_gain, np.ones(len(gains))])
        added = np.concatenate([drive[:, None] * B0.T, drive[:, None] * B1.T])
        by_q, by_qd = np.ascontiguousarray(A.T)  # (2, P) each
        squares = np.zeros((2, len(gains)))
        for stretch in self.stretches:
            state = np.repeat(stretch[:2, :1], len(gains), axis=1)
            squares += (stretch[3:, :1] - state) ** 2
            targets = np.concatenate([stretch[:3, :-1], stretch[:3, 1:]])  # (6, K - 1)
            for rows in chunks(targets.shape[1], CACHED_SAMPLES):
                states = np.tensordot(targets[:, rows], added, axes=(0, 0))  # (k, 2, P)
                for now in states:
                    now += by_q * state[0]
                    now += by_qd * state[1]
                    state = now
                squares += np.square(stretch[3:, 1:][:, rows].T[..., None] - states).sum(axis=0)
        return squares.T

    def cost(self, gains: Array, noise: Array) -> float:
        """Return J = Σ r²/(σ² t) of log gains (2,); noise: (2,), σ √t."""
        return _cost(self.errors(gains), noise)

    def grid(self) -> Array:
        """Return the grid's axes (GRID_NODES, 2): logarithms of the gains ω² and 2 ω.

        log ω is evenly spaced, from 1 / the longest stretch to π / period.
        """
        longest = max(stretch.shape[1] for stretch in self.stretches) * self.period
        frequency = np.array([1 / longest, np.pi / self.period])
        lowest, highest = np.log(np.stack([frequency**2, 2 * frequency], axis=1))
        return np.linspace(lowest, highest, GRID_NODES)

    def noise(self, errors: Array) -> Array:
        """Return σ √t (2,) of errors (2, N) in position and velocity.

        σ follows from the mean square, the correlation time t from the positive sums of Geyer
        (1992).
        """
        # autocovariances by the power spectrum, zero-padded
        lengths = [stretch.shape[1] for stretch in self.stretches]
        size, parts = 2 * max(lengths), np.split(errors, np.cumsum(lengths)[:-1], axis=1)
        spectrum = np.sum([np.abs(np.fft.rfft(part, size)) ** 2 for part in parts], axis=0)
        covariances = np.fft.irfft(spectrum, size) / errors.shape[1]
        # σ² t = 2 Σ (c_2k + c_2k+1) - c_0, up to the first pair that is not positive
        noise = np.full(2, np.inf)  # without any error, no gain is determined
        for kind, covariance in enumerate(covariances):
            if covariance[0] > 0:
                pairs = covariance[: size // 4 * 2].reshape(-1, 2).sum(axis=1)
                last = int(np.argmax(pairs <= 0)) or len(pairs)
                variance = max(2 * pairs[:last].sum() - covariance[0], covariance[0])
                noise[kind] = np.sqrt(variance)
        return noise


def _joints(tracking: Tracking) -> list[_JointLoop]:
    """Return the recording by joint, each in parts without gaps.

    A long one keeps only the parts in which a joint's target accelerates most.
    """
    t = tracking
    kinds = t.target_q, t.target_qd, t.target_qdd, t.actual_q, t.actual_qd
    finite = np.all([np.isfinite(kind).all(axis=1) for kind in kinds], axis=0)
    complete = [
        rows
        for rows in unbroken(t.segment, finite)
        if finite[rows.start] and rows.stop - rows.start > 1
    ]
    if not complete:
        raise ValueError("no two successive samples have both targets and measured motion")
    joints = []
    for joint, acceleration in enumerate(t.target_qdd.T):
        parts = _accelerated_most(complete, acceleration, round(MAX_MOTION_DURATION / t.period))
        stretches = [np.stack([kind[rows, joint] for kind in kinds]) for rows in parts]
        joints.append(_JointLoop(stretches, t.period))
    return joints


def _accelerated_most(stretches: list[slice], acceleration: Array, enough: int) -> list[slice]:
    """Return all unbroken parts of a recording, or those pieces of them with the largest
    accelerations if they are too long.

    acceleration: (N,), of the target; enough: largest number of samples, in all and of a part.
    """
    if sum(rows.stop - rows.start for rows in stretches) <= enough:
        return stretches
    parts = [
        slice(start, min(start + enough, rows.stop))
        for rows in stretches
        for start in range(rows.start, rows.stop - 1, enough)
    ]
    squares = np.array([np.sum(acceleration[rows] ** 2) for rows in parts])
    order = np.argsort(-squares, kind="stable")
    count = np.cumsum([parts[k].stop - parts[k].start for k in order])
    needed = 1 + int(np.searchsorted(count, enough))
    return [parts[k] for k in sorted(order[:needed])]


def _cost(errors: Array, noise: Array) -> float:
    """Return J = Σ r²/(σ² t) of errors r (2, N); noise: (2,), σ √t."""
    return float(np.einsum("in,in->i", errors, errors) @ noise**-2.0)


def _estimate(joint: _JointLoop) -> JointGains:
    """Return both gains of one joint with their 95 % ranges."""
    grid = joint.grid()
    # the errors of a joint that follows its target exactly
    stiff = np.concatenate([stretch[3:] - stretch[:2] for stretch in joint.stretches], axis=1)
    noise = joint.noise(stiff)
    if not any(stretch[1:3].any() for stretch in joint.stretches):
        # the target never moves, so a joint that follows exactly has the least cost
        cost = _cost(stiff, noise)
        position, velocity = (
            Gain(values[-1], np.nan, values[0], values[-1], False, values)
            for values in np.exp(grid).T
        )
        return JointGains(position, velocity, False, noise, cost, cost, cost)
    # squared errors on a grid of log gains
    squares = joint.squares(np.array([*product(*grid.T)])).reshape(GRID_NODES, GRID_NODES, 2)
    # minimum, first with the noise of a stiff joint, then with that of the gains found
    first = _descend(joint, grid, squares, noise)
    noise = joint.noise(joint.errors(first.x))
    best = _descend(joint, grid, squares, noise)
    freedom = max(joint.cost(first.x, noise) - 2, 1.0)  # n - 2
    min_cost, stiff_cost = 2 * best.cost, _cost(stiff, noise)
    # noise alone lets the best of the grid's gains cost less than a joint that follows exactly
    by_chance = min_cost * _cost_rise(1 - (1 - CONFIDENCE_LEVEL) / GRID_NODES**2, freedom)
    reference = max(min_cost, stiff_cost) if stiff_cost <= by_chance else min_cost
    limit = reference * _cost_rise(CONFIDENCE_LEVEL, freedom)
    # cov = J_min / (n - 2) (Jᵀ J)⁻¹
    std = np.sqrt(min_cost / freedom * np.diag(np.linalg.pinv(best.jac.T @ best.jac)))
    profiles = [_profile(joint, grid, squares, noise, axis) for axis in (0, 1)]
    position, velocity = (
        _gain(best.x[axis], std[axis], grid[:, axis], profiles[axis], reference, limit, stiff_cost)
        for axis in (0, 1)
    )
    return JointGains(position, velocity, True, noise, min_cost, limit, stiff_cost)


def _cost_rise(level: float, freedom: float) -> float:
    """Return 1 + 2/(n - 2) F(2, n - 2), the ratio J / J_min at the ends of a confidence region."""
    return float(1 + 2 / freedom * fdtri(2, freedom, level))


def _descend(joint: _JointLoop, grid: Array, squares: Array, noise: Array) -> OptimizeResult:
    """Return the best least squares fit from the deepest local minima of the grid."""

    def residuals(gains: Array) -> Array:
        return (joint.errors(gains) / noise[:, None]).ravel()

    costs = squares @ noise**-2.0
    lowest = np.argwhere(costs == minimum_filter(costs, 3, mode="nearest"))
    deepest = lowest[np.argsort(costs[tuple(lowest.T)])[:DESCENT_STARTS]]
    starts = np.take_along_axis(grid, deepest, axis=0)
    fits = [least_squares(residuals, start, bounds=(grid[0], grid[-1])) for start in starts]
    return min(fits, key=lambda fit: fit.cost)


def _profile(
    joint: _JointLoop, grid: Array, squares: Array, noise: Array, axis: int
) -> Callable[[int], float]:
    """Return the profile of a gain: of a node of the grid, the minimum over the other gain."""
    costs, other_grid = squares @ noise**-2.0, grid[:, 1 - axis]

    def least(node: int) -> float:
        k = int(np.argmin(costs.take(node, axis)))

        def cost(value: float) -> float:
            gains = np.full(2, grid[node, axis])
            gains[1 - axis] = value
            return joint.cost(gains, noise)

        between = other_grid[max(k - 1, 0)], other_grid[min(k + 1, GRID_NODES - 1)]
        least_cost = minimize_scalar(
            cost, bounds=between, method="bounded", options={"xatol": PROFILE_STEP}
        )
        return float(least_cost.fun)

    return least


def _gain(
    best: float,
    std: float,
    grid: Array,
    profile: Callable[[int], float],
    reference: float,
    limit: float,
    stiff: float,
) -> Gain:
    """Return a gain and the range in which its profile stays within the limit.

    If a joint that follows its target exactly fits as well, the range has no upper end: the arm is
    at rest, or moves too slowly. reference: J_ref, subtracted from costs; limit: largest cost.

    The square root of the cost's rise is nearly linear in the log gain (Bates and Watts 1988,
    chapter 6), so it is interpolated linearly. Minima take most of the time: the profile is asked
    from the bounds inwards, as far as the range.
    """
    allowed = np.sqrt(limit - reference)  # √(J - J_ref) at the ends of the range

    def end(nodes: range) -> float:
        on_the_way = ((grid[k], np.sqrt(max(profile(k) - reference, 0.0))) for k in nodes)
        return _crossing(chain(on_the_way, [(best, 0.0)]), allowed)

    place = int(np.searchsorted(grid, best))
    low = end(range(place))
    high = float(grid[-1]) if stiff <= limit else end(range(GRID_NODES - 1, place - 1, -1))
    determined = low > grid[0] and high < grid[-1] and high - low < np.log(MAX_RANGE_FACTOR)
    value, low, high = np.exp([best, low, high])
    return Gain(value, value * std, low, high, bool(determined), np.exp(grid))


def _crossing(rises: Iterable[tuple[float, float]], allowed: float) -> float:
    """Return where a rise first falls to `allowed`, interpolated between nodes (node, rise); the
    first node if it starts below.
    """
    last = None
    for node, rise in rises:
        if rise <= allowed:
            break
        last = node, rise
    if last is None:
        return float(node)
    share = (last[1] - allowed) / (last[1] - rise)
    return float(last[0] + share * (node - last[0]))
