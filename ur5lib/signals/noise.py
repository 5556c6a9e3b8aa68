"""Noise of the encoders from innovations, and tests of the innovations."""

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
RESOLUTION = 1e-6  # rad, rad/s: the last digit of a recording, and the least noise
NOTHING = 1e-20  # keeps the likelihood of perfect data bounded
LAGS = 10  # of the portmanteau test
# Logarithms of jerk and velocity precision relative to the positions' noise, and lag in cycles.
BOUNDS = [(-12.0, 6.0), (-8.0, 8.0), (-1.0, 1.0)]
SIMPLEX = np.array([[-2.8, 0.2, 0.0], [-1.3, 0.2, 0.0], [-2.8, -0.8, 0.0], [-2.8, 0.2, 0.25]])


@dataclass(frozen=True)
class EncoderNoise:
    """Process noise of the joints and measurement noise of their encoders.

    jerk: (N, 6) [rad/s³/√Hz], intensity of white jerk at each sample; position: (6,) [rad] and
    velocity: (6,) [rad/s], standard deviations; lag: (6,) [s] of the measured velocity.
    """

    jerk: Array
    position: Array
    velocity: Array
    lag: Array


@dataclass(frozen=True)
class InnovationTest:
    """Tests of normalised innovations: variance one, and whiteness.

    variance: (M,), mean squares; variance_limits: (M, 2), their 95 % interval; portmanteau: (M,),
    Ljung-Box statistic; portmanteau_limit: its 95 % point; consistent, white: (M,), whether the
    variance and the whiteness pass.
    """

    variance: Array
    variance_limits: Array
    portmanteau: Array
    portmanteau_limit: float
    consistent: Mask
    white: Mask


def encoder_noise(time: Array, segment: Labels, q: Array, qd: Array) -> EncoderNoise:
    """Estimate the noise by maximum likelihood of the innovations of each joint's Kalman filter.

    time: (N,) [s], evenly spaced within a segment; segment: (N,) labels; q, qd: (N, 6) [rad,
    rad/s], NaN where missing. Raises ValueError if a joint has no velocities.

    Position, velocity and lag maximise the likelihood (Schweppe) with one jerk for all times; then,
    with a bank of jerks, the posterior mean of log jerk is taken in a window around each sample.
    """
    period = float(np.median(np.diff(time)))
    joints = [_joint_noise(time, segment, *joint, period) for joint in zip(q.T, qd.T, strict=True)]
    jerk, position, velocity, lag = (np.stack(each, axis=-1) for each in zip(*joints, strict=True))
    return EncoderNoise(jerk, position, velocity, lag)


def innovation_test(innovations: Array, segment: Labels) -> InnovationTest:
    """Test normalised innovations (N, M), NaN where nothing was measured.

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
    """Estimate jerk (N,), position, velocity and lag of one joint."""
    record = _Record(time, segment, q, qd, period)

    def cost(parameters: Array) -> float:
        # -2 log L / n, maximised over the positions' noise σ² = mean(eᵀ S⁻¹ e) / 2
        logdet, square = record.deviance(*_ratios(parameters))
        return logdet + 2 * float(np.log(square[record.valid].mean() + NOTHING))

    best = minimize(
        cost,
        SIMPLEX[0],
        method="Nelder-Mead",
        bounds=BOUNDS,
        options={"initial_simplex": SIMPLEX, "xatol": 0.05, "fatol": 1e-4},
    ).x
    _, precision, lag = _ratios(best)
    _, square = record.deviance(*_ratios(best))
    position = max(float(np.sqrt(square[record.valid].mean() / 2)), RESOLUTION)
    velocity = max(position / (precision * period), RESOLUTION)
    return (
        record.local_jerk(position, position / (velocity * period), lag),
        position,
        velocity,
        lag * period,
    )


def _ratios(parameters: Array) -> tuple[float, float, float]:
    """Return jerk, velocity precision and lag from the optimiser's parameters (3,)."""
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
        # a filled value depends on its successor: neither's innovation is valid
        after_observed = np.concatenate([[False], observed[:-1] & (np.diff(segment) == 0)])
        self.valid = observed & after_observed

    def deviance(self, jerk: float, precision: float, lag: float) -> tuple[float, Array]:
        """Return log |S| and eᵀ S⁻¹ e (N,) of the innovations e of the steady Kalman filter.

        jerk, precision: of jerk and velocity, relative to the positions' noise; lag: in cycles.
        """
        # x⁺ = F x + w, z = H x + v, x = [q, q̇ T, q̈ T²]
        F = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]])
        H = np.array([[1, 0, 0], [0, precision, -precision * lag]])
        # steady covariance P of the prediction, S = H P Hᵀ + 1, K = F P Hᵀ S⁻¹
        P = solve_discrete_are(F.T, H.T, jerk**2 * jerk_covariance(1.0), np.eye(2))
        S = H @ P @ H.T + np.eye(2)
        K = F @ P @ H.T @ np.linalg.inv(S)
        # x⁺ = (F - K H) x + K z
        innovations = self._innovations(F - K @ H, K, H)
        square = np.einsum("ni,ij,nj->n", innovations, np.linalg.inv(S), innovations)
        return float(np.linalg.slogdet(S)[1] - 2 * np.log(precision)), square

    def _innovations(self, A: Array, K: Array, H: Array) -> Array:
        """Return innovations (N, 2) of x⁺ = A x + K z; segments start at their first value."""
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
        """Return the jerk intensity around each sample (N,)."""
        count = round(JERK_WINDOW / self.period)
        # log |S| + eᵀ S⁻¹ e under each jerk of the bank, its mean over the window
        surprise = np.empty((len(self.valid), len(JERKS)))
        for jerk, mean in zip(JERKS, surprise.T, strict=True):
            logdet, square = self.deviance(jerk * self.period**2.5 / position, precision, lag)
            own = np.where(self.valid, logdet + square / position**2, 0)
            mean[:] = moving_mean(own, self.segment, count)
        # posterior p(jerk) ∝ exp(-½ Σ) over the window, and the mean of log jerk
        weight = softmax(-count * surprise / 2, axis=1)
        return np.exp(weight @ np.log(JERKS))


def jerk_covariance(step: Array | float) -> Array:
    """Return the covariance (..., 3, 3) of q, q̇, q̈ after a step [s] of a jerk of intensity one.

    The jerk is constant within the step, not white, so that q̇ changes by exactly the integral of q̈.
    """
    gained = np.asarray(step)[..., None] ** np.array([2.5, 1.5, 0.5]) / np.array([6, 2, 1])
    return gained[..., :, None] * gained[..., None, :]


def moving_mean(values: Array, segment: Labels, count: int) -> Array:
    """Return the mean of the finite values around each row in its segment, zero without any."""
    result = np.empty_like(values)
    for rows in unbroken(segment):
        known = np.isfinite(values[rows])
        total = uniform_filter1d(np.where(known, values[rows], 0), count, axis=0, mode="nearest")
        share = uniform_filter1d(known.astype(float), count, axis=0, mode="nearest")
        result[rows] = total / np.where(share > 0, share, 1)
    return result
