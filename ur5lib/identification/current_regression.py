"""Regression of motor currents on motion: torque constants, offsets and friction of all joints.

The regression target is the current, because it is noisy: i = (τ + τ_friction - b) / k is linear
in 1/k, b/k and the friction coefficients over k, which are fitted to samples in motion. At rest,
friction can be any torque up to breakaway: a fitted share of the friction before the stop remains.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ur5lib.channels import TORQUE, Effort
from ur5lib.errors import Remark
from ur5lib.identification.currents import (
    constants_band,
    constants_doubt,
    dry_friction,
    torque_constants,
    unseen_difference,
)
from ur5lib.identification.estimation import estimate_together, physical_values, with_fuller_errors
from ur5lib.identification.joint_regression import (
    HELD_FRICTION_SHARE,
    MAX_FOLDS,
    MIN_SAMPLES,
    held_current,
    left_out_residuals,
)
from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import REPLICATE_COUNT, half_width, spread
from ur5lib.identification.samples import (
    MIN_UNITS,
    CurrentSamples,
    JointSamples,
    Smooth,
    apart_from,
    joint_samples,
    record_days,
    record_paths,
)
from ur5lib.identification.selection import in_units, shows_gain, with_shown_terms
from ur5lib.records.codes import CauseCode
from ur5lib.records.friction import CoefficientEstimate, CurrentFit, JointFit
from ur5lib.records.phrases import number
from ur5lib.robots.friction import (
    BASE_TERMS,
    CONSIDERED_OF_TORQUES,
    CONSIDERED_TERMS,
)
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.metrics import NORMAL95

# A torque constant is doubted, or contradicts the documented one, where it is off by more than
# both: prior standard deviations, and a ratio. In right recordings of two arms, it is up to 5.6
# standard deviations off, with ratios of 0.68 to 1.29: wrists lose that in their gears.
DOUBTFUL_DEVIATIONS = 3.0
DOUBTFUL_RATIO = 1.5
CONTRADICTING_DEVIATIONS = 5.0
CONTRADICTING_RATIO = 1.75
# The gain of a measured torque is 1, unless side, link or sign differ from the description.
GAIN_RANGE = 0.9, 1.1
# Usual errors of a current along a path that no fit has seen, by `MotionState`, and least ones,
# relative to Coulomb friction: at rest, dry friction lies anywhere within it.
UNSEEN_ERRORS = 0.25, 0.5, 1.25, 1.25
LEAST_ERRORS = 0.0, 0.0, 1 / np.sqrt(3), 1 / np.sqrt(3)


def fit_currents(
    records: Sequence[CurrentSamples], smooth: Smooth, prior: Prior, seed: int = 0
) -> CurrentFit:
    """Return the fit of all joints' currents to contact-free recordings.

    smooth: a zero-phase low-pass at, for example, 2 Hz: above, the measured current is noise. A
    joint keeps the prior's torque constant if its current does not follow its torque.
    """
    samples = joint_samples(records, smooth, _tried(prior))
    shown, left = with_shown_terms(samples, prior)
    gains = partial(_with_shown_gains, samples, shown)
    fit, known = _with_known_where_lost(shown, lambda own: _estimated(samples, own, seed), gains)
    chosen = [own.of(known.terms, known.distances) for own in samples]
    joint_priors = [known.of_joint(joint) for joint in range(len(samples))]
    for joint, own in enumerate(chosen):  # with fits other than those of the selection
        if joint in known.pinned or in_units(own) is not own:
            left[joint] = left_out_residuals(own, joint_priors[joint])
    joints = tuple(map(_with_bands, fit.joints, chosen, joint_priors, left))
    dates = sorted({record.day for record in records} - {""})
    return CurrentFit(joints, fit.units, tuple(dates))


def _tried(prior: Prior) -> tuple[str, ...]:
    """Return all terms of friction that a fit may use: a prior's, those tried in addition, and
    those that enter its errors.
    """
    return tuple(dict.fromkeys([*prior.terms, *prior.tried, *_considered(prior)]))


def _considered(prior: Prior) -> tuple[str, ...]:
    """Return the further terms of friction that enter the errors of a prior's terms."""
    return CONSIDERED_OF_TORQUES if prior.measured == TORQUE else CONSIDERED_TERMS


def _with_shown_gains(samples: Sequence[JointSamples], prior: Prior, vague: Mask) -> Mask:
    """Return which joints (n,) with a vague gain keep the prior's: those of which left-out parts
    show no other gain.

    vague: (n,), the joints with a vague gain.
    """
    joints = [bool(own and not shows_gain(samples[j], prior, j)) for j, own in enumerate(vague)]
    return np.array(joints)


def fit_postures(prior: Prior, seed: int = 0) -> CurrentFit:
    """Return the torque constants fitted to the prior's postures at rest, with the prior's
    friction.
    """
    return _with_known_where_lost(prior, lambda known: expected_fit(known, seed))[0]


def _with_known_where_lost(
    prior: Prior,
    fitted: Callable[[Prior], CurrentFit],
    kept: Callable[[Mask], Mask] = np.array,
) -> tuple[CurrentFit, Prior]:
    """Return a fit, and its prior, in which joints keep the prior's k if their current does not
    follow their torque.

    fitted: returns the fit under a prior; kept: returns which vague gains keep the prior's. Gains
    of measured torques are first fitted without their prior: under it, a fit would take
    contradictions for noise. Gains that the prior gives more precisely keep it, too.
    """
    sensed = prior.measured == TORQUE
    fit = fitted(prior.with_wide_gains() if sensed else prior)
    lost = beyond_range(fit) if sensed else too_large(fit, prior)
    if not (sensed or lost.any()):
        return fit, prior
    vague = sensed & (constants_band(fit) > prior.std())
    shown = vague & ~lost & ~kept(vague & ~lost)
    vague &= ~shown
    contradicted_joints, known_constants = fit.joints, 1 / prior.inverse_constant.mean
    halves = _inverse_half(fit)
    known = prior.with_pinned(lost | vague)
    fit = fitted(known)
    still_vague = sensed & ~vague & ~shown & (constants_band(fit) > prior.std())
    if still_vague.any():
        known = prior.with_pinned(lost | vague | still_vague)
        fit = fitted(known)
    joints = list(fit.joints)
    for joint in np.flatnonzero(lost).tolist():
        coefficients = contradicted_joints[joint].estimate.coefficients
        doubt = _against(float(1 / coefficients[0]), float(known_constants[joint]), sensed)
        remarks = *joints[joint].remarks, doubt
        half = float(halves[joint])
        joints[joint] = replace(joints[joint], alone=coefficients, alone_half=half, remarks=remarks)
    return replace(fit, joints=tuple(joints)), known


def _against(alone: float, known: float, sensed: bool) -> Remark:
    """Return the remark on a joint with a fitted constant or gain that contradicts the documented
    one; sensed: whether it is a measured torque's gain.
    """
    by_itself = f"by itself, it would give {number(alone, '.3g')}"
    if sensed:
        text = (
            f"the measured torque contradicts its gain of 1, which is used; {by_itself} Nm/Nm: "
            "a link or a column may be wrong, a spring be missing (`balanced_joints`), "
            "or, of a negative gain, the sign be reversed (`units`); record faster and loaded "
            "motions"
        )
        return Remark(CauseCode.TORQUE_AGAINST_GAIN, text, constants=(alone, known))
    text = (
        f"the motor contradicts its known torque constant, {number(known, '.3g')} Nm/A, which is "
        f"used; {by_itself}: the inertia of the rotor may be missing, or a column be wrong; record "
        "faster and loaded motions"
    )
    return Remark(CauseCode.CURRENT_AGAINST_CONSTANT, text, constants=(alone, known))


def expected_fit(prior: Prior, seed: int = 0) -> CurrentFit:
    """Return the fit of each joint that a prior with typical friction gives without data in
    motion.
    """
    if prior.at_rest is None:
        return CurrentFit(tuple(map(_with_usual_bands, *_prior_estimates(prior, seed))), 0)
    return _of_estimates(*estimate_together((), prior, seed))


def _prior_estimates(prior: Prior, seed: int) -> tuple[list[CoefficientEstimate], list[Array]]:
    """Return, for each joint, the prior as an estimate, and its covariance (P, P)."""
    joint_prior = prior.over(BASE_TERMS)
    covariance = np.asarray(np.linalg.inv(joint_prior.precision), dtype=np.float64)
    replicates = np.random.default_rng(seed).multivariate_normal(
        joint_prior.mean, covariance, REPLICATE_COUNT
    )
    size = len(joint_prior.mean) // len(prior.torque_max)
    shares = np.stack([np.ones(size), *np.zeros((3, size))])  # all is from the prior
    parts = [slice(start, start + size) for start in range(0, len(joint_prior.mean), size)]
    estimates = [
        CoefficientEstimate(
            joint_prior.mean[columns],
            shares,
            replicates[:, columns],
            spread(physical_values(replicates[:, columns])),
        )
        for columns in parts
    ]
    return estimates, [covariance[columns, columns] for columns in parts]


def _of_estimates(estimates: Sequence[CoefficientEstimate], units: int) -> CurrentFit:
    """Return the joints' estimates as a fit with usual bands; units: number of the bootstrap's
    units.
    """
    doubts = [np.cov(estimate.replicates.T) for estimate in estimates]
    return CurrentFit(tuple(map(_with_usual_bands, estimates, doubts)), units)


def _with_usual_bands(estimate: CoefficientEstimate, doubt: Array) -> JointFit:
    """Return the fit of a joint with usual bands, without left-out samples; doubt: covariance (P,
    P) of its coefficients.
    """
    coulomb = float(estimate.coefficients[2])
    moving, reversing, standing, unknown = (NORMAL95 * usual * coulomb for usual in UNSEEN_ERRORS)
    return JointFit(
        terms=BASE_TERMS,
        distances=(),
        estimate=estimate,
        held=np.array([HELD_FRICTION_SHARE * coulomb]),
        band_moving=moving,
        band_reversing=reversing,
        band_standing=standing,
        band_unknown=unknown,
        unseen=np.zeros(len(estimate.coefficients)),
        remarks=(),
        doubt=doubt,
    )


def beyond_range(fit: CurrentFit) -> Mask:
    """Return which gains (n,) are outside GAIN_RANGE by more than the 95 % interval of 1/gain."""
    inverse, half = 1 / torque_constants(fit), _inverse_half(fit)
    beyond: Mask = (inverse + half < 1 / GAIN_RANGE[1]) | (inverse - half > 1 / GAIN_RANGE[0])
    return beyond


def too_large(fit: CurrentFit, prior: Prior) -> Mask:
    """Return which torque constants (n,) are far larger than the prior's, or negative.

    The current then follows little of the joint's torque. Deviations are those of k, since 1/k
    cannot be far below the prior's; a k less certain than the prior's counts as far.
    """
    inverse, known_inverse, std = _inverse_constants(fit, prior)
    # σ_k = σ_(1/k) k², by the delta method
    is_far = 1 / inverse - 1 / known_inverse > CONTRADICTING_DEVIATIONS * std / known_inverse**2
    is_vague = constants_doubt(fit) / np.abs(inverse) > std / known_inverse**2
    return (inverse <= 0) | ((is_far | is_vague) & (inverse < known_inverse / CONTRADICTING_RATIO))


def too_small(fit: CurrentFit, prior: Prior) -> Mask:
    """Return which torque constants (n,) are far below the prior's, beyond their 95 % interval.

    A unit or the arm is wrong then.
    """
    inverse, known_inverse, std = _inverse_constants(fit, prior)
    far = inverse - known_inverse > CONTRADICTING_DEVIATIONS * std
    surely = inverse - _inverse_half(fit) > known_inverse
    return far & surely & (inverse > CONTRADICTING_RATIO * known_inverse)


def _inverse_half(fit: CurrentFit) -> Array:
    """Return the half-width (n,) of the 95 % intervals of 1/k [A/Nm]."""
    return NORMAL95 * constants_band(fit) / np.abs(torque_constants(fit))


def _inverse_constants(fit: CurrentFit, prior: Prior) -> tuple[Array, Array, Array]:
    """Return (n,) each: 1/k [A/Nm] as fitted, that of the prior, and the prior's standard
    deviation.
    """
    return 1 / torque_constants(fit), prior.inverse_constant.mean, prior.std()


def _estimated(samples: Sequence[JointSamples], prior: Prior, seed: int) -> CurrentFit:
    """Return the fit under a prior, with usual bands and the prior's terms; samples: with all
    columns.
    """
    considered = *prior.terms, *_considered(prior)
    chosen, fuller = (
        [own.of(terms, prior.distances) for own in samples] for terms in (prior.terms, considered)
    )
    estimates, units = estimate_together(chosen, prior, seed)
    of_fuller, _ = estimate_together(fuller, prior, seed)
    return _of_estimates([*map(with_fuller_errors, estimates, of_fuller)], units)


def fit_without_each_path(
    records: Sequence[CurrentSamples], smooth: Smooth, prior: Prior
) -> list[tuple[list[str], CurrentFit]]:
    """Return fits without some paths and days, each with the names of the recordings left out
    (cross-fit).

    A recording is predicted by a fit without its path, and without its day if other days have
    enough paths. There are at most MAX_FOLDS fits: of many paths, several are left out together;
    with a single path, there is none.
    """
    path, day = record_paths(records), record_days(records)
    if path.max(initial=0) == 0:
        return []
    names_by_fit: dict[tuple[int, ...], list[str]] = {}  # by the recordings to fit
    for fold in range(min(MAX_FOLDS, path.max() + 1)):
        out = path % MAX_FOLDS == fold
        fitted_places = tuple(np.flatnonzero(apart_from(out, path, day)).tolist())
        names = [records[place].name for place in np.flatnonzero(out).tolist()]
        names_by_fit.setdefault(fitted_places, []).extend(names)
    return [
        (names, fit_currents([records[place] for place in fitted_places], smooth, prior))
        for fitted_places, names in names_by_fit.items()
    ]


def _with_bands(joint: JointFit, samples: JointSamples, prior: Prior, left: Array) -> JointFit:
    """Return the fit of a joint with friction at rest, bands and remarks by its samples.

    left: residuals (n,) [A] of the samples, each predicted by a fit to other paths.
    """
    estimate, coefficients = joint.estimate, joint.estimate.coefficients
    path, moving = samples.path, samples.moving
    is_left_out = moving.sum() >= MIN_SAMPLES and len(np.unique(path)) > 1
    of_motion = samples.day[moving], samples.record[moving], path[moving]
    coulomb = dry_friction(samples.terms, coefficients)
    in_motion, reversing, standing, unknown = _bands(samples, left, coulomb)
    return replace(
        joint,
        terms=samples.terms,
        distances=samples.distances,
        held=held_current(samples, coefficients),
        band_moving=in_motion,
        band_reversing=reversing,
        band_standing=standing,
        band_unknown=unknown,
        unseen=unseen_difference(
            estimate, *(max(1, len(np.unique(labels))) for labels in of_motion)
        ),
        remarks=(*_remarks(samples, estimate, prior), *joint.remarks),
        doubt=None if is_left_out else joint.doubt,
    )


def _bands(samples: JointSamples, residual: Array, coulomb: float) -> Iterator[float]:
    """Yield the half-widths [A] of a `JointFit`'s bands, one for each `MotionState`; residual: (n,)
    [A]; coulomb: friction [A].
    """
    for state, (usual, least) in enumerate(zip(UNSEEN_ERRORS, LEAST_ERRORS, strict=True)):
        rows = samples.state == state
        yield NORMAL95 * max(
            unseen_error(residual[rows], samples.path[rows], samples.day[rows], usual * coulomb),
            least * coulomb,
        )


def unseen_error(residual: Array, path: Labels, day: Labels, usual: float) -> float:
    """Return the standard error σ [A] of a current along one more path: ± 1.96 σ contain 95 %.

    σ = √(m² + u² / P), or m t / 1.96 if that is less. 95 % of the residuals (n,) are below 1.96 m;
    u = usual [A]: error on an unseen path; P: number of paths; t: Student's, of the number of days,
    or of paths if there is one day. path, day: (n,) labels. With fewer than MIN_SAMPLES, it is u.
    """
    if len(residual) < MIN_SAMPLES:
        return usual
    error = np.quantile(np.abs(residual), 0.95) / NORMAL95
    paths, days = len(np.unique(path)), len(np.unique(day))
    with_usual = float(np.hypot(error, usual / np.sqrt(paths)))
    groups = days if days > 1 else paths
    return (
        with_usual if groups == 1 else min(with_usual, float(half_width(error, groups)) / NORMAL95)
    )


def _remarks(
    samples: JointSamples, estimate: CoefficientEstimate, prior: Prior
) -> tuple[Remark, ...]:
    """Return the doubts about the fit of a joint."""
    remarks = [*_few_paths(len(np.unique(samples.path[samples.moving])), prior.measured)]
    inverse, known_inverse = float(estimate.coefficients[0]), float(prior.inverse_constant.mean[0])
    deviations = abs(inverse - known_inverse) / float(prior.std()[0])
    if (
        deviations > DOUBTFUL_DEVIATIONS
        and not known_inverse / DOUBTFUL_RATIO < inverse < known_inverse * DOUBTFUL_RATIO
    ):
        known_std = float(prior.std()[0]) / known_inverse**2
        text = (
            f"{prior.measured.constant} contradicts the known one, {number(1 / inverse, '.3g')} "
            f"instead of {number(1 / known_inverse, '.3g')} ± {number(known_std, '.2g')} "
            f"{prior.measured.constant_unit}: check columns, units and robot"
        )
        remarks.append(Remark(CauseCode.UNLIKELY_CONSTANT, text))
    return tuple(remarks)


def _few_paths(moved: int, measured: Effort) -> Iterator[Remark]:
    """Yield a remark if a joint moves along too few paths; moved: their number."""
    if moved == 0:
        text = (
            f"does not move: its friction is unknown and its {measured.constant} is that of the "
            "prior; record a motion of this joint"
        )
        yield Remark(CauseCode.NO_MOTION, text)
    elif moved == 1:
        text = (
            "moves along one path only: no further friction term is selected, and the error bars "
            "are untested; record another path"
        )
        yield Remark(CauseCode.ONE_PATH, text)
    elif moved < MIN_UNITS:
        text = (
            f"moves along {moved} paths only: the variation between paths is hardly known; record "
            "more paths"
        )
        yield Remark(CauseCode.FEW_PATHS, text)
