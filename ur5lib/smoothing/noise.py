"""The noise of encoders, estimated from a Kalman filter's innovations."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import expm
from scipy.ndimage import uniform_filter1d

from ur5lib.smoothing.simplex_search import search_together
from ur5lib.smoothing.steady_filter import SteadyFilter, steady_filter
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import unbroken

JERK_BANK = np.geomspace(1e-2, 1e3, 11)  # rad/s³/√Hz; from standstill to the hardest start
# Intensity relative to the finer noise, as in _Ratios; beyond it, a filter is lost to rounding.
MAX_DRIVEN = 1e7
VIBRATION_BANK = np.array([0.03, 0.2, 1.0, 4.0])  # relative to the whole recording's
NOISE_WINDOW = 0.1  # s; intensities and noise are taken as constant over it
# Weight of the whole recording's noise in each window.
PRIOR_DEGREES_OF_FREEDOM = 8
OUTLIER_SQUARE = 30.0  # beyond it, only the logarithm of a normalised innovation grows
RECORDED_RESOLUTION = 1e-6  # rad, rad/s: the last digit of a recording, and the least noise
POSITION_DECIMALS = 6  # by which positions are compared
RARE_COUNT_SHARE = 0.05  # below this share of the most frequent difference's count, another is rare
MIN_INNOVATION_VARIANCE = 1e-20  # keeps the likelihood of perfect data bounded
TUNING_DURATION = 40.0  # s; constant parameters are estimated from this long a stretch
# The optimiser varies log jerk and log precision of velocities, both relative to the positions'
# noise; lag in cycles; log intensity of the vibration, relative to that noise, too; log damping of
# the vibration.
PARAMETER_BOUNDS = [(-12.0, 6.0), (-8.0, 8.0), (-1.0, 1.0), (-12.0, 6.0), (-4.0, -1.0)]
SIMPLEX_START = [-2.8, 0.2, 0.0, -6.0, -2.0]
SIMPLEX_STEPS = [1.5, -1.0, 0.25, 4.0, 0.7]
MIN_VIBRATION_FREQUENCY = 10.0  # Hz
MAX_VIBRATION_FREQUENCY = 50.0  # Hz
NYQUIST_SHARE = 0.7  # vibrations are found up to this share of the Nyquist frequency


@dataclass(frozen=True)
class EncoderNoise:
    """The jerks that drive n joints, and the noise of their encoders, at each sample.

    jerk, vibration: (N, n) [rad/s³/√Hz], intensities of the white jerks that drive the motion and
    the vibration; frequency: (n,) [rad/s] and damping: (n,) of the vibration; position: (N, n)
    [rad] and velocity: (N, n) [rad/s], standard deviations; lag: (n,) [s] of measured velocities.
    """

    jerk: Array
    vibration: Array
    frequency: Array
    damping: Array
    position: Array
    velocity: Array
    lag: Array


def encoder_noise(time: Array, segment: Labels, q: Array, qd: Array) -> EncoderNoise:
    """Estimate the noise by maximum likelihood of the innovations of each joint's Kalman filter.

    time: (N,) [s], evenly spaced within a segment; segment: (N,) labels; q, qd: (N, n) [rad,
    rad/s], NaN where missing. Raises ValueError if a joint has no velocities.

    First, constant parameters maximise the likelihood of the innovations (Schweppe) in the
    TUNING_DURATION seconds in which the joint moves most. Then filters with different jerks and
    vibrations run over the whole recording. Jerk, vibration and noise at each sample are geometric
    means over these, weighted by each filter's likelihood in the window around the sample.
    """
    period = float(np.median(np.diff(time)))
    joints = [*zip(q.T, qd.T, strict=True)]
    busiest = [_busiest(qd, round(TUNING_DURATION / period)) for _, qd in joints]
    parts = [
        _JointRecord(time[rows], segment[rows], q[rows], qd[rows], period)
        for rows, (q, qd) in zip(busiest, joints, strict=True)
    ]
    joint_noises = [
        _joint_noise(ratios, part, _JointRecord(time, segment, *joint, period), quantum(joint[0]))
        for ratios, part, joint in zip(_most_likely(parts, period), parts, joints, strict=True)
    ]
    return EncoderNoise(
        *(np.stack(quantity, axis=-1) for quantity in zip(*joint_noises, strict=True))
    )


def quantum(q: Array) -> float:
    """Return the step in which a joint's positions (N,) [rad] were recorded; 0 if it never moved.

    It is the smallest difference between neighbouring values that is not rare. A joint need not
    visit every point of its encoder's grid, but it visits some neighbours; a few values off the
    grid do not count.
    """
    steps = np.diff(np.unique(np.round(q[np.isfinite(q)], POSITION_DECIMALS)))
    if len(steps) == 0:
        return 0.0
    sizes, counts = np.unique(np.round(steps, POSITION_DECIMALS), return_counts=True)
    return float(sizes[counts >= RARE_COUNT_SHARE * counts.max()][0])


def _most_likely(parts: list["_JointRecord"], period: float) -> list["_Ratios"]:
    """Return the parameters that maximise the likelihood of each joint's innovations in its part.

    The joints' searches advance together: their filters are computed as one stack.
    """
    highest = min(MAX_VIBRATION_FREQUENCY, NYQUIST_SHARE / (2 * period))
    swings = np.log(
        2 * np.pi * period * np.array([min(MIN_VIBRATION_FREQUENCY, highest / 2), highest])
    )
    start = np.array([*SIMPLEX_START, swings.mean()])

    def costs(joints: Sequence[int], parameters: Array) -> list[float]:
        # -2 log L / n, maximised over the positions' noise σ² = mean(eᵀ S⁻¹ e) / 2
        whites, logdets = _whitened_filters(_Ratios.from_parameters(parameters))
        return [
            float(logdet + 2 * np.log(parts[joint].variance(white) + MIN_INNOVATION_VARIANCE))
            for joint, white, logdet in zip(joints, whites.each(), logdets, strict=True)
        ]

    best = search_together(
        costs,
        len(parts),
        simplex=np.vstack([start, start + np.diag([*SIMPLEX_STEPS, 0.3])]),
        bounds=np.array([*PARAMETER_BOUNDS, swings]),
        xatol=0.1,
        fatol=1e-3,
    )
    return [*map(_Ratios.from_parameters, best)]


def _joint_noise(
    ratios: "_Ratios", part: "_JointRecord", record: "_JointRecord", step: float
) -> tuple[Array | float, ...]:
    """Return the noise of one joint, in the order of the fields of EncoderNoise.

    part: the samples to which `ratios` were fitted; record: the whole recording; step: of its
    positions [rad].
    """
    period = record.period
    # no noise is below what rounding to the encoder's grid makes
    finest = max(step / np.sqrt(12), RECORDED_RESOLUTION)
    position = max(float(np.sqrt(part.variance(_whitened_filters(ratios)[0]))), finest)
    jerk, vibration, scale = record.local(ratios, position)
    return (
        jerk,
        vibration,
        ratios.frequency / period,
        ratios.damping,
        np.maximum(scale * position, finest),
        np.maximum(scale * position / (ratios.precision * period), RECORDED_RESOLUTION),
        ratios.lag * period,
    )


def _busiest(qd: Array, count: int) -> slice:
    """Return the `count` successive samples in which a joint was measured to move most, as
    a slice.
    """
    if len(qd) <= count:
        return slice(None)
    speed = np.where(np.isfinite(qd), np.abs(qd) + RECORDED_RESOLUTION, 0)
    travelled = np.concatenate([[0], np.cumsum(speed)])
    first = int(np.argmax(travelled[count:] - travelled[:-count]))
    return slice(first, first + count)


class _Ratios(NamedTuple):
    """Noise parameters of one joint's filter, or as arrays those of several filters.

    Time is in cycles, and noise relative to that of the positions. jerk, vibration: intensities of
    the jerks that drive motion and vibration; precision: noise of positions over that of
    velocities; lag: of velocities, in cycles; damping and frequency (radians a cycle) of the
    vibration.
    """

    jerk: float | Array
    precision: float | Array
    lag: float | Array
    vibration: float | Array
    damping: float | Array
    frequency: float | Array

    @classmethod
    def from_parameters(cls, parameters: Array) -> "_Ratios":
        """Return the ratios from the optimiser's parameters (..., 6)."""
        jerk, precision, _, vibration, damping, frequency = np.moveaxis(np.exp(parameters), -1, 0)
        return cls(jerk, precision, parameters[..., 2], vibration, damping, frequency)


class _JointRecord:
    """One joint's measurements with time in cycles: q and q̇ T [rad], evenly spaced.

    Missing ones are filled in. The line through each segment's first position, with its first
    velocity, is subtracted.
    """

    def __init__(self, time: Array, segment: Labels, q: Array, qd: Array, period: float) -> None:
        observed = np.isfinite(q) & np.isfinite(qd)
        if np.count_nonzero(observed) < 2:
            raise ValueError("a joint has no position or no velocity: its noise is unknown")
        course = CubicHermiteSpline(time[observed], q[observed], qd[observed])
        self.values = np.stack([course(time), course(time, 1) * period], axis=1)
        self.segment, self.period = segment, period
        self.parts = unbroken(segment)
        for rows in self.parts:
            position, velocity = self.values[rows][0].copy()
            line = np.arange(rows.stop - rows.start) * velocity + position
            self.values[rows] -= np.stack([line, np.full(len(line), velocity)], axis=1)
        # a filled value depends on its successor: neither's innovation is valid
        after_observed = np.concatenate([[False], observed[:-1] & (np.diff(segment) == 0)])
        self.valid = observed & after_observed

    def squares(self, white: SteadyFilter) -> Array:
        """Return eᵀ S⁻¹ e (N,) of the innovations e of one of `_whitened_filters`."""
        square = np.empty(len(self.values))
        for rows in self.parts:
            square[rows] = sum(
                innovation**2 for innovation in white.innovations(self.values[rows]).T
            )
        return square

    def variance(self, white: SteadyFilter) -> float:
        """Return the mean of e² / S over the valid innovations e of positions and velocities."""
        return float(self.squares(white)[self.valid].mean() / 2)

    def local(self, ratios: _Ratios, position: float) -> tuple[Array, Array, Array]:
        """Return jerk, vibration, and noise relative to the whole recording's, (N,) each, at each
        sample.

        They are geometric means over a bank of filters, weighted by likelihood in the window. The
        prior of the noise's variance is inverse-gamma about that of the recording.
        """
        count, unit = max(1, round(NOISE_WINDOW / self.period)), position / self.period**2.5
        window_count = count * _window_mean(self.valid.astype(float), self.parts, count)
        jerks, shares = np.array([*product(JERK_BANK, VIBRATION_BANK)]).T
        most = MAX_DRIVEN / max(1.0, ratios.precision)
        bank = ratios._replace(
            jerk=np.minimum(jerks / unit, most),
            vibration=np.minimum(shares * ratios.vibration, most),
        )
        driven = np.log([bank.jerk * unit, bank.vibration * unit]).T
        weight, total = np.zeros(len(window_count)), np.zeros((3, len(window_count)))
        best = np.full(len(window_count), -np.inf)
        filters, logdets = _whitened_filters(bank)
        for white, logdet, logs in zip(filters.each(), logdets, driven, strict=True):
            square = np.where(self.valid, _limited_squares(self.squares(white) / position**2), 0)
            square = np.log(
                PRIOR_DEGREES_OF_FREEDOM + count * _window_mean(square, self.parts, count)
            )
            # log p(innovations of the window | jerk, vibration), the noise integrated out
            likelihood = (
                -window_count * logdet / 2 - (PRIOR_DEGREES_OF_FREEDOM / 2 + window_count) * square
            )
            top = np.maximum(best, likelihood)
            forget, trust = np.exp(best - top), np.exp(likelihood - top)
            weight, best = forget * weight + trust, top
            for sum_of_logs, log in zip(total, (*logs, square / 2), strict=True):
                sum_of_logs *= forget
                sum_of_logs += trust * log
        mean = total / weight
        # jerk and vibration are relative to the noise, too
        mean[2] -= np.log(PRIOR_DEGREES_OF_FREEDOM + 2 * window_count) / 2
        mean[:2] += mean[2]
        jerk, vibration, scale = np.exp(mean)
        return jerk, vibration, scale


def _limited_squares(square: Array) -> Array:
    """Return squares (N,), large ones reduced, so that one outlier does not dominate a window."""
    beyond = np.log(np.maximum(square / OUTLIER_SQUARE, 1))
    return np.minimum(square, OUTLIER_SQUARE) + OUTLIER_SQUARE * beyond


def _whitened_filters(ratios: _Ratios) -> tuple[SteadyFilter, Array]:
    """Return steady filters, from q and q̇ T to innovations scaled to covariance one, and log |S|.

    S is the covariance of the innovations before they are scaled. One filter is returned, or a
    stack if parameters are arrays.
    """
    # x⁺ = F x + w, z = H x + v, x = [θ, θ̇ T, θ̈ T², δ, δ̇ T, δ̈ T²]
    F, driven = motion_step(1.0, ratios.frequency, ratios.damping)
    driven = driven * np.stack([ratios.jerk, ratios.vibration], axis=-1)[..., None, :]
    scale = np.stack([np.ones_like(ratios.precision), ratios.precision], axis=-1)
    H = scale[..., None] * measures(ratios.lag)
    steady = steady_filter(F, driven @ driven.mT, H, np.eye(2))
    # S = H P Hᵀ + 1: no variance is below one, whatever rounding makes of it
    variances, axes = np.linalg.eigh(steady.S)
    variances = np.maximum(variances, 1.0)
    root = axes.mT / np.sqrt(variances)[..., None]
    zeros = np.einsum("...ij,...jkx,...k->...ikx", root, steady.zeros, scale)
    logdet = np.log(variances).sum(axis=-1) - 2 * np.log(ratios.precision)
    return steady._replace(zeros=zeros), logdet


def motion_step(
    step: float | Array, frequency: float | Array, damping: float | Array
) -> tuple[Array, Array]:
    """Return F of a joint's state over a step, and the effect on it of two white jerks of intensity
    one.

    The joint is at θ + δ: a motion, θ⃛ = jerk, and a vibration of its link, (d/dt + ω) (d²/dt² + 2
    ζ ω d/dt + ω²) δ = jerk. Both jerks are constant within the step, so that velocities change by
    exactly the integral of accelerations.
    step: (...,) [s], or 1 in cycles; frequency: ω (...,) [rad/s, or rad per cycle]; damping: ζ
    (...,). Returns F (..., 6, 6) and (..., 6, 2).
    """
    # d/dt [θ, θ̇, θ̈, δ, δ̇, δ̈, jerk, jerk of the vibration]
    A = np.zeros((*np.shape(frequency), 8, 8))
    A[..., [0, 1, 3, 4, 2, 5], [1, 2, 4, 5, 6, 7]] = 1
    A[..., 5, 3] = -(frequency**3)
    A[..., 5, 4] = -(frequency**2) * (1 + 2 * damping)
    A[..., 5, 5] = -frequency * (1 + 2 * damping)
    step = np.asarray(step)[..., None, None]
    moved = expm(A * step)
    return moved[..., :6, :6], moved[..., :6, 6:] / np.sqrt(step)


def measures(lag: float | Array) -> Array:
    """Return the matrix H (..., 2, 6) from a joint's state to its measured position and velocity;
    lag: (...,) [s].

    Encoders see the link, θ + δ; velocities the motor, θ̇ − lag θ̈.
    """
    H = np.zeros((*np.shape(lag), 2, 6))
    H[..., [0, 0, 1], [0, 3, 1]] = 1
    H[..., 1, 2] = -np.asarray(lag)
    return H


def moving_mean(values: Array, segment: Labels, count: int) -> Array:
    """Return the mean of the finite values in a window of `count` rows around each row of its
    segment.

    It is 0 if there are none.
    """
    parts, finite = unbroken(segment), np.isfinite(values)
    total = _window_mean(np.where(finite, values, 0), parts, count)
    share = _window_mean(finite.astype(float), parts, count)
    return total / np.where(share > 0, share, 1)


def _window_mean(values: Array, parts: list[slice], count: int) -> Array:
    """Return the mean of `count` values around each row in its part."""
    result = np.empty_like(values)
    for rows in parts:
        uniform_filter1d(values[rows], count, axis=0, output=result[rows], mode="nearest")
    return result
