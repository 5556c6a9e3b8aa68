"""Kalman smoother of linear time-varying systems, in chunks of constant memory, and tests of its
innovations.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.special import gammaincinv

from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import chunks

LAGS = 10  # of the portmanteau test


class Gaussians(NamedTuple):
    """Means (N, ..., X) and covariances (N, ..., X, X) of the states at N samples."""

    mean: Array
    covariance: Array

    def at(self, rows: slice | int) -> "Gaussians":
        """Return the states of some samples."""
        return Gaussians(self.mean[rows], self.covariance[rows])

    def copy(self) -> "Gaussians":
        """Return a copy, which does not keep the arrays of other samples alive."""
        return Gaussians(self.mean.copy(), self.covariance.copy())

    def followed_by(self, last: "Gaussians") -> "Gaussians":
        """Return the states with that of one more sample appended."""
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


CHUNK = 1 << 20  # numbers in the matrices F of a chunk: 4,608 samples of six joints
LANE = 256  # samples of the lanes of a chunk, which are filtered side by side


@dataclass(frozen=True)
class LinearSystem:
    """x_k = F_k x_{k-1} + w, z_k = H_k x_k + v at N samples, for B independent systems.

    F, Q: (N, B, X, X), from the previous sample to each; H: (N, B, M, X); z: (N, B, M), NaN where
    nothing was measured; R: (N, B, M), variances.
    """

    F: Array
    Q: Array
    H: Array
    z: Array
    R: Array


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

    On the way forward, only the state before each lane of a chunk is kept; on the way back, each
    chunk is filtered again, its lanes side by side, which saves memory. Raises
    numpy.linalg.LinAlgError if a state has no uncertainty.
    """
    shape = system(slice(1)).F.shape
    *others, last = chunks(count, max(1, CHUNK // math.prod(shape) // LANE) * LANE)
    begin, lanes = Gaussians(np.zeros(shape[:-1]), np.zeros(shape)), []
    for rows in others:
        ends = _filter(system(rows), begin)[1].at(slice(LANE - 1, None, LANE))
        states = Gaussians(*map(np.concatenate, zip(begin, ends, strict=True)))
        lanes.append((rows, states.at(slice(-1))))
        begin = states.at(slice(-1, None))
    after: Later | None = None
    for rows, before in [(last, begin), *reversed(lanes)]:
        part = system(rows)
        prior, states = _smooth(part, before, after)
        after = part.F[0].copy(), prior.at(0).copy(), states.at(0).copy()
        yield Smoothed(rows, states, _innovations(part, prior))


def _smooth(
    part: LinearSystem, before: Gaussians, after: Later | None
) -> tuple[Gaussians, Gaussians]:
    """Return the states before the measurements of some samples, and given all measurements."""
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

    before: (K, B, X), those before each of K lanes of N / K samples.
    """
    lanes, systems = before.mean.shape[:2]
    count = len(system.z) // lanes

    def beside(values: Array) -> Array:  # (N, B, ...) as (N / K, K B, ...)
        split = values.reshape(lanes, count, *values.shape[1:]).swapaxes(0, 1)
        return split.reshape(count, -1, *values.shape[2:])

    def in_turn(values: Array) -> Array:
        split = values.reshape(count, lanes, systems, *values.shape[2:]).swapaxes(0, 1)
        return split.reshape(-1, *split.shape[2:])

    x, P = (values.reshape(-1, *values.shape[2:]) for values in before)
    states = _filter_each(LinearSystem(*map(beside, vars(system).values())), x, P)
    prior, posterior = (Gaussians(*map(in_turn, state)) for state in states)
    return prior, posterior


def _filter_each(system: LinearSystem, x: Array, P: Array) -> tuple[Gaussians, Gaussians]:
    """Return the states before and after each measurement from those before the first, x and P."""
    seen = np.isfinite(system.z)
    H, z = np.where(seen[..., None], system.H, 0.0), np.where(seen, system.z, 0.0)
    R = system.R[..., None] * np.eye(z.shape[-1])
    eye = np.eye(system.F.shape[-1])
    prior, posterior = (
        Gaussians(np.empty(system.F.shape[:-1]), np.empty(system.F.shape)) for _ in range(2)
    )
    for k, F in enumerate(system.F):
        # prediction: x = F x, P = F P Fᵀ + Q
        x, P = np.matvec(F, x), F @ P @ F.mT + system.Q[k]
        prior.mean[k], prior.covariance[k] = x, P
        # correction: K = P Hᵀ (H P Hᵀ + R)⁻¹, x += K (z - H x), P = (I - K H) P (I - K H)ᵀ + K R Kᵀ
        seen_by = H[k] @ P
        K = np.linalg.solve(seen_by @ H[k].mT + R[k], seen_by).mT
        x = x + np.matvec(K, z[k] - np.matvec(H[k], x))
        left = eye - K @ H[k]
        P = left @ P @ left.mT + K @ R[k] @ K.mT
        posterior.mean[k], posterior.covariance[k] = x, P
    return prior, posterior


def _innovations(system: LinearSystem, prior: Gaussians) -> Array:
    """Return (z - H x⁻) / sqrt diag(H P⁻ Hᵀ + R), NaN where nothing was measured."""
    variance = np.sum((system.H @ prior.covariance) * system.H, axis=-1) + system.R
    return (system.z - np.matvec(system.H, prior.mean)) / np.sqrt(variance)


@dataclass(frozen=True)
class InnovationTest:
    """Tests of normalised innovations: variance one, and whiteness.

    variance: (M,), mean squares; variance_limits: (M, 2), their 95 % interval; portmanteau: (M,),
    Ljung-Box statistic; portmanteau_limit: its 95 % point; consistent, white: (M,), whether the
    variance and the whiteness pass; colour: (M,), how many times larger the variance of a mean of
    successive innovations is than that of white ones, 1 + 2 Σ ρ over LAGS lags: at least 1, and 1
    for those that pass as white.
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

    The mean square is compared with χ². The autocorrelations ρ over LAGS lags, within segments, are
    compared with those of white noise by the test of Ljung and Box.
    """
    count = np.isfinite(innovations).sum(axis=0)
    # one channel after the other, for the memory of long recordings
    variance = np.array([np.nanmean(channel**2) for channel in innovations.T])
    covariance = np.array([_autocovariance(channel, segment) for channel in innovations.T])
    correlation = covariance / variance[:, None]  # (M, LAGS)
    # Q = n (n + 2) Σ ρ² / (n - lag)
    lags = np.arange(1, LAGS + 1)
    portmanteau = count * (count + 2) * (correlation**2 / (count[:, None] - lags)).sum(axis=1)
    limit = float(_chi2(0.95, LAGS))
    white = portmanteau <= limit
    colour = np.where(white, 1, np.maximum(1 + 2 * correlation.sum(axis=1), 1))
    limits = _chi2(np.array([0.025, 0.975]), count[:, None]) / count[:, None]
    consistent = (limits[:, 0] <= variance) & (variance <= limits[:, 1])
    return InnovationTest(variance, limits, portmanteau, limit, consistent, white, colour)


def _autocovariance(innovation: Array, segment: Labels) -> list[float]:
    """Return the mean products over 1 to LAGS lags, within segments, of one channel (N,)."""
    means = []
    for lag in range(1, LAGS + 1):
        within = segment[lag:] == segment[:-lag]
        means.append(float(np.nanmean((innovation[lag:] * innovation[:-lag])[within])))
    return means


def _chi2(share: Array | float, freedom: Labels | int) -> Array:
    """Return quantiles of χ² with some degrees of freedom."""
    return np.asarray(2 * gammaincinv(np.asarray(freedom) / 2, share))
