"""Regression of a force sensor's readings in the samples without contact, which it finds.

The model is reading (N, 6) = terms (N, 6, P) times parameters (P,), plus noise, except in contact;
of a sensor without moments, each 6 below is a 3.
Candidates for the parameters come from consensus (RANSAC, Fischler and Bolles 1981): each is fitted
to a few short quiet stretches, because a tool in a hand moves more than one that nothing touches.
So the samples in contact may be the majority.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d

from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import STD_PER_MAD

QUIET_STRETCH_DURATION = 0.1  # s
CANDIDATE_COUNT = 600
STRETCHES_PER_CANDIDATE = 3  # a candidate is fitted to this many where one is not enough
SINGULAR_VALUE_CUTOFF = 1e-3  # poorly determined combinations of parameters stay small
MAX_FIT_ROUNDS = 20  # fits alternate with exclusion of contacts; fewer rounds suffice
CONTACT_DEVIATIONS = 4.0  # standard deviations of a free reading: beyond, a sample is in contact
REPEATABILITY = np.array([0.1] * 3 + [0.01] * 3)  # N, Nm; a push changes a reading by this
FREE_CLEARANCE = 0.25  # s; a free sample is this far from any contact
COMPARED_SAMPLES = 2_000  # parameters are compared on this many samples


def agreement(parameters: Array, terms: Array, reading: Array, tolerance: Array) -> Mask:
    """Return which samples (K, N) agree with each of K candidates within the tolerance.

    parameters: (K, P); terms: (N, 6, P); reading: (N, 6); tolerance: (6,) in the reading's units.
    """
    agrees: Mask = np.ones((len(parameters), len(reading)), bool)
    for component, limit in enumerate(tolerance):
        error = parameters @ terms[:, component].T
        error -= reading[:, component]
        agrees &= np.abs(error) <= limit
    return agrees


def random_subset(values: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Return at most `count` of the indices, drawn at random from a fixed seed.

    A regular choice could coincide with a period of the signal.
    """
    if len(values) <= count:
        return values
    return np.random.default_rng(0).choice(values, count, replace=False)


def quiet_stretches(
    reading: Array, period: float, scale: Array
) -> tuple[NDArray[np.intp], Array, Array]:
    """Return the quieter half of a record's short parts, each QUIET_STRETCH_DURATION long: their
    middle rows (S,), their means (S, 6), and the median of their standard deviations (6,).

    reading: (N, 6), NaN rows allowed; period: [s]; scale: (6,), units in which components are
    compared.
    """
    length = max(2, round(QUIET_STRETCH_DURATION / period))
    count = len(reading) // length
    parts = reading[: count * length].reshape(count, length, reading.shape[1])
    std = parts.std(axis=1)
    unrest = np.square(std / scale).mean(axis=1)
    # the quieter half, rounded up, of the stretches without NaN
    finite = np.flatnonzero(np.isfinite(unrest))
    order = np.argsort(unrest[finite], kind="stable")
    quiet = finite[order[: -(-len(finite) // 2)]]
    noise = np.median(std[quiet], axis=0) if len(quiet) else np.zeros(reading.shape[1])
    return quiet * length + length // 2, parts[quiet].mean(axis=1), noise


def candidates(terms: Array, reading: Array, scale: Array, together: int) -> Array:
    """Return candidates (K, P) for the parameters, each fitted to a few of the quiet parts.

    terms: (S, 6, P); reading: (S, 6); scale: (6,); together: number of parts per candidate. They
    are drawn from a fixed seed.
    """
    stretches = np.arange(len(terms))
    if not len(terms):
        return np.zeros((0, terms.shape[2]))
    if together == 1:
        drawn_stretches = random_subset(stretches, CANDIDATE_COUNT)[:, None]
    else:
        drawn_stretches = np.random.default_rng(0).choice(stretches, (CANDIDATE_COUNT, together))
    rows = (terms[drawn_stretches] / scale[:, None]).reshape(
        len(drawn_stretches), -1, terms.shape[2]
    )
    values = (reading[drawn_stretches] / scale).reshape(len(drawn_stretches), -1, 1)
    return (np.linalg.pinv(rows, rcond=SINGULAR_VALUE_CUTOFF) @ values)[..., 0]


Fit = tuple[Array, Mask, Array]  # parameters (P,), free samples (N,), their noise (6,)


@dataclass(frozen=True)
class SensorReadings:
    """A sensor's readings and the terms of their regression.

    reading: (N, 6) [N, Nm]; terms: (N, 6, P); measured: which samples are complete (N,); period:
    [s]; prior_precision: inverse variances (P,) of a prior about zero, 0 for none.
    """

    reading: Array
    terms: Array
    measured: Mask
    period: float
    prior_precision: Array | float = 0.0

    @property
    def repeats(self) -> Array:
        """Return REPEATABILITY of the components that the sensor has."""
        return REPEATABILITY[: self.reading.shape[1]]

    def agreement(self, parameters: Array, tolerance: Array) -> Mask:
        """Return which of J samples agree with each of K parameters (P,), as (K, J); the samples
        are the same in each call.
        """
        rows = random_subset(np.flatnonzero(self.measured), COMPARED_SAMPLES)
        return agreement(parameters, self.terms[rows], self.reading[rows], tolerance)


def settle(record: SensorReadings, is_free: Mask, weight: Array) -> Fit:
    """Return a fit to the contact-free samples: parameters (P,), these samples (N,), and their
    noise (6,), at least REPEATABILITY.

    Fit and selection of contact-free samples alternate until the selection stays the same. is_free,
    weight: (N,) to start from.
    """
    for _ in range(MAX_FIT_ROUNDS):
        parameters, residual = fit(record, is_free, weight)
        noise = np.maximum(
            STD_PER_MAD * np.median(np.abs(residual[is_free]), axis=0), record.repeats
        )
        quiet = free_samples(residual, noise, record.measured, record.period)
        if (quiet == is_free).all() or not quiet.any():
            break
        is_free, weight = quiet, np.ones(len(quiet))
    return parameters, is_free, noise


def free_samples(residual: Array, noise: Array, measured: Mask, period: float) -> Mask:
    """Return which samples (N,) are contact-free: within CONTACT_DEVIATIONS of the noise, and
    FREE_CLEARANCE [s] away from any that are not.
    """
    inside = (np.abs(residual) <= CONTACT_DEVIATIONS * noise).all(axis=1) | ~measured
    reach = 2 * round(FREE_CLEARANCE / period) + 1
    return minimum_filter1d(inside, reach, mode="constant", cval=1) & measured


def least_deviations(record: SensorReadings) -> Array:
    """Return weights (N,) with which least squares minimise absolute deviations (Schlossmacher
    1973).

    The fit is robust to contacts that fill less than half of the time.
    """
    weight = np.ones(len(record.reading))
    for _ in range(MAX_FIT_ROUNDS):
        _, residual = fit(record, record.measured, weight)
        # w = 1 / √|r|, so that Σ w² r² = Σ |r|
        weight = 1 / np.sqrt(np.maximum(np.linalg.norm(residual / record.repeats, axis=1), 1.0))
    return weight


def fit(record: SensorReadings, is_free: Mask, weight: Array) -> tuple[Array, Array]:
    """Return parameters (P,) fitted to the contact-free samples by weighted least squares, and the
    residuals of all readings (N, 6).

    Forces and moments count in units of REPEATABILITY.
    """
    scale = weight[is_free, None] / record.repeats
    scaled = record.terms[is_free] * scale[..., None]
    rows = scaled.reshape(-1, scaled.shape[2])
    values = (record.reading[is_free] * scale).ravel()
    # (Xᵀ W X + Λ) θ = Xᵀ W y
    normal = rows.T @ rows + record.prior_precision * np.eye(rows.shape[1])
    parameters = np.linalg.pinv(normal, hermitian=True) @ (rows.T @ values)
    return parameters, record.reading - record.terms @ parameters


def covariance(terms: Array, residual: Array, noise: Array) -> Array:
    """Return the covariance (P, P) of the parameters: (Xᵀ X)⁻¹ (1 + ρ) / (1 - ρ).

    ρ is the correlation of neighbouring residuals, taken as a first-order autoregression.
    """
    scale = np.maximum(noise, 1e-12)
    whitened = (terms / scale[:, None]).reshape(-1, terms.shape[2])
    correlation = 0.0
    if len(residual) > 1:
        correlation = (residual[1:] * residual[:-1]).mean() / (residual**2).mean()
    inflated = (1 + correlation) / max(1 - correlation, 1e-9)
    return np.asarray(np.linalg.pinv(whitened.T @ whitened) * inflated, np.float64)
