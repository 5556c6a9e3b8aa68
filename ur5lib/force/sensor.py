"""From a force sensor's readings to the wrench on the arm, and a check of its mounting."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ur5lib.errors import Remark
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.free_fit import (
    CONTACT_DEVIATIONS,
    REPEATABILITY,
    STRETCHES_PER_CANDIDATE,
    Fit,
    SensorReadings,
    agreement,
    candidates,
    covariance,
    free_samples,
    least_deviations,
    quiet_stretches,
    settle,
)
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import number
from ur5lib.records.sensor_offset import Offset
from ur5lib.timeseries.arrays import Array, Mask

MAX_OFFSET_SAMPLES = 20_000  # a fit uses at most this many
# An offset is doubtful if less than the first share of all samples agrees with it, if another has
# more than the second share of its samples, or if fewer samples than the third number are free.
MIN_AGREEING_SHARE = 0.5
MAX_RIVAL_SHARE = 0.5
MIN_FREE_SAMPLES = 100
# If gravity's unit vector in sensor axes varies less, weight and bias are inseparable.
MIN_DIRECTION_STD = 0.2
# Correlation of sensor and estimate along an axis: 0.55 to 1 on six recordings, three of them real,
# and of opposite sign if the sensor is turned.
OPPOSITE_CORRELATION = -0.5
MIN_AXIS_RMS = 1.0  # N; an axis with less is not judged
# An axis with less of the squared force is not judged: its estimate is mostly cross-talk.
MIN_AXIS_POWER_SHARE = 0.05
NEGATIVE_MASS_TOLERANCE = 0.01  # kg


@dataclass(frozen=True, kw_only=True)
class SensorOffset(Offset):
    """The part of a sensor's reading that is no contact: bias and weight of its tool; free: which
    samples (N,) are contact-free and were used.
    """

    free: Mask

    def center(self) -> Array:
        """Return the tool's centre of mass, (3,) [m], in the sensor's frame."""
        return self.moment_arm / self.mass

    def reading(self, pull: Array) -> Array:
        """Return the reading without contact (N, 6); pull: (N, 3) [m/s²], as in `fit_offset`."""
        force = np.nan_to_num(self.mass) * pull
        moment = np.cross(np.nan_to_num(self.moment_arm), pull)
        return np.concatenate([force, moment], axis=1) + self.bias


def measured_columns(reading: Array) -> slice:
    """Return the columns of a reading (N, 6) that were measured: all, or the forces if all moments
    are NaN.
    """
    return slice(3 if np.isnan(reading[:, 3:]).all() else 6)


def fit_offset(reading: Array, pull: Array, period: float) -> SensorOffset:
    """Fit bias, mass and centre of mass of the tool to the contact-free samples.

    f = m p + b_f, n = m c × p + b_n. reading: (N, 6) [N, Nm], sensor frame, NaN rows allowed, and
    moments that are NaN throughout; pull: p (N, 3) [m/s²], R_6ᵀ g, or R_6ᵀ (g - a) where the tool's
    inertia counts; period: [s].
    One fit starts from least absolute deviations, which are robust if contacts fill less than half
    of the time; another from the offset on which most samples agree, which may be less than half,
    as forces vary in contact. In both, samples beyond 4 standard deviations, and those near them,
    are excluded until nothing changes. The fit with which more samples agree is returned. Long
    records are thinned.
    """
    # the record, thinned; the weight counts only if the arm turns
    reading = reading[:, measured_columns(reading)]
    repeats = REPEATABILITY[: reading.shape[1]]
    stride = max(1, -(-len(reading) // MAX_OFFSET_SAMPLES))
    measured = finite_rows(reading)
    weighed = _arm_turns(pull[measured])
    terms = _terms(pull[::stride], weighed, reading.shape[1])
    record = SensorReadings(reading[::stride], terms, measured[::stride], stride * period)
    # candidates from quiet stretches
    middle, means, noise = quiet_stretches(reading, period, repeats)
    together = STRETCHES_PER_CANDIDATE if weighed else 1
    offsets = candidates(_terms(pull[middle], weighed, reading.shape[1]), means, repeats, together)
    tolerance = CONTACT_DEVIATIONS * np.maximum(noise, repeats)
    # both fits, and the one with which more samples agree
    fits = [
        settle(record, record.measured, least_deviations(record)),
        *_settled_agreement(record, offsets, tolerance),
    ]
    agree = record.agreement(np.array([parameters for parameters, _, _ in fits]), tolerance)
    parameters, is_free, noise = fits[agree.sum(axis=1).argmax()]
    tolerance = np.maximum(tolerance, CONTACT_DEVIATIONS * noise)
    # samples that agree with the fit; the largest share of others that agree with one candidate
    agree = record.agreement(np.concatenate([parameters[None], offsets]), tolerance)
    rival = (agree & ~agree[0]).mean(axis=1).max()
    offset = _offset(record, parameters, is_free, float(agree[0].mean()), float(rival))
    if stride > 1:  # free samples of the whole record
        untouched = offset.reading(pull)[:, : reading.shape[1]]
        free_of_all = free_samples(reading - untouched, noise, measured, period)
        offset = replace(offset, free=free_of_all)
    return offset


def offset_doubt(offset: SensorOffset, repeats: float = 1.0) -> Remark | None:
    """Return why the bias is doubtful, since a push may be a part of it; None if most samples agree
    with it.

    repeats: samples per reading of the sensor, above 1 for a slow one.
    """
    agreeing = offset.agreeing
    rival = offset.rival
    free_readings = round(offset.free.sum() / repeats)
    if rival > MAX_RIVAL_SHARE * agreeing:
        text = f"{agreeing:.0%} of the samples have one bias, {rival:.0%} another"
        return Remark(CauseCode.TWO_BIASES, text)
    if agreeing < MIN_AGREEING_SHARE:
        agree = f"only {agreeing:.0%} of the samples agree on one bias"
        return Remark(CauseCode.DISPUTED_BIAS, f"{agree}, the others count as contact")
    if free_readings < MIN_FREE_SAMPLES:
        few = f"only {free_readings} samples are without contact"
        return Remark(CauseCode.FEW_FREE_SAMPLES, f"{few}, too few for a reliable bias")
    return None


def _settled_agreement(record: SensorReadings, offsets: Array, tolerance: Array) -> Iterator[Fit]:
    """Yield the fit that starts from the samples that agree with the best of some candidates;
    offsets: (K, 10), none without any.
    """
    if len(offsets):
        best = record.agreement(offsets, tolerance).sum(axis=1).argmax()
        is_free = agreement(offsets[[best]], record.terms, record.reading, tolerance)[0]
        if is_free.any():
            yield settle(record, is_free, np.ones(len(is_free)))


def _arm_turns(pull: Array) -> bool:
    """Return whether the arm turns enough to separate weight from bias."""
    if not len(pull):
        return False
    down = pull / np.linalg.norm(pull, axis=1, keepdims=True)
    return bool(np.std(down, axis=0).max() > MIN_DIRECTION_STD)


def _terms(pull: Array, weighed: bool, components: int) -> Array:
    """Return the regressor (N, components, 10) of mass, mass times arm (3), and bias (6).

    The first four columns are 0 if the weight is not separated from the bias.
    """
    terms = np.zeros((len(pull), 6, 10))
    terms[:, :, 4:] = np.eye(6)
    if weighed:  # f = m p, n = m c × p
        terms[:, :3, 0] = pull
        terms[:, 3:, 1:4] = np.cross(np.eye(3), pull[:, None]).mT
    return terms[:, :components]


def _offset(
    record: SensorReadings, parameters: Array, is_free: Mask, agreeing: float, rival: float
) -> SensorOffset:
    """Return fitted parameters (10,) with their standard errors as an offset; agreeing: share of
    samples that agree with it; rival: largest share of others that agree with another candidate.
    """
    terms = record.terms[is_free]
    residual = record.reading[is_free] - record.terms[is_free] @ parameters
    noise = residual.std(axis=0)
    deviation = np.sqrt(np.diag(covariance(terms, residual, noise)).clip(0))
    # NaN: moments that the sensor lacks, the weight if the arm does not turn
    observable = record.terms.any(axis=(0, 1))
    value, std = (np.where(observable, x, np.nan) for x in (parameters, deviation))
    return SensorOffset(
        bias=value[4:],
        bias_std=std[4:],
        mass=float(value[0]),
        mass_std=float(std[0]),
        moment_arm=value[1:4],
        moment_arm_std=std[1:4],
        noise=np.pad(noise, (0, 6 - len(noise)), constant_values=np.nan),
        agreeing=agreeing,
        rival=rival,
        free=is_free,
    )


def wrench_of_environment(reading: Array, rotation: Array) -> Array:
    """Return the wrench of the environment on the arm, base axes, at the sensor's origin.

    reading: (N, 6) [N, Nm], sensor frame, without its offset; rotation: (N, 3, 3), R_6. Returns
    (N, 6). The sensor reads the wrench on the arm: the tool's weight points downwards, and motors
    work against pushes. Equation 6.11 has a minus sign here, because the thesis's estimates are
    those of the arm acting on its environment.
    """
    halves = [rotation @ half[:, :, None] for half in (reading[:, :3], reading[:, 3:])]
    return np.concatenate(halves, axis=1)[..., 0]


def initial_bias(reading: Array, time: Array, window: float) -> Array:
    """Return the mean reading over the first `window` seconds, which must be free of contact.

    reading: (N, 6), sensor frame; time: (N,) [s]. Returns (6,) [N, Nm]: the sensor's bias and, at
    this orientation, the weight of its tool.
    """
    measured = finite_rows(reading[:, measured_columns(reading)])
    first = time[measured].min()
    return reading[measured & (time <= first + window)].mean(axis=0)


def move_to_frame_6(wrench: Array, rotation: Array, position: Array) -> Array:
    """Return the wrench at the origin of frame 6: n_6 = n + r x F.

    wrench: (N, 6) at the sensor's origin, base axes; rotation: (N, 3, 3), R_6;
    position: (3,) [m], the sensor's origin in frame 6 (Equation 6.10).
    """
    lever = rotation @ position
    force, moment = wrench[:, :3], wrench[:, 3:]
    return np.concatenate([force, moment + np.cross(lever, force)], axis=1)


def opposite_axes(sensor: Array, estimate: Array, rotation: Array) -> list[str]:
    """Return the axes of frame 6 along which sensor and estimate from currents are opposite.

    sensor, estimate: forces on the arm, (N, 3) [N], base axes; rotation: R_6, (N, 3, 3). Axes with
    almost no force are not judged.
    """
    finite = finite_rows(sensor) & finite_rows(estimate)
    if not finite.any():
        return []
    read, estimated = (
        np.einsum("nji,nj->ni", rotation[finite], force[finite]) for force in (sensor, estimate)
    )
    power, estimated_power = (read**2).mean(axis=0), (estimated**2).mean(axis=0)
    acts = (power > MIN_AXIS_RMS**2) & (power > MIN_AXIS_POWER_SHARE * power.sum())
    # correlation without subtracting the means
    opposite = (read * estimated).mean(axis=0) < OPPOSITE_CORRELATION * np.sqrt(
        power * estimated_power
    )
    return [axis for axis, wrong in zip("xyz", acts & opposite, strict=True) if wrong]


def mounting_doubt(offset: SensorOffset, opposite: list[str]) -> Remark | None:
    """Return why the sensor may be mounted upside down or have the opposite sign; None if nothing
    shows it.

    opposite: axes, as of `opposite_axes`.
    """
    reasons = []
    if opposite:
        along = f"the sensor's force along {', '.join(opposite)} of frame 6"
        reasons.append(f"{along} is opposite to that from the motors")
    if offset.mass < -max(NEGATIVE_MASS_TOLERANCE, 3 * offset.mass_std):
        mass, std = number(offset.mass, ".2g"), number(offset.mass_std, ".1g")
        reasons.append(f"the weight of the sensor's tool points upwards ({mass} ± {std} kg)")
    if not reasons:
        return None
    text = (
        f"{' and '.join(reasons)}: it may be mounted upside down or have the opposite sign; rotate "
        "its readings into the axes of frame 6"
    )
    return Remark(CauseCode.TURNED_SENSOR, text)
