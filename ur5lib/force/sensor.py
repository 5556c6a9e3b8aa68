"""From what a force sensor reads to the wrench on the arm."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import minimum_filter1d

from ur5lib.force.consensus import TOGETHER, agreement, candidates, drawn, quiet_stretches
from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array, Mask

Fit = tuple[Array, Mask, Array]  # parameters (10,), free samples (N,), their noise (6,)

ROUNDS = 20  # of fitting and leaving contacts out; they settle in fewer
OUTSIDE = 4.0  # standard deviations of the free reading: beyond, something touches
REPEATS = np.array([0.1] * 3 + [0.01] * 3)  # N, Nm: no better than this, after a push
CLEAR = 0.25  # s, that a free sample is away from any contact
MOST, JUDGED = 20_000, 2_000  # samples that a fit is made of, and by which offsets are compared
MAJORITY, RIVAL, FEWEST = 0.5, 0.5, 100  # of samples, of their share, samples: below, a doubt
TURNED = 0.2  # of the unit vector of gravity in the sensor's axes: below, weight is as good as bias


@dataclass(frozen=True)
class SensorOffset:
    """What the sensor reads without contact: its bias, and the weight of the tool beyond it.

    bias: (6,) [N, Nm]; mass [kg]; moment_arm: mass times centre of mass, (3,) [kg m], sensor
    frame; *_std: their standard errors, NaN mass and arm where the arm turned too little to tell
    weight from bias (the bias then holds both); noise: (6,), standard deviation of a free sample;
    free: (N,), the contact-free samples behind all that; agreeing: share of the samples that agree
    with it; rival: the largest share of the others that agree with one other offset.
    """

    bias: Array
    bias_std: Array
    mass: float
    mass_std: float
    moment_arm: Array
    moment_arm_std: Array
    noise: Array
    free: Mask
    agreeing: float
    rival: float

    def center(self) -> Array:
        """The tool's centre of mass, (3,) [m], in the sensor's frame."""
        return self.moment_arm / self.mass

    def reading(self, rotation: Array, gravity: Array) -> Array:
        """What the sensor reads without contact, (N, 6), at orientations R_6 (N, 3, 3).

        gravity: (3,) [m/s²], base frame.
        """
        weight = gravity @ rotation  # of each kilogram, sensor axes
        force = np.nan_to_num(self.mass) * weight
        moment = np.cross(np.nan_to_num(self.moment_arm), weight)
        return np.concatenate([force, moment], axis=1) + self.bias


def fit_offset(reading: Array, rotation: Array, period: float, gravity: Array) -> SensorOffset:
    """Bias, mass and centre of mass from the contact-free samples, which it finds.

    reading: (N, 6), sensor frame, NaN rows allowed; rotation: (N, 3, 3), R_6; period: [s];
    gravity: g (3,) [m/s²], base frame.
    f = R_6^T m g + b_f, n = c x R_6^T m g + b_n. Two fits are made. One starts from least
    deviations, which contacts do not move while they fill less than half of the time; one from
    the offset that most samples agree with, be they less than half, as forces vary in contact. In
    both, samples off by more than 4 standard deviations, and what is near them, are left out until
    nothing changes. The fit that more samples agree with counts. Long records are thinned out.
    """
    every = max(1, -(-len(reading) // MOST))
    measured = finite_rows(reading)
    weighed = _turns(rotation[measured], gravity)
    terms = _terms(rotation[::every], gravity, weighed)
    record = _Record(reading[::every], terms, measured[::every], every * period)
    middle, means, noise = quiet_stretches(reading, period, REPEATS)
    together = TOGETHER if weighed else 1
    tried = candidates(_terms(rotation[middle], gravity, weighed), means, REPEATS, together)
    tolerance = OUTSIDE * np.maximum(noise, REPEATS)
    fits = [
        _settle(record, record.measured, _least_deviations(record)),
        *_settled_agreement(record, tried, tolerance),
    ]
    parameters, free, noise = _most_agreed(record, fits, tolerance)
    tolerance = np.maximum(tolerance, OUTSIDE * noise)
    offset = _offset(record, parameters, free) | _shares(record, parameters, tried, tolerance)
    if every > 1:
        left = reading - SensorOffset(**offset, free=free).reading(rotation, gravity)
        free = _free(left, noise, measured, period)
    return SensorOffset(**offset, free=free)


def offset_doubt(offset: SensorOffset) -> str | None:
    """Why what was taken for bias may be a push; None where most of the record agrees with it."""
    agreeing, rival, free = offset.agreeing, offset.rival, int(offset.free.sum())
    if rival > RIVAL * agreeing:
        found = f"{agreeing:.0%} of its samples agree on one bias, {rival:.0%} on another"
    elif agreeing < MAJORITY:
        found = f"only {agreeing:.0%} of its samples agree on one bias, the others count as contact"
    elif free < FEWEST:
        found = f"its bias is from {free} samples, the only ones away from any contact"
    else:
        return None
    return (
        f"{found}: a steady push may have been taken for bias; "
        "record some seconds in which nothing touches the tool"
    )


@dataclass(frozen=True)
class _Record:
    """Readings (N, 6), their terms (N, 6, 10), which of them are whole (N,), their period [s]."""

    reading: Array
    terms: Array
    measured: Mask
    period: float

    def agreement(self, parameters: Array, tolerance: Array) -> Mask:
        """Which of J samples, drawn once, agree with each of the offsets (K, 10): (K, J)."""
        rows = drawn(np.flatnonzero(self.measured), JUDGED)
        return agreement(parameters, self.terms[rows], self.reading[rows], tolerance)


def _settled_agreement(record: _Record, tried: Array, tolerance: Array) -> Iterator[Fit]:
    """The fit that settles from the samples that agree with the best of the candidates (K, 10)."""
    if len(tried):
        best = record.agreement(tried, tolerance).sum(axis=1).argmax()
        free = agreement(tried[[best]], record.terms, record.reading, tolerance)[0]
        if free.any():
            yield _settle(record, free, np.ones(len(free)))


def _most_agreed(record: _Record, fits: list[Fit], tolerance: Array) -> Fit:
    """The fit that most samples agree with."""
    agree = record.agreement(np.array([parameters for parameters, _, _ in fits]), tolerance)
    return fits[agree.sum(axis=1).argmax()]


def _shares(record: _Record, parameters: Array, tried: Array, tolerance: Array) -> dict[str, float]:
    """The share of samples that agree with parameters (10,), and the largest share of the others
    that agree with one of the candidates (K, 10).
    """
    agree = record.agreement(np.concatenate([parameters[None], tried]), tolerance)
    others = agree & ~agree[0]
    return {"agreeing": float(agree[0].mean()), "rival": float(others.mean(axis=1).max())}


def _settle(record: _Record, free: Mask, weight: Array) -> Fit:
    """From samples free of contact, weighted, to a fit that leaves out all others and no more.

    Returns the parameters (10,), the free samples (N,), and their noise (6,), not below REPEATS.
    """
    for _ in range(ROUNDS):
        parameters, left = _fit(record, free, weight)
        noise = np.maximum(1.4826 * np.median(np.abs(left[free]), axis=0), REPEATS)
        quiet = _free(left, noise, record.measured, record.period)
        if (quiet == free).all() or not quiet.any():
            break
        free, weight = quiet, np.ones(len(quiet))
    return parameters, free, noise


def _free(left: Array, noise: Array, measured: Mask, period: float) -> Mask:
    """Samples (N,) within 4 standard deviations and away from any that is not."""
    inside = (np.abs(left) <= OUTSIDE * noise).all(axis=1) | ~measured
    reach = 2 * round(CLEAR / period) + 1
    return minimum_filter1d(inside, reach, mode="constant", cval=1) & measured


def _turns(rotation: Array, gravity: Array) -> bool:
    """Whether the arm turns enough for weight to be told from bias."""
    down = gravity / np.linalg.norm(gravity) @ rotation
    return bool(len(down)) and bool(np.std(down, axis=0).max() > TURNED)


def _terms(rotation: Array, gravity: Array, weighed: bool) -> Array:
    """Of mass, mass times arm (3), and bias (6), in the reading: (N, 6, 10).

    The first four are 0 where the weight is not told from bias.
    """
    terms = np.zeros((len(rotation), 6, 10))
    terms[:, :, 4:] = np.eye(6)
    if weighed:
        terms[:, :, :4] = _weight_terms(rotation, gravity)
    return terms


def _weight_terms(rotation: Array, gravity: Array) -> Array:
    """Of mass and mass times arm in the reading: (N, 6, 4)."""
    weight = gravity @ rotation  # R_6^T g, of each kilogram
    terms = np.zeros((len(rotation), 6, 4))
    terms[:, :3, 0] = weight
    terms[:, 3:, 1:] = np.cross(np.eye(3), weight[:, None]).mT
    return terms


def _least_deviations(record: _Record) -> Array:
    """Weights (N,) by which least squares leave least absolute deviations (Schlossmacher 1973).

    Contacts then do not move the fit, as long as they fill less than half of the time.
    """
    weight = np.ones(len(record.reading))
    for _ in range(ROUNDS):
        _, left = _fit(record, record.measured, weight)
        weight = 1 / np.sqrt(np.maximum(np.linalg.norm(left / REPEATS, axis=1), 1.0))
    return weight


def _fit(record: _Record, free: Mask, weight: Array) -> tuple[Array, Array]:
    """Weighted least squares over the free samples, forces and moments each by their own scale.

    Returns the parameters (10,) and what they leave of every reading (N, 6).
    """
    scale = weight[free, None] / REPEATS
    rows = (record.terms[free] * scale[..., None]).reshape(-1, 10)
    values = (record.reading[free] * scale).ravel()
    parameters = np.linalg.pinv(rows.T @ rows, hermitian=True) @ (rows.T @ values)
    return parameters, record.reading - record.terms @ parameters


def _offset(record: _Record, parameters: Array, free: Mask) -> dict[str, Any]:
    """What parameters (10,), fitted to the free samples, mean, with their standard errors."""
    terms, left = record.terms[free], record.reading[free] - record.terms[free] @ parameters
    noise = left.std(axis=0)
    deviation = np.sqrt(np.diag(_covariance(terms, left, noise)))
    weighed = record.terms[:, :, :4].any()
    weight, weight_std = (np.where(weighed, x[:4], np.nan) for x in (parameters, deviation))
    return {
        "bias": parameters[4:],
        "bias_std": deviation[4:],
        "mass": float(weight[0]),
        "mass_std": float(weight_std[0]),
        "moment_arm": weight[1:],
        "moment_arm_std": weight_std[1:],
        "noise": noise,
    }


def _covariance(terms: Array, left: Array, noise: Array) -> Array:
    """Of the parameters (10, 10), as far as errors of neighbouring samples are independent."""
    scale = np.maximum(noise, 1e-12)
    whitened = (terms / scale[:, None]).reshape(-1, 10)
    follows = (left[1:] * left[:-1]).mean() / (left**2).mean() if len(left) > 1 else 0.0
    inflated = (1 + follows) / max(1 - follows, 1e-9)
    return np.linalg.pinv(whitened.T @ whitened) * inflated


def wrench_of_environment(reading: Array, rotation: Array) -> Array:
    """Wrench of the environment on the arm, base axes, at the sensor's origin.

    reading: (N, 6) [N, Nm], sensor frame, without its offset; rotation: (N, 3, 3), R_6. Returns
    (N, 6). The sensor reads what acts on the arm: the tool's weight downwards, and pushes with the
    opposite sign of the motor torque they call for. Equation 6.11 has a minus here, as the
    thesis's estimates are of the arm acting on its environment.
    """
    halves = [rotation @ half[:, :, None] for half in (reading[:, :3], reading[:, 3:])]
    return np.concatenate(halves, axis=1)[..., 0]


def bias(reading: Array, time: Array, window: float) -> Array:
    """Mean reading over the first `window` seconds, which must be free of contact.

    reading: (N, 6), sensor frame; time: (N,) [s]. Returns (6,) [N, Nm]: the sensor's own bias
    and the weight of what is mounted on it, as far as the orientation stays the same.
    """
    measured = finite_rows(reading)
    first = time[measured].min()
    return reading[measured & (time <= first + window)].mean(axis=0)


def move_to_frame_6(wrench: Array, rotation: Array, position: Array) -> Array:
    """The same wrench at the origin of frame 6: n_6 = n + r x F.

    wrench: (N, 6) at the sensor's origin, base axes; rotation: (N, 3, 3), R_6;
    position: (3,) [m], the sensor's origin in frame 6 (Equation 6.10).
    """
    lever = rotation @ position
    force, moment = wrench[:, :3], wrench[:, 3:]
    return np.concatenate([force, moment + np.cross(lever, force)], axis=1)
