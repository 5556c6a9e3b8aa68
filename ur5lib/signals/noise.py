"""Noise from innovations, and whether the innovations are white."""

from dataclasses import dataclass

import numpy as np
from scipy import signal
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import solve_discrete_are
from scipy.ndimage import uniform_filter1d
from scipy.optimize import minimize
from scipy.special import softmax
from scipy.stats import chi2

from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import unbroken

JERKS = np.geomspace(1e-2, 1e3, 11)  # rad/s³/√Hz: from standstill to the hardest start
JERK_WINDOW = 0.13  # s, over which an intensity is taken as constant
RESOLUTION = 1e-6  # rad, rad/s: the last digit of a recording; no noise is less
NOTHING = 1e-20  # keeps perfect data from a likelihood without bound
LAGS = 10  # of the portmanteau test
# Logarithms of jerk and velocity precision beside the positions' noise, and the lag in cycles.
BOUNDS = [(-12.0, 6.0), (-8.0, 8.0), (-1.0, 1.0)]
SIMPLEX = np.array([[-2.8, 0.2, 0.0], [-1.3, 0.2, 0.0], [-2.8, -0.8, 0.0], [-2.8, 0.2, 0.25]])


@dataclass(frozen=True)
class EncoderNoise:
    """What drives the joints, and what their encoders add.

    jerk: (N, 6) [rad/s³/√Hz], intensity of white jerk at each sample; position: (6,) [rad] and
    velocity: (6,) [rad/s], standard deviations; lag: (6,) [s] of the measured velocity.
    """

    jerk: Array
    position: Array
    velocity: Array
    lag: Array


@dataclass(frozen=True)
class InnovationTest:
    """Are normalised innovations what they should be: of variance one, and white?

    variance: (M,), mean squares, and variance_limits: (M, 2), where 95 % of them would lie;
    portmanteau: (M,), Ljung-Box statistic, and portmanteau_limit, which 5 % would exceed;
    consistent, white: (M,), whether they pass.
    """

    variance: Array
    variance_limits: Array
    portmanteau: Array
    portmanteau_limit: float
    consistent: Mask
    white: Mask


def encoder_noise(time: Array, segment: Labels, q: Array, qd: Array) -> EncoderNoise:
    """Noise under which the innovations of a joint's Kalman filter are likeliest.

    time: (N,) [s], evenly spaced within a segment; segment: (N,) labels; q, qd: (N, 6) [rad,
    rad/s], NaN where missing. Raises ValueError where a joint has no velocities.

    Maximum likelihood (Schweppe) of position, velocity and lag with one jerk for all times; then,
    with a bank of jerks, the posterior mean of log jerk in a window about each sample.
    """
    period = float(np.median(np.diff(time)))
    joints = [_joint_noise(time, segment, *joint, period) for joint in zip(q.T, qd.T, strict=True)]
    jerk, position, velocity, lag = (np.stack(each, axis=-1) for each in zip(*joints, strict=True))
    return EncoderNoise(jerk, position, velocity, lag)


def innovation_test(innovations: Array, segment: Labels) -> InnovationTest:
    """Test normalised innovations (N, M); NaN where there was none.

    Mean square against χ²; autocorrelation over LAGS lags within segments by Ljung and Box.
    """
    count = np.isfinite(innovations).sum(axis=0)
    variance = np.nanmean(innovations**2, axis=0)
    limits = chi2.ppf([0.025, 0.975], count[:, None]) / count[:, None]
    portmanteau = np.zeros(len(count))
    for lag in range(1, LAGS + 1):
        product = innovations[lag:] * innovations[:-lag]
        product[segment[lag:] != segment[:-lag]] = np.nan
        correlation = np.nanmean(product, axis=0) / variance
        portmanteau += count * (count + 2) * correlation**2 / (count - lag)
    limit = float(chi2.ppf(0.95, LAGS))
    consistent = (limits[:, 0] <= variance) & (variance <= limits[:, 1])
    return InnovationTest(variance, limits, portmanteau, limit, consistent, portmanteau <= limit)


def _joint_noise(
    time: Array, segment: Labels, q: Array, qd: Array, period: float
) -> tuple[Array, float, float, float]:
    """Jerk (N,), position, velocity and lag of one joint."""
    record = _Record(time, segment, q, qd, period)

    def cost(parameters: Array) -> float:
        logdet, square = record.deviance(*_ratios(parameters))
        return logdet + 2 * float(np.log(square[record.told].mean() + NOTHING))

    best = minimize(
        cost,
        SIMPLEX[0],
        method="Nelder-Mead",
        bounds=BOUNDS,
        options={"initial_simplex": SIMPLEX, "xatol": 0.05, "fatol": 1e-4},
    ).x
    _, precision, lag = _ratios(best)
    _, square = record.deviance(*_ratios(best))
    position = max(float(np.sqrt(square[record.told].mean() / 2)), RESOLUTION)
    velocity = max(position / (precision * period), RESOLUTION)
    return (
        record.local_jerk(position, position / (velocity * period), lag),
        position,
        velocity,
        lag * period,
    )


def _ratios(parameters: Array) -> tuple[float, float, float]:
    jerk, precision, lag = parameters
    return float(np.exp(jerk)), float(np.exp(precision)), float(lag)


class _Record:
    """One joint's measurements in cycles: q and q̇ T [rad], evenly spaced, missing ones filled."""

    def __init__(self, time: Array, segment: Labels, q: Array, qd: Array, period: float) -> None:
        observed = np.isfinite(q) & np.isfinite(qd)
        if np.count_nonzero(observed) < 2:
            raise ValueError("a joint has no position or no velocity: its noise is unknown")
        course = CubicHermiteSpline(time[observed], q[observed], qd[observed])
        self.values = np.stack([course(time), course(time, 1) * period], axis=1)
        self.segment, self.period = segment, period
        # What was filled in tells of its successor: neither that nor the next is an innovation.
        after_observed = np.concatenate([[False], observed[:-1] & (np.diff(segment) == 0)])
        self.told = observed & after_observed

    def deviance(self, jerk: float, precision: float, lag: float) -> tuple[float, Array]:
        """log |S| and eᵀ S⁻¹ e (N,) of the innovations e of the steady Kalman filter.

        jerk, precision: of jerk and velocity, beside positions' noise of one; lag: in cycles.
        """
        F = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]])
        H = np.array([[1, 0, 0], [0, precision, -precision * lag]])
        P = solve_discrete_are(F.T, H.T, jerk**2 * jerk_covariance(1.0), np.eye(2))
        S = H @ P @ H.T + np.eye(2)
        K = F @ P @ H.T @ np.linalg.inv(S)
        innovations = self._innovations(F - K @ H, K, H)
        square = np.einsum("ni,ij,nj->n", innovations, np.linalg.inv(S), innovations)
        return float(np.linalg.slogdet(S)[1] - 2 * np.log(precision)), square

    def _innovations(self, A: Array, K: Array, H: Array) -> Array:
        """Innovations (N, 2) of x⁺ = A x + K z; each segment starts with what it first measures."""
        scale = np.array([1, H[1, 1]])
        filters = [signal.ss2tf(A, K, -H, np.eye(2), input=index) for index in (0, 1)]
        innovations = np.empty_like(self.values)
        for rows in unbroken(self.segment):
            z = self.values[rows]
            z = scale * (z - z[0] - np.outer(np.arange(len(z)), [z[0, 1], 0]))
            innovations[rows] = sum(
                np.stack([signal.lfilter(row, poles, column) for row in zeros], axis=1)
                for (zeros, poles), column in zip(filters, z.T, strict=True)
            )
        return innovations

    def local_jerk(self, position: float, precision: float, lag: float) -> Array:
        """Jerk intensity about each sample (N,)."""
        ratios = JERKS * self.period**2.5 / position
        deviances = [self.deviance(ratio, precision, lag) for ratio in ratios]
        surprise = np.stack([logdet + square / position**2 for logdet, square in deviances], axis=1)
        count = round(JERK_WINDOW / self.period)
        surprise = moving_mean(np.where(self.told[:, None], surprise, 0), self.segment, count)
        weight = softmax(-count * surprise / 2, axis=1)
        return np.exp(weight @ np.log(JERKS))


def jerk_covariance(step: Array | float) -> Array:
    """Covariance (..., 3, 3) that a jerk held over a step [s], of intensity one, adds to q, q̇, q̈.

    Held, not white within the step: so q̇ changes by the integral of q̈ and by nothing else.
    """
    gained = np.asarray(step)[..., None] ** np.array([2.5, 1.5, 0.5]) / np.array([6, 2, 1])
    return gained[..., :, None] * gained[..., None, :]


def moving_mean(values: Array, segment: Labels, count: int) -> Array:
    """Mean of the finite values about each row within its segment, zero where there are none."""
    result = np.empty_like(values)
    for rows in unbroken(segment):
        known = np.isfinite(values[rows])
        total = uniform_filter1d(np.where(known, values[rows], 0), count, axis=0, mode="nearest")
        share = uniform_filter1d(known.astype(float), count, axis=0, mode="nearest")
        result[rows] = total / np.where(share > 0, share, 1)
    return result
