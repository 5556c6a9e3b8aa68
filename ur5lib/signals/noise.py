"""Noise of the encoders from innovations, and tests of the innovations."""

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import expm
from scipy.ndimage import uniform_filter1d
from scipy.optimize import minimize
from scipy.stats import chi2

from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import unbroken
from ur5lib.timeseries.steady_filter import SteadyFilter, steady_filter

JERKS = np.geomspace(1e-2, 1e3, 11)  # rad/s³/√Hz: from standstill to the hardest start
VIBRATIONS = np.array([0.03, 0.2, 1.0, 4.0])  # relative to that of the whole recording
WINDOW = 0.1  # s, over which intensities and noise are taken as constant
FAITH = 8  # degrees of freedom with which the noise of the whole recording counts in a window
RESOLUTION = 1e-6  # rad, rad/s: the last digit of a recording, and the least noise
DIGITS = 6  # to which positions count as different
RARE = 0.05  # of the commonest difference's count
NOTHING = 1e-20  # keeps the likelihood of perfect data bounded
LAGS = 10  # of the portmanteau test
LONGEST = 40.0  # s, of a recording from which its noise is estimated
# Logarithms of jerk and velocity precision relative to the positions' noise, lag in cycles,
# logarithms of the vibration's intensity relative to the positions' noise and of its damping.
BOUNDS = [(-12.0, 6.0), (-8.0, 8.0), (-1.0, 1.0), (-12.0, 6.0), (-4.0, -1.0)]
START, STEPS = [-2.8, 0.2, 0.0, -6.0, -2.0], [1.5, -1.0, 0.25, 4.0, 0.7]
SLOWEST, FASTEST = 10.0, 50.0  # Hz, of vibrations
NYQUIST_SHARE = 0.7  # of the Nyquist frequency, up to which vibrations are found


@dataclass(frozen=True)
class EncoderNoise:
    """What drives the joints, and the noise of their encoders, at each sample.

    jerk, vibration: (N, 6) [rad/s³/√Hz], intensities of the white jerks that drive the motion and
    the vibration; frequency: (6,) [rad/s] and damping: (6,) of the vibration; position: (N, 6)
    [rad] and velocity: (N, 6) [rad/s], standard deviations; lag: (6,) [s] of measured velocities.
    """

    jerk: Array
    vibration: Array
    frequency: Array
    damping: Array
    position: Array
    velocity: Array
    lag: Array


@dataclass(frozen=True)
class InnovationTest:
    """Tests of normalised innovations: variance one, and whiteness.

    variance: (M,), mean squares; variance_limits: (M, 2), their 95 % interval; portmanteau: (M,),
    Ljung-Box statistic; portmanteau_limit: its 95 % point; consistent, white: (M,), whether the
    variance and the whiteness pass; colour: (M,), the variance of a mean of successive innovations
    relative to that of white ones, 1 + 2 Σ ρ over all lags, where they are not white; at least 1.
    """

    variance: Array
    variance_limits: Array
    portmanteau: Array
    portmanteau_limit: float
    consistent: Mask
    white: Mask
    colour: Array


def encoder_noise(time: Array, segment: Labels, q: Array, qd: Array) -> EncoderNoise:
    """Estimate the noise by maximum likelihood of the innovations of each joint's Kalman filter.

    time: (N,) [s], evenly spaced within a segment; segment: (N,) labels; q, qd: (N, 6) [rad,
    rad/s], NaN where missing. Raises ValueError if a joint has no velocities.

    All parameters, constant, maximise the likelihood (Schweppe) of the stretch of LONGEST that
    moves most; then, with a bank of jerks and vibrations, the posterior mean of their logarithms
    and of the noise's is taken in a window around each sample.
    """
    period = float(np.median(np.diff(time)))
    joints = [_joint_noise(time, segment, *joint, period) for joint in zip(q.T, qd.T, strict=True)]
    return EncoderNoise(*(np.stack(each, axis=-1) for each in zip(*joints, strict=True)))


def innovation_test(innovations: Array, segment: Labels) -> InnovationTest:
    """Test normalised innovations (N, M), NaN where nothing was measured.

    Mean square against χ²; autocorrelation ρ over LAGS lags within segments by Ljung and Box.
    """
    count = np.isfinite(innovations).sum(axis=0)
    variance = np.nanmean(innovations**2, axis=0)
    limits = chi2.ppf([0.025, 0.975], count[:, None]) / count[:, None]
    portmanteau, colour = np.zeros(len(count)), np.ones(len(count))
    for lag in range(1, LAGS + 1):
        product = innovations[lag:] * innovations[:-lag]
        product[segment[lag:] != segment[:-lag]] = np.nan
        correlation = np.nanmean(product, axis=0) / variance
        portmanteau += count * (count + 2) * correlation**2 / (count - lag)
        colour += 2 * correlation
    limit = float(chi2.ppf(0.95, LAGS))
    consistent = (limits[:, 0] <= variance) & (variance <= limits[:, 1])
    white = portmanteau <= limit
    colour = np.where(white, 1, np.maximum(colour, 1))
    return InnovationTest(variance, limits, portmanteau, limit, consistent, white, colour)


def quantum(q: Array) -> float:
    """Return the step in which a joint's positions (N,) [rad] were recorded; 0 if it never moved.

    The smallest difference of neighbouring values that is not rare: a joint that does not visit all
    points of its grid still visits some neighbours, and few values are odd.
    """
    steps = np.diff(np.unique(np.round(q[np.isfinite(q)], DIGITS)))
    if len(steps) == 0:
        return 0.0
    sizes, counts = np.unique(np.round(steps, DIGITS), return_counts=True)
    return float(sizes[counts >= RARE * counts.max()][0])


def _joint_noise(
    time: Array, segment: Labels, q: Array, qd: Array, period: float
) -> tuple[Array | float, ...]:
    """Estimate the noise of one joint, in the order of EncoderNoise."""
    busiest = _busiest(qd, round(LONGEST / period))
    part = _Record(time[busiest], segment[busiest], q[busiest], qd[busiest], period)
    highest = min(FASTEST, NYQUIST_SHARE / (2 * period))
    swings = 2 * np.pi * period * np.array([min(SLOWEST, highest / 2), highest])
    limits = [*BOUNDS, tuple(np.log(swings).tolist())]
    start = np.array([*START, sum(limits[-1]) / 2])

    def cost(parameters: Array) -> float:
        # -2 log L / n, maximised over the positions' noise σ² = mean(eᵀ S⁻¹ e) / 2
        logdet, square = part.deviance(_Ratios.of(parameters))
        return logdet + 2 * float(np.log(square[part.valid].mean() + NOTHING))

    best = minimize(
        cost,
        start,
        method="Nelder-Mead",
        bounds=limits,
        options={
            "initial_simplex": np.vstack([start, start + np.diag([*STEPS, 0.3])]),
            "xatol": 0.1,
            "fatol": 1e-3,
        },
    ).x
    ratios = _Ratios.of(best)
    _, square = part.deviance(ratios)
    finest = max(quantum(q) / np.sqrt(12), RESOLUTION)
    position = max(float(np.sqrt(square[part.valid].mean() / 2)), finest)
    record = _Record(time, segment, q, qd, period)
    jerk, vibration, scale = record.local(ratios, position)
    return (
        jerk,
        vibration,
        ratios.frequency / period,
        ratios.damping,
        np.maximum(scale * position, finest),
        np.maximum(scale * position / (ratios.precision * period), RESOLUTION),
        ratios.lag * period,
    )


def _busiest(qd: Array, count: int) -> slice:
    """Return the stretch of so many samples in which a joint moves most."""
    if len(qd) <= count:
        return slice(None)
    travelled = np.concatenate([[0], np.cumsum(np.abs(np.nan_to_num(qd)))])
    first = int(np.argmax(travelled[count:] - travelled[:-count]))
    return slice(first, first + count)


class _Ratios(NamedTuple):
    """Parameters of the filter in cycles, relative to the positions' noise.

    jerk, vibration: what drives motion and vibration; precision: of velocities; lag: of velocities,
    in cycles; damping and frequency (radians a cycle) of the vibration.
    """

    jerk: float
    precision: float
    lag: float
    vibration: float
    damping: float
    frequency: float

    @classmethod
    def of(cls, parameters: Array) -> "_Ratios":
        """Return the ratios from the optimiser's parameters (6,)."""
        jerk, precision, lag, vibration, damping, frequency = parameters.tolist()
        powers = np.exp([jerk, precision, vibration, damping, frequency]).tolist()
        return cls(powers[0], powers[1], lag, *powers[2:])


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

    def deviance(self, ratios: _Ratios) -> tuple[float, Array]:
        """Return log |S| and eᵀ S⁻¹ e (N,) of the innovations e of the steady Kalman filter."""
        # x⁺ = F x + w, z = H x + v, x = [θ, θ̇ T, θ̈ T², δ, δ̇ T, δ̈ T²]
        F, driven = motion_step(1.0, ratios.frequency, ratios.damping)
        Q = driven @ np.diag([ratios.jerk**2, ratios.vibration**2]) @ driven.T
        H = measures(ratios.lag) * np.array([[1], [ratios.precision]])
        steady = steady_filter(F, Q, H, np.eye(2))
        innovations = self._innovations(steady, np.array([1, ratios.precision]))
        square = np.einsum("ni,ij,nj->n", innovations, np.linalg.inv(steady.S), innovations)
        return float(np.linalg.slogdet(steady.S)[1] - 2 * np.log(ratios.precision)), square

    def _innovations(self, steady: SteadyFilter, scale: Array) -> Array:
        """Return innovations (N, 2); segments start at their first value."""
        innovations = np.empty_like(self.values)
        for rows in unbroken(self.segment):
            z = self.values[rows]
            z = scale * (z - z[0] - np.outer(np.arange(len(z)), [z[0, 1], 0]))
            innovations[rows] = steady.innovations(z)
        return innovations

    def local(self, ratios: _Ratios, position: float) -> tuple[Array, Array, Array]:
        """Return the intensities of jerk and vibration, and the noise relative to that of the whole
        recording, around each sample (N,) each.

        Means of their logarithms over the bank, each jerk and vibration weighted by its likelihood
        in the window. The noise's variance has an inverse-gamma prior about that of the recording.
        """
        count = round(WINDOW / self.period)
        known = count * moving_mean(self.valid.astype(float), self.segment, count)
        unit = position / self.period**2.5
        weight, total = np.zeros(len(self.valid)), np.zeros((3, len(self.valid)))
        best = np.full(len(self.valid), -np.inf)
        for jerk, share in product(JERKS, VIBRATIONS):
            vibration = share * ratios.vibration
            own = ratios._replace(jerk=jerk / unit, vibration=vibration)
            logdet, square = self.deviance(own)
            square = np.where(self.valid, square / position**2, 0)
            square = FAITH + count * moving_mean(square, self.segment, count)
            # log p(innovations of the window | jerk, vibration), the noise integrated out
            likelihood = -known * logdet / 2 - (FAITH / 2 + known) * np.log(square)
            top = np.maximum(best, likelihood)
            forget, trust = np.exp(best - top), np.exp(likelihood - top)
            # all that drives the joint is relative to the noise, too
            scale = np.log(square / (FAITH + 2 * known)) / 2
            logs = np.stack([np.log(jerk) + scale, np.log(vibration * unit) + scale, scale])
            total = forget * total + trust * logs
            weight, best = forget * weight + trust, top
        jerk, vibration, scale = np.exp(total / weight)
        return jerk, vibration, scale


def motion_step(step: float, frequency: float, damping: float) -> tuple[Array, Array]:
    """Return how a joint moves on within a step, F (6, 6), and what two jerks of intensity one add.

    The joint is at θ + δ: a motion, θ⃛ = jerk, and a vibration of its link,
    (d/dt + ω) (d²/dt² + 2 ζ ω d/dt + ω²) δ = jerk. Both jerks are constant within the step, so that
    velocities change by exactly the integral of accelerations.

    step: [s], or 1 in cycles; frequency: ω [rad/s, or a cycle]; damping: ζ. Returns F and (6, 2).
    """
    # d/dt [θ, θ̇, θ̈, δ, δ̇, δ̈, jerk, jerk of the vibration]
    A = np.zeros((8, 8))
    A[0, 1] = A[1, 2] = A[3, 4] = A[4, 5] = A[2, 6] = A[5, 7] = 1
    A[5, 3:6] = -frequency * np.array(
        [frequency**2, frequency * (1 + 2 * damping), 1 + 2 * damping]
    )
    moved = expm(A * step)
    return moved[:6, :6], moved[:6, 6:] / np.sqrt(step)


def measures(lag: float) -> Array:
    """Return H (2, 6): encoders see the link, θ + δ; velocities the motor, θ̇ − lag θ̈."""
    return np.array([[1, 0, 0, 1, 0, 0], [0, 1, -lag, 0, 0, 0]])


def moving_mean(values: Array, segment: Labels, count: int) -> Array:
    """Return the mean of the finite values around each row in its segment, zero without any."""
    result = np.empty_like(values)
    for rows in unbroken(segment):
        known = np.isfinite(values[rows])
        total = uniform_filter1d(np.where(known, values[rows], 0), count, axis=0, mode="nearest")
        share = uniform_filter1d(known.astype(float), count, axis=0, mode="nearest")
        result[rows] = total / np.where(share > 0, share, 1)
    return result
