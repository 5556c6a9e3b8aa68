"""Kalman smoother of linear time-varying systems, in chunks of constant memory, and tests of its
innovations.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy  # loads scipy.special at its first use

from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import chunks

PORTMANTEAU_LAGS = 10  # samples
CHUNK_NUMBERS = 1 << 20  # numbers in the matrices F of a chunk: 4,608 samples of six joints
LANE_SAMPLES = 256  # samples of a lane; the lanes of a chunk are filtered side by side


class Gaussians(NamedTuple):
    """Means (N, ..., X) and covariances (N, ..., X, X) of the states at N samples."""

    mean: Array
    covariance: Array

    def at(self, rows: slice | int) -> "Gaussians":
        """Return the means and covariances of some samples."""
        return Gaussians(self.mean[rows], self.covariance[rows])

    def copy(self) -> "Gaussians":
        """Return a copy, so that the arrays of other samples can be freed."""
        return Gaussians(self.mean.copy(), self.covariance.copy())

    def followed_by(self, last: "Gaussians") -> "Gaussians":
        """Return these states, with the state of one more sample appended."""
        pairs = zip(self, last, strict=True)
        return Gaussians(*(np.concatenate([arrays, more[None]]) for arrays, more in pairs))


def rts_pass(cross: Array, prior: Gaussians, posterior: Gaussians, end: Gaussians) -> Gaussians:
    """Return the states at samples 0 to N given all measurements.

    Rauch, Tung and Striebel's recursion from the last sample to the first. cross: (N, ..., X, X),
    F_k+1 P_k, the covariance of each state with its predecessor; prior: of a filter before the
    measurements of samples 1 to N; posterior: after those of samples 0 to N - 1; end: of sample N,
    given all measurements.
    """
    mean, covariance = posterior.followed_by(end)
    # G_k = P_k F_k+1ᵀ (P⁻_k+1)⁻¹
    gain = np.linalg.solve(prior.covariance, cross).mT
    # x̂_k = x_k + G_k (x̂_k+1 - x⁻_k+1), P̂_k = P_k + G_k (P̂_k+1 - P⁻_k+1) G_kᵀ
    for k in range(len(gain) - 1, -1, -1):
        mean[k] += np.matvec(gain[k], mean[k + 1] - prior.mean[k])
        covariance[k] += gain[k] @ (covariance[k + 1] - prior.covariance[k]) @ gain[k].mT
    return Gaussians(mean, covariance)


@dataclass(frozen=True)
class LinearSystem:
    """B independent linear systems at N samples, x_k = F_k x_{k-1} + w, z_k = H_k x_k + v.

    F, Q: (N, B, X, X), transition from the previous sample to each, and covariance of w; H: (N, B,
    M, X); z: (N, B, M), NaN where nothing was measured; R: (N, B, M), variances of v.
    """

    F: Array
    Q: Array
    H: Array
    z: Array
    R: Array

    def side_by_side(self, lanes: int) -> "LinearSystem":
        """Return K lanes of successive samples as systems of their own, (N / K, K, B, ...)."""
        return LinearSystem(
            *(
                values.reshape(lanes, -1, *values.shape[1:]).swapaxes(0, 1)
                for values in vars(self).values()
            )
        )


class Smoothed(NamedTuple):
    """The states of some samples, given all measurements, and normalised innovations (N, B, M)."""

    rows: slice
    states: Gaussians
    innovations: Array


System = Callable[[slice], LinearSystem]
"""Returns the system of some samples."""
Later = tuple[Array, Gaussians, Gaussians]
"""F of the next sample, its state before its measurement, and given all measurements."""


def smooth(system: System, count: int) -> Iterator[Smoothed]:
    """Yield the smoothed states of `count` samples, chunk by chunk, from the last to the first.

    The forward pass stores only the state before each lane of a chunk; the backward pass filters
    each chunk, its lanes side by side, which saves time and memory. Raises numpy.linalg.LinAlgError
    if a state has no uncertainty.
    """
    shape = system(slice(1)).F.shape
    state, lane_starts = Gaussians(np.zeros((1, *shape[1:-1])), np.zeros(shape)), []
    for rows in _chunks(count, math.prod(shape)):
        starts = [state, *_lane_ends(system(rows), state)]
        state = starts.pop()
        lane_starts.append((rows, Gaussians(*map(np.concatenate, zip(*starts, strict=True)))))
    next_sample: Later | None = None
    for rows, starts in reversed(lane_starts):
        part = system(rows)
        prior, states = _smooth(part, starts, next_sample)
        next_sample = part.F[0].copy(), prior.at(0).copy(), states.at(0).copy()
        yield Smoothed(rows, states, _innovations(part, prior))


def _chunks(count: int, numbers: int) -> list[slice]:
    """Return slices of successive samples that together cover `count`: whole lanes, then the rest;
    numbers: count of numbers in F of one sample.
    """
    lanes_samples = count - count % LANE_SAMPLES
    full = chunks(lanes_samples, max(1, CHUNK_NUMBERS // numbers // LANE_SAMPLES) * LANE_SAMPLES)
    return full if lanes_samples == count else [*full, slice(lanes_samples, count)]


def _smooth(
    part: LinearSystem, before: Gaussians, after: Later | None
) -> tuple[Gaussians, Gaussians]:
    """Return the states of some samples before their measurements, and given all measurements."""
    F, (prior, posterior) = part.F[1:], _filter(part, before)
    later, earlier, end = prior.at(slice(1, None)), posterior.at(slice(-1)), posterior.at(-1)
    if after is not None:
        F, later = np.concatenate([F, after[0][None]]), later.followed_by(after[1])
        earlier, end = posterior, after[2]
    # cov(x_k+1, x_k) = F_k+1 P_k
    states = rts_pass(F @ earlier.covariance, later, earlier, end)
    return prior, states.at(slice(len(part.z)))


def _filter(system: LinearSystem, before: Gaussians) -> tuple[Gaussians, Gaussians]:
    """Return the states before and after each measurement, (N, B, X) each.

    before: (K, B, X), the states before each of K lanes of N / K samples.
    """
    lanes = len(before.mean)
    results = np.empty((2, *system.F.shape[:-1])), np.empty((2, *system.F.shape))
    means, covariances = (
        values.reshape(2, lanes, -1, *values.shape[2:]).swapaxes(1, 2) for values in results
    )
    steps = _filter_steps(system.side_by_side(lanes), before.mean[..., None], before.covariance)
    for k, step in enumerate(steps):
        for which, state in enumerate((step.prior, step.posterior)):
            means[which, k], covariances[which, k] = state.mean[..., 0], state.covariance
    prior, posterior = map(Gaussians, *results)
    return prior, posterior


class FilterStep(NamedTuple):
    """A step of a Kalman filter: the states before and after its measurement, and the innovation.

    innovation: z - H x, (..., M, D); information: its inverse covariance S⁻¹ = (H P Hᵀ + R)⁻¹,
    (..., M, M).
    """

    prior: Gaussians
    posterior: Gaussians
    innovation: Array
    information: Array


def _filter_steps(system: LinearSystem, x: Array, P: Array) -> Iterator[FilterStep]:
    """Yield the steps of a filter that starts from x (..., X, D), P (..., X, X).

    The first of the D columns of x is the state. The others are derivatives of it, which are not
    measured: they do not depend on z.
    """
    measured = np.isfinite(system.z)
    H = np.where(measured[..., None], system.H, 0.0)
    z = np.zeros((*system.z.shape, x.shape[-1]))
    z[..., 0] = np.where(measured, system.z, 0.0)
    R = system.R[..., None] * np.eye(H.shape[-2])
    eye = np.eye(H.shape[-1])
    for k, F in enumerate(system.F):
        # prediction: x = F x, P = F P Fᵀ + Q
        x, P = F @ x, F @ P @ F.mT + system.Q[k]
        prior = Gaussians(x, P)
        # correction: K = P Hᵀ S⁻¹, x += K (z - H x), P = (I - K H) P (I - K H)ᵀ + K R Kᵀ
        seen_by = H[k] @ P
        innovation, information = z[k] - H[k] @ x, np.linalg.inv(seen_by @ H[k].mT + R[k])
        K = seen_by.mT @ information
        x = x + K @ innovation
        reduction = eye - K @ H[k]
        P = reduction @ P @ reduction.mT + K @ R[k] @ K.mT
        yield FilterStep(prior, Gaussians(x, P), innovation, information)


def _lane_ends(system: LinearSystem, before: Gaussians) -> Iterator[Gaussians]:
    """Yield the state after each lane, (1, B, X); before: the state before the first.

    All lanes are filtered side by side, each from a state of exactly 0. From any other state x, a
    lane ends at A x + b with the same covariance C, and its measurements have a log-likelihood of
    ηᵀ x - ½ xᵀ J x (Särkkä and García-Fernández, IEEE Trans. Automatic Control 66, 2021).
    """
    lanes = max(1, len(system.z) // LANE_SAMPLES)
    parts = system.side_by_side(lanes)
    unit = np.broadcast_to(np.eye(system.F.shape[-1]), parts.F.shape[1:])
    start = np.concatenate([np.zeros((*unit.shape[:-1], 1)), unit], axis=-1)  # [0, dx / dx]
    products = np.zeros((*unit.shape[:-2], start.shape[-1], start.shape[-1]))
    for step in _filter_steps(parts, start, np.zeros_like(unit)):
        # innovations [e, de / dx]: Σ [e, de / dx]ᵀ S⁻¹ [e, de / dx]
        products = products + step.innovation.mT @ step.information @ step.innovation
    eta, J = -products[..., 1:, :1], products[..., 1:, 1:]
    (b, A), C = np.split(step.posterior.mean, [1], axis=-1), step.posterior.covariance
    x, P = before.mean[0][..., None], before.covariance[0]
    for lane in range(lanes):
        # given the lane's measurements: P = (P⁻¹ + J)⁻¹ = (I + P J)⁻¹ P, x += P (η - J x)
        P = np.linalg.solve(unit[lane] + P @ J[lane], P)
        x = x + P @ (eta[lane] - J[lane] @ x)
        # after the lane: x = A x + b, P = A P Aᵀ + C
        x, P = A[lane] @ x + b[lane], A[lane] @ P @ A[lane].mT + C[lane]
        yield Gaussians(x[None, ..., 0], P[None])


def _innovations(system: LinearSystem, prior: Gaussians) -> Array:
    """Return (z - H x⁻) / sqrt diag(H P⁻ Hᵀ + R), NaN where nothing was measured."""
    variance = np.sum((system.H @ prior.covariance) * system.H, axis=-1) + system.R
    return (system.z - np.matvec(system.H, prior.mean)) / np.sqrt(variance)


@dataclass(frozen=True)
class InnovationTest:
    """Tests of normalised innovations: variance one, and whiteness.

    variance: (M,), mean squares; variance_limits: (M, 2), their 95 % interval; portmanteau: (M,),
    Ljung-Box statistic; portmanteau_limit: its 95 % point; consistent, white: (M,), whether the
    variance and the whiteness pass; colour: (M,), 1 + 2 Σ ρ over PORTMANTEAU_LAGS lags, the
    variance of a mean of successive innovations over that of white ones: at least 1, and 1 for
    those that pass as white.
    """

    variance: Array
    variance_limits: Array
    portmanteau: Array
    portmanteau_limit: float
    consistent: Mask
    white: Mask
    colour: Array


def innovation_test(innovations: Array, segment: Labels) -> InnovationTest:
    """Test normalised innovations (N, M), NaN where nothing was measured.

    The mean square is compared with χ². The autocorrelations ρ over PORTMANTEAU_LAGS lags, within
    segments, are compared with those of white noise by the test of Ljung and Box.
    """
    count = np.isfinite(innovations).sum(axis=0)
    # one channel after the other, for the memory of long recordings
    variance = np.array([np.nanmean(channel**2) for channel in innovations.T])
    covariance = np.array([_autocovariance(channel, segment) for channel in innovations.T])
    correlation = covariance / variance[:, None]  # (M, PORTMANTEAU_LAGS)
    # Q = n (n + 2) Σ ρ² / (n - lag)
    lags = np.arange(1, PORTMANTEAU_LAGS + 1)
    portmanteau = count * (count + 2) * (correlation**2 / (count[:, None] - lags)).sum(axis=1)
    limit = float(_chi2(0.95, PORTMANTEAU_LAGS))
    white = portmanteau <= limit
    colour = np.where(white, 1, np.maximum(1 + 2 * correlation.sum(axis=1), 1))
    limits = _chi2(np.array([0.025, 0.975]), count[:, None]) / count[:, None]
    consistent = (limits[:, 0] <= variance) & (variance <= limits[:, 1])
    return InnovationTest(variance, limits, portmanteau, limit, consistent, white, colour)


def _autocovariance(innovation: Array, segment: Labels) -> list[float]:
    """Return the mean products of a channel (N,) over 1 to PORTMANTEAU_LAGS, within segments."""
    means = []
    for lag in range(1, PORTMANTEAU_LAGS + 1):
        within = segment[lag:] == segment[:-lag]
        means.append(float(np.nanmean((innovation[lag:] * innovation[:-lag])[within])))
    return means


def _chi2(share: Array | float, freedom: Labels | int) -> Array:
    """Return quantiles of χ² with some degrees of freedom."""
    return np.asarray(2 * scipy.special.gammaincinv(np.asarray(freedom) / 2, share))
