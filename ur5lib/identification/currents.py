"""The map from motion and rigid-body torque to motor current: k i + b = τ + τ_friction.

The regression target is the current, because it is noisy: i = (τ + τ_friction - b) / k is linear
in 1/k, b/k and the friction coefficients over k, which are fitted to samples in motion. At rest,
friction can be any torque up to breakaway: a fitted share of the friction before the stop remains.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.special import chdtrc, stdtrit

from ur5lib.errors import Remark, remark
from ur5lib.identification.estimation import (
    Estimate,
    beside_fuller,
    estimate_together,
    of_prior,
    physical,
)
from ur5lib.identification.population import Typical
from ur5lib.identification.prior import JointPrior, Prior
from ur5lib.identification.regression import DRAWS, half_width, spread
from ur5lib.identification.samples import (
    FEW,
    Record,
    Samples,
    Smooth,
    apart_from,
    design,
    joint_samples,
    record_days,
    record_paths,
    smoothed_moving,
)
from ur5lib.identification.selection import (
    FEWEST,
    HELD,
    choose_reversal,
    choose_terms,
    held_current,
    left_out_residuals,
)
from ur5lib.robots.friction import BASE, CONSIDERED, FAMILY, KARNOPP, PRESLIDING, Term
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.metrics import NORMAL95

UNDETERMINED = 0.5  # prior share above which the data do not determine a parameter
CONFLICT = 3.0  # prior standard deviations
UNUSUAL = 1e-3  # chance below which a joint is unlike others
RAREST = 1e-6  # chance below which a normal distribution says nothing
FRICTION = ("coulomb", "viscous")  # that is compared with other arms
VAGUE = 1e3  # relative error that lets a value count for nothing
# A torque constant contradicts the known one beyond both. In right recordings of two arms, it is
# up to 5.6 standard deviations off, with ratios of 0.68 to 1.29: wrists lose that in their gears.
DEVIATIONS, RATIO = 5.0, 1.75
# Standard deviation of a joint's friction from day to day, relative, where recordings of one day do
# not show it. On seven dates of a UR10e, it is 0.06 on the most different date and 0.035 on all.
BETWEEN_DAYS = 0.07
FOLDS = 10  # of cross-fitting, at most
LEAST_FRICTION = 0.1  # Nm
NONE = np.empty(0), np.empty(0, np.int64)  # residuals of no recording, and their labels


@dataclass(frozen=True)
class Usual:
    """Usual root mean square error of a recording that was left out, in units of Coulomb friction,
    and the number of recordings that it counts as.
    """

    error: float
    recordings: float


# Of most likelihood by the joints of four arms: from 0.08 (UR10e) to 0.6 (UR3) in motion.
MOVING, RESTING = Usual(0.13, 1.3), Usual(0.37, 4.0)


@dataclass(frozen=True)
class JointFit:
    """One joint's map from motion to current.

    presliding: [rad], over which friction reverses, or KARNOPP; reversal_errors: [A],
    cross-validated, with each distance of PRESLIDING and with Karnopp's friction, empty with one
    path; held: [A], friction at rest beyond that in motion, may be negative; band_moving,
    band_rest: half of the 95 % band [A] around the low-passed current of a recording that was left
    out; remarks: doubts about the fit; doubt: (P, P), covariance of the coefficients where no
    motion that was left out shows their errors;
    contradicted: torque constant [Nm/A] that the currents alone would give, None unless it
    contradicts the known one, which the fit then keeps.
    """

    terms: tuple[Term, ...]
    estimate: Estimate
    presliding: float
    reversal_errors: tuple[float, ...]
    held: float
    band_moving: float
    band_rest: float
    remarks: tuple[Remark, ...]
    doubt: Array | None = None
    contradicted: float | None = None

    def names(self) -> list[str]:
        """Return the parameters' names."""
        return ["torque_constant", "offset", *(n for term in self.terms for n in term.names())]


@dataclass(frozen=True)
class CurrentFit:
    """The maps of the joints; units: number of paths, or of stretches if paths are few; days: of
    the recordings, without a fit 0.
    """

    joints: tuple[JointFit, ...]
    units: int
    days: int = 0


@dataclass(frozen=True)
class Parameter:
    """One fitted value in SI units; joint 1 to 6; interval: 95 %.

    prior_share, arm_share, day_share, run_share: of what is known of it, see `shares_of_knowledge`.
    """

    joint: int
    name: str
    value: float
    std_error: float
    interval: tuple[float, float]
    prior_share: float
    arm_share: float
    day_share: float
    run_share: float
    determined: bool


def fit_currents(
    records: Sequence[Record],
    smooth: Smooth,
    prior: Prior,
    family: Sequence[Term] = FAMILY,
    seed: int = 0,
) -> CurrentFit:
    """Fit all joints to contact-free recordings; select friction terms by cross-validation.

    smooth: a zero-phase low-pass at, for example, 2 Hz: above, the measured current is noise.
    A joint whose current does not follow its torque keeps the known torque constant.
    """
    fit = _fit_with(records, smooth, prior, family, seed)
    lost = np.flatnonzero(too_large(fit, prior)).tolist()
    if not lost:
        return fit
    alone, known = torque_constants(fit), 1 / prior.inverse_constant.mean
    fit = _fit_with(records, smooth, replace(prior, pinned=tuple(lost)), family, seed)
    joints = list(fit.joints)
    for joint in lost:
        found = {"alone": float(alone[joint]), "known": float(known[joint])}
        remarks = *joints[joint].remarks, remark("current against constant", **found)
        joints[joint] = replace(joints[joint], contradicted=found["alone"], remarks=remarks)
    return replace(fit, joints=tuple(joints))


def expected_fit(prior: Prior, seed: int = 0) -> CurrentFit:
    """Return what a prior with a population expects of each joint, without any recording."""
    terms = [BASE] * len(prior.torque_max)
    whole = prior.over(terms)
    covariance = np.asarray(np.linalg.inv(whole.precision), dtype=np.float64)
    drawn = np.random.default_rng(seed).multivariate_normal(whole.mean, covariance, DRAWS)
    size = len(whole.mean) // len(terms)
    parts = [slice(start, start + size) for start in range(0, len(whole.mean), size)]
    joints = (_expected_joint(whole.mean[p], covariance[p, p], drawn[:, p]) for p in parts)
    return CurrentFit(tuple(joints), 0)


def _expected_joint(mean: Array, covariance: Array, drawn: Array) -> JointFit:
    """Return a joint with BASE from its coefficients' mean (P,), covariance, and draws (B, P)."""
    return JointFit(
        terms=BASE,
        estimate=Estimate(mean, of_prior(len(mean)), drawn, spread(physical(drawn))),
        presliding=PRESLIDING[0],
        reversal_errors=(),
        held=HELD * float(mean[2]),
        band_moving=band_of_recordings(*NONE, MOVING, float(mean[2])),
        band_rest=band_of_recordings(*NONE, RESTING, float(mean[2])),
        remarks=(),
        doubt=covariance,
    )


def too_large(fit: CurrentFit, prior: Prior) -> Mask:
    """Return which torque constants (6,) are far larger than known, or negative.

    The current then hardly follows the joint's torque. The deviation is that of k, since 1/k
    cannot be far below its known value; one that is less certain than the known k counts as far.
    """
    inverse, known, std = _beside_known(fit, prior)
    far = 1 / inverse - 1 / known > DEVIATIONS * std / known**2
    vague = constants_doubt(fit) / np.abs(inverse) > std / known**2
    return (inverse <= 0) | ((far | vague) & (inverse < known / RATIO))


def too_small(fit: CurrentFit, prior: Prior) -> Mask:
    """Return which torque constants (6,) are far smaller than known: a unit or arm is wrong."""
    inverse, known, std = _beside_known(fit, prior)
    return (inverse - known > DEVIATIONS * std) & (inverse > RATIO * known)


def _beside_known(fit: CurrentFit, prior: Prior) -> tuple[Array, Array, Array]:
    """Return 1/k (6,) [A/Nm] as fitted, as known, and the standard deviation of the latter."""
    std = [prior.of_joint(joint).std for joint in range(len(fit.joints))]
    return _inverse_constants(fit), prior.inverse_constant.mean, np.array(std)


def _inverse_constants(fit: CurrentFit) -> Array:
    """Return 1/k (6,) [A/Nm]."""
    return np.array([joint.estimate.coefficients[0] for joint in fit.joints])


def _fit_with(
    records: Sequence[Record],
    smooth: Smooth,
    prior: Prior,
    family: Sequence[Term],
    seed: int,
) -> CurrentFit:
    """Return the fit under a prior as it is."""
    alone = [prior.of_joint(joint) for joint in range(len(prior.torque_max))]
    # how the friction of each joint reverses, with the least error on paths left out
    ways = (*PRESLIDING, KARNOPP)
    tried = [joint_samples(records, smooth, family, [way] * len(alone)) for way in ways]
    by_joint = zip(zip(*tried, strict=True), alone, strict=True)
    chosen = [choose_reversal(dahl, karnopp, own) for (*dahl, karnopp), own in by_joint]
    samples, errors = zip(*chosen, strict=True)
    # friction terms of each joint, then the coefficients of all joints
    terms = [choose_terms(*pair) for pair in zip(samples, alone, strict=True)]
    estimates, units = estimate_together(samples, terms, prior, seed)
    # standard errors of the fit with the terms that are always considered
    fuller = [(*own, *(term for term in CONSIDERED if term not in own)) for own in terms]
    fuller_estimates, _ = estimate_together(samples, fuller, prior, seed)
    estimates = [*map(beside_fuller, estimates, fuller_estimates)]
    each = zip(samples, terms, alone, estimates, errors, strict=True)
    joints = [_joint_fit(*joint) for joint in each]
    for joint, found in unlike_others(_untold(joints, samples, prior, seed), prior):
        joints[joint] = replace(joints[joint], remarks=(*joints[joint].remarks, found))
    return CurrentFit(tuple(joints), units, len(np.unique(record_days(records))))


def _untold(
    joints: Sequence[JointFit], samples: Sequence[Samples], prior: Prior, seed: int
) -> list[JointFit]:
    """Return the joints with friction as the recordings alone show it.

    Typical friction would pull the torque constant along: more current is more friction or a
    smaller constant.
    """
    typical = {name: known for name, known in prior.typical.items() if name not in FRICTION}
    terms, alone = [joint.terms for joint in joints], replace(prior, typical=typical)
    estimates, _ = estimate_together(samples, terms, alone, seed)
    errors = [
        np.maximum(own.std_error, one.estimate.std_error)
        for own, one in zip(estimates, joints, strict=True)
    ]
    found = zip(joints, estimates, errors, strict=True)
    return [replace(one, estimate=replace(own, std_error=error)) for one, own, error in found]


def unlike_others(joints: Sequence[JointFit], prior: Prior) -> Iterator[tuple[int, Remark]]:
    """Yield joints whose friction differs from what other arms and its own arm's joints have.

    The squared deviations of Coulomb and viscous friction add up. With further terms, both are only
    a part of friction, and not compared. odds: one in so many joints differs as much by chance.
    """
    compared = [
        _Compared.of(joints, name, known)
        for name in FRICTION
        if (known := prior.typical.get(name)) is not None
    ]
    # the farthest first, which then no longer shifts what is expected of the others
    while compared:
        deviation = np.array([own.deviation() for own in compared])  # (2, n)
        freedom = sum(own.error < VAGUE for own in compared)
        chance = chdtrc(np.maximum(freedom, 1), (deviation**2).sum(axis=0))
        joint = int(np.argmin(chance))
        if chance[joint] > UNUSUAL:
            break
        farthest = compared[int(np.argmax(np.abs(deviation[:, joint])))]
        words = {"parameter": farthest.name, "ratio": float(np.exp(farthest.value[joint]))}
        odds = round(1 / max(float(chance[joint]), RAREST))
        yield joint, remark("unlike other arms", **words, arms=farthest.arms, odds=odds)
        for own in compared:
            own.value[joint], own.error[joint] = 0.0, VAGUE


@dataclass(frozen=True)
class _Compared:
    """Friction of an arm's joints beside its typical value.

    value, error: logarithm of the ratio (n,) and its standard error, VAGUE where incomparable;
    spread: covariance (n, n) of such logarithms among arms; arms: how many were measured.
    """

    name: str
    value: Array
    error: Array
    spread: Array
    arms: int

    @classmethod
    def of(cls, joints: Sequence[JointFit], name: str, known: Typical) -> Self:
        """Return what was fitted to joints beside what is typical."""
        place = joints[0].names().index(name)
        value = np.array([physical(one.estimate.coefficients)[place] for one in joints])
        error = np.array([one.estimate.std_error[place] for one in joints])
        comparable = np.array([one.terms == BASE for one in joints]) & (value > 0)
        ratio = np.log(np.where(comparable, value / known.mean, 1.0))
        error = np.where(comparable, error / value, VAGUE)
        spread = known.covariance / np.outer(known.mean, known.mean)
        return cls(name, ratio, error, spread, known.arms)

    def deviation(self) -> Array:
        """Return each joint's deviation (n,) from its prediction by the others.

        (C⁻¹ y)ⱼ / √(C⁻¹)ⱼⱼ, in standard deviations, y being the values and C their covariance.
        """
        precision = np.linalg.inv(self.spread + np.diag(self.error**2))
        return np.asarray(precision @ self.value / np.sqrt(np.diag(precision)))


def fit_without_each_path(
    records: Sequence[Record], smooth: Smooth, prior: Prior, family: Sequence[Term] = FAMILY
) -> list[tuple[list[str], CurrentFit]]:
    """Cross-fit: return fits without some paths and days, each with the recordings that it judges.

    A prediction that judges a recording comes from a fit without its path, and without its day if
    other days have enough paths. There are at most FOLDS fits: of many paths, several are left out
    together; with a single path, there is none.
    """
    path, day = record_paths(records), record_days(records)
    if path.max(initial=0) == 0:
        return []
    judged: dict[tuple[str, ...], list[str]] = {}  # by the recordings to fit
    for fold in range(min(FOLDS, path.max() + 1)):
        out = path % FOLDS == fold
        kept = apart_from(out, path, day)
        judged.setdefault(tuple(_names(records, kept)), []).extend(_names(records, out))
    known = {record.name: record for record in records}
    return [
        (names, fit_currents([known[name] for name in kept], smooth, prior, family))
        for kept, names in judged.items()
    ]


def _names(records: Sequence[Record], chosen: Mask) -> list[str]:
    """Return the names of the recordings in a mask (R,)."""
    return [record.name for record, own in zip(records, chosen, strict=True) if own]


def breakaway_torque(fit: CurrentFit) -> Array:
    """Return Coulomb friction (6,) [Nm], up to which dry friction holds a joint.

    Without its load-dependent part; at least LEAST_FRICTION.
    """
    coulomb = [
        physical(joint.estimate.coefficients)[joint.names().index("coulomb")]
        for joint in fit.joints
    ]
    return np.maximum(np.array(coulomb), LEAST_FRICTION)


def torque_constants(fit: CurrentFit) -> Array:
    """Return the torque constants (6,) [Nm/A] of the joints."""
    return 1 / _inverse_constants(fit)


def constants_band(fit: CurrentFit) -> Array:
    """Return half of the relative 95 % intervals (6,) of the torque constants over 1.96.

    Of few paths, that is more than `constants_doubt`: their standard errors are uncertain, too.
    """
    shares = np.array([joint.estimate.prior_share[0] for joint in fit.joints])
    return half_width(constants_doubt(fit), fit.units, shares) / NORMAL95


def constants_doubt(fit: CurrentFit) -> Array:
    """Return the relative standard errors (6,) of the torque constants."""
    errors = np.array([joint.estimate.std_error[0] for joint in fit.joints])
    return np.abs(errors / torque_constants(fit))


def predict(fit: CurrentFit, record: Record) -> Array:
    """Predict the current (N, 6) [A] of a motion without contact; ignores the record's current."""
    currents = [
        columns @ model.estimate.coefficients + model.held * held
        for model, columns, held in _designs(fit, record)
    ]
    return np.stack(currents, axis=1)


def friction_current(fit: CurrentFit, record: Record) -> Array:
    """Return the part (N, 6) [A] of the predicted current that friction takes in motion."""
    currents = [
        columns[:, 2:] @ model.estimate.coefficients[2:]
        for model, columns, _ in _designs(fit, record)
    ]
    return np.stack(currents, axis=1)


def _designs(fit: CurrentFit, record: Record) -> Iterator[tuple[JointFit, Array, Array]]:
    """Yield each joint's fit and its `design` of a motion."""
    for joint, model in enumerate(fit.joints):
        yield model, *design(record, joint, model.terms, model.presliding)


def load_loss(fit: CurrentFit, record: Record) -> Array:
    """Return load-dependent friction per Nm that the gears transmit (N, 6), with its sign."""
    loss = np.empty_like(record.q)
    for joint, (model, constant) in enumerate(zip(fit.joints, torque_constants(fit), strict=True)):
        coefficient = constant * model.estimate.coefficients[model.names().index("load")]
        loss[:, joint] = coefficient * record.joint(joint, model.presliding).direction
    return loss


def band(fit: CurrentFit, record: Record, smooth: Smooth) -> Array:
    """Return half the 95 % band (N, n) [A] of low-passed predictions on a day of its own.

    Friction differs from day to day, which recordings of one day do not show.
    """
    friction = smooth(friction_current(fit, record), record)
    moving, at_rest = np.array([(joint.band_moving, joint.band_rest) for joint in fit.joints]).T
    within = np.where(smoothed_moving(record, smooth), moving, at_rest)
    between = BETWEEN_DAYS * friction if fit.days < 2 else 0.0
    doubt = smooth(_coefficients_doubt(fit, record), record)
    return np.hypot(within, NORMAL95 * np.hypot(between, doubt))


def _coefficients_doubt(fit: CurrentFit, record: Record) -> Array:
    """Return the standard deviation (N, 6) [A] of a prediction by the coefficients' doubt."""
    doubts = np.zeros_like(record.q)
    for joint, (model, columns, _) in enumerate(_designs(fit, record)):
        if model.doubt is not None:
            doubts[:, joint] = np.sqrt(((columns @ model.doubt) * columns).sum(axis=1))
    return doubts


def parameters(fit: CurrentFit) -> list[Parameter]:
    """Return torque constants [Nm/A], offsets [Nm] and friction [Nm, Nm s/rad, ...]."""
    rows = []
    for joint, model in enumerate(fit.joints, start=1):
        estimate = model.estimate
        values = physical(estimate.coefficients)
        half = half_width(estimate.std_error, fit.units, estimate.prior_share)
        columns = (values, estimate.std_error, values - half, values + half, *estimate.shares)
        for name, *own in zip(model.names(), *columns, strict=True):
            value, error, low, high, prior, arm, day, run = own
            # of a torque constant, the sign must be determined, too
            known = bool(prior < UNDETERMINED and (name != "torque_constant" or low > 0))
            shares = prior, arm, day, run
            rows.append(Parameter(joint, name, value, error, (low, high), *shares, known))
    return rows


def _joint_fit(
    samples: Samples,
    terms: tuple[Term, ...],
    prior: JointPrior,
    estimate: Estimate,
    reversal_errors: tuple[float, ...],
) -> JointFit:
    """Return the fit of a joint: its estimate with friction at rest, bands and remarks."""
    coefficients = estimate.coefficients
    residual, doubt = left_out_residuals(samples, terms, prior), None
    if not np.isfinite(residual[samples.moving]).any():  # no motion is left out
        doubt = np.cov(estimate.replicates.T)
    if not np.isfinite(residual).any():  # a single path: residuals of the fit itself
        residual = samples.current - samples.design(terms) @ coefficients
    moving, coulomb = samples.moving, max(0.0, float(coefficients[2]))
    return JointFit(
        terms,
        estimate,
        samples.presliding,
        reversal_errors,
        held_current(samples, terms, coefficients),
        band_of_recordings(residual[moving], samples.record[moving], MOVING, coulomb),
        band_of_recordings(residual[~moving], samples.record[~moving], RESTING, coulomb),
        _remarks(samples, estimate, prior),
        doubt,
    )


def band_of_recordings(residual: Array, record: Labels, usual: Usual, coulomb: float) -> float:
    """Return half of the 95 % band [A] of one more recording; coulomb: friction [A].

    Recordings have errors of different size: their variance is s² ν / χ²(ν). If all are too short,
    they are taken together.
    """
    each = [residual[record == one] for one in np.unique(record)]
    long = [errors for errors in each if len(errors) >= FEWEST] or [residual]
    squares = [float(np.mean(errors**2)) for errors in long if len(errors) >= FEWEST]
    count = usual.recordings + len(squares)
    variance = (usual.recordings * (usual.error * coulomb) ** 2 + sum(squares)) / count
    return float(stdtrit(count, 0.975) * np.sqrt(variance))


def _remarks(samples: Samples, estimate: Estimate, prior: JointPrior) -> tuple[Remark, ...]:
    """Return the doubts about the fit of a joint."""
    moved = len(np.unique(samples.path[samples.moving]))
    remarks = []
    if moved < FEW:
        code = {0: "no motion", 1: "one path"}.get(moved, "few paths")
        remarks.append(remark(code, paths=moved))
    away = abs(estimate.coefficients[0] - prior.inverse) / prior.std
    if away > CONFLICT:
        remarks.append(remark("unlikely constant", deviations=float(away)))
    return tuple(remarks)
