"""The map from motion to motor current: torque constants and friction, from `fit` recordings."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.checks.doubts import doubt_in_words, doubts_by_joint
from ur5lib.checks.postures import contradicting_constants, other_constant
from ur5lib.checks.sides import unknown_side
from ur5lib.errors import RefusalError, Remark, reason
from ur5lib.identification.at_rest import AtRest
from ur5lib.identification.current_regression import (
    expected_fit,
    fit_currents,
    fit_postures,
    fit_without_each_path,
    too_small,
)
from ur5lib.identification.current_samples import (
    FitSettings,
    ZeroPhaseLowpass,
    controllers_ratio,
    current_record,
    prior_of,
)
from ur5lib.identification.currents import parameters, predict, torque_constants
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import CurrentSamples, Smooth, record_paths
from ur5lib.identification.steady_friction import fastest, friction_curve, mean_load, total_friction
from ur5lib.identification.validation import (
    explained_share,
    fitted_on_tested_on,
    least_squares_coefficients,
    with_rotors_that_show,
)
from ur5lib.recordings.copies import same_runs
from ur5lib.records.accepted import accepted_sign
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.codes import CauseCode
from ur5lib.records.friction import CurrentFit, Friction, JointFit, KnownConstants, LeftOut
from ur5lib.records.motion import Motion, motions_before
from ur5lib.records.phrases import number
from ur5lib.records.postures import Postures
from ur5lib.records.premises import MARGIN, Premises
from ur5lib.records.quality import Contradictions, Finding, Quality
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import within

# At most this many joints may have a current that does not follow the torque; the others then
# still determine a force.
MAX_JOINTS_WITHOUT_LOAD = 3
# At most this many joints may have another gain of the torque, because of a spring, a column or a
# link.
MAX_JOINTS_OF_OTHER_GAIN = 1
# Remarks on a joint that contradicts its documented constant, which is used instead.
UNEXPLAINED = CauseCode.CURRENT_AGAINST_CONSTANT, CauseCode.TORQUE_AGAINST_GAIN
# A joint is remarked on from so many deviations of the prior on: joints of UR3, UR5, UR10 and UR10e
# are up to 1.9 of these off.
FAR_DEVIATIONS, FAR_AT_SPEED = 5.0, 0.5  # rad/s
MIN_GAIN = 0.4  # of such a joint, at least; with a smaller one, a unit is wrong


class Inputs(AlignedRecording):
    """What is read of a recording."""

    premises: Premises
    quality: Quality


@step("arm", "friction.json", recordings="fit", before="before_fitted")
def fit_friction(
    arm: Robot,
    recordings: Mapping[str, Inputs],
    postures: Mapping[str, Postures],
    dates: dict[str, str],
    fit_settings: FitSettings,
    accepted: dict[str, str] | None = None,
    before: Mapping[str, Motion] | None = None,
    chains: dict[str, list[str]] | None = None,
) -> Friction:
    """Return torque constants and friction of an arm; `refused` where they cannot be fitted.

    recordings: the arm's `fit` recordings, postures: those at rest; dates: of recordings, ISO 8601
    or empty; accepted: reasons to overrule stop signs of the arm, by kind; before: motions of
    earlier recordings, by name; chains: their names for each recording, oldest first.
    """
    if arm.links == "unknown":
        return Friction(refused=_unknown_links(arm))
    model, smooth = arm.fullest_model(), ZeroPhaseLowpass(*fit_settings.lowpass)
    contradictions, quality = dict[str, Contradictions](), dict[str, Quality]()
    records, ratios = [], []
    for name, recording in recordings.items():
        contradictions[name], quality[name] = recording.premises.contradictions, recording.quality
        earlier = motions_before(recording.motion, (chains or {}).get(name, []), before or {})
        record = current_record(recording, arm, earlier)
        if record is not None:
            known = untouched(record, recording.signals.time, recording.premises.touched)
            records.append(replace(known, day=dates[name]))
            odd = contradictions[name].odd_targets()
            ratios.append(controllers_ratio(recording.signals, recording.motion, odd))
    at_rest = dict(postures.items())
    contradictions |= {name: one.contradictions for name, one in at_rest.items()}
    held = [(one.held_torque(arm, model), one.current) for one in at_rest.values()]
    try:
        require_no_stop_sign(contradictions)
        require_single_runs(quality)
        if "side" not in (accepted or {}):
            require_known_side(arm)
        prior = prior_of(arm, ratios, fit_settings.terms, fit_settings.prior)
        prior = replace(prior, at_rest=AtRest.of(held))
        fitted = fitted_friction(records, prior, smooth, model, accepted)
        findings = chain.from_iterable(one.findings for one in contradictions.values())
        fit = with_causes(fitted.fit, doubts_by_joint(findings), arm)
        touched = {name: one.premises.touched for name, one in recordings.items()}
        return replace(
            fitted,
            fit=fit,
            at_rest=[*at_rest],
            effort=arm.measured.quantity,
            touched={name: own for name, own in touched.items() if own},
        )
    except ContradictionError as sign:
        return Friction(stopped=sign.remark)
    except ValueError as error:
        return Friction(refused=reason(error))


def untouched(
    record: CurrentSamples, time: Array, contacts: Sequence[tuple[float, float]]
) -> CurrentSamples:
    """Return a record with unknown efforts in contacts, from and to [s]; time: (N,) [s]."""
    if not contacts:
        return record
    touched = within(time, contacts, MARGIN)
    return replace(record, current=np.where(touched[:, None], np.nan, record.current))


def _unknown_links(arm: Robot) -> Remark:
    text = (
        f"the links of {arm.name} are unknown, and its recordings with the role “fit” do not tell "
        "them: record actual_torque on several paths, or describe masses, centres of mass and "
        "inertias"
    )
    return Remark(CauseCode.UNKNOWN_LINKS, text)


def with_causes(fit: CurrentFit, doubts: Mapping[int, Finding], arm: Robot) -> CurrentFit:
    """Return the fit with the cause, where one was found, in the remark on each joint that
    contradicts its documented constant.

    doubts: of the recordings' checks about the arm's links, by joint from 1.
    """

    def caused(joint: int, one: Remark) -> Remark:
        if joint not in doubts or one.code not in UNEXPLAINED or one.constants is None:
            return one
        alone, known = (number(value, ".3g") for value in one.constants)
        doubt = doubt_in_words(doubts[joint].cause, arm.name, [joint])
        text = (
            f"{doubt} (by itself, this joint's {arm.measured.constant} would be {alone}; the known "
            f"{known} {arm.measured.constant_unit} is used)"
        )
        return replace(one, code=CauseCode.EXPLAINED_CONTRADICTION, text=text)

    return replace(
        fit,
        joints=tuple(
            replace(own, remarks=tuple(caused(joint, one) for one in own.remarks))
            for joint, own in enumerate(fit.joints, start=1)
        ),
    )


class ContradictionError(RefusalError):
    """A stop sign: the recordings contradict the arm that the study names."""


def fitted_friction(
    records: Sequence[CurrentSamples],
    prior: Prior,
    smooth: Smooth,
    model: str = "",
    accepted: Mapping[str, str] | None = None,
) -> Friction:
    """Return the fit, the fits without each path, the parameters in SI units, and baselines.

    model: of the records' torques; accepted: as of `fit_friction`. Without records, the fit is that
    of typical friction, with torque constants by postures at rest if the prior has any. Raises
    ContradictionError when the torque constants are not those of the arm, RefusalError when there
    are neither records, nor postures, nor typical friction.
    """
    if not records:
        return _expected_friction(prior, model, accepted or {})
    records = with_rotors_that_show(records, smooth, prior)
    fit = fit_currents(records, smooth, prior)
    terms = fit.joints[0].terms
    doubts = accepted_doubts(fit, prior, accepted or {})
    left_out = fit_without_each_path(records, smooth, prior)
    explained = explained_by_others(records, left_out, smooth)
    load, paths = mean_load(records, smooth, terms), int(record_paths(records).max()) + 1
    return Friction(
        from_=[record.name for record in records],
        paths=paths,
        period=max(record.period for record in records),
        fit=with_unproven(with_far_friction(fit, load, prior), explained, prior.measured),
        left_out=[LeftOut(names, _without_replicates(own)) for names, own in left_out],
        usual=usual_of_one(paths, prior),
        explained=explained,
        parameters=parameters(fit, prior.measured),
        load=load,
        fastest=fastest(records),
        totals=total_friction(fit, load),
        known_constants=known_constants(prior),
        least_squares=least_squares_coefficients(records),
        cross_validation=fitted_on_tested_on(records, smooth, replace(prior, terms=terms)),
        model=model,
        remarks=doubts,
    )


def usual_of_one(paths: int, prior: Prior) -> CurrentFit | None:
    """Return the fit that a prior of currents gives without recordings; None where these have more
    than one path, or the prior has no typical friction.
    """
    if paths > 1 or not prior.typical or prior.measured != CURRENT:
        return None
    return _without_replicates(expected_fit(prior))


def _expected_friction(prior: Prior, model: str, accepted: Mapping[str, str]) -> Friction:
    """Return the friction of an arm without `fit` recordings in motion: the typical one, or without
    it, torque constants alone.
    """
    if not prior.typical and prior.at_rest is None:
        text = f"no recording with the role “fit” has {prior.measured.channel}"
        raise RefusalError(CauseCode.NO_FIT_RECORDING, text)
    fit = fit_postures(prior)
    doubts = accepted_doubts(fit, prior, accepted)
    found, known = parameters(fit), known_constants(prior)
    text = (
        f"no recording in motion has the role “fit”: {prior.measured.constant}s are known by "
        "gravity, friction is not"
    )
    if prior.typical:
        return Friction(
            fit=fit, parameters=found, known_constants=known, model=model, remarks=doubts
        )
    return Friction(
        remarks=doubts,
        parameters=[row for row in found if row.name == "torque_constant"],
        known_constants=known,
        model=model,
        refused=Remark(CauseCode.NO_FIT_IN_MOTION, text),
    )


def known_constants(prior: Prior) -> KnownConstants:
    """Return the torque constants that the prior of the fit states, with their standard errors."""
    inverse = prior.inverse_constant.mean
    return KnownConstants(1 / inverse, prior.std() / inverse**2)


def explained_by_others(
    records: Sequence[CurrentSamples],
    left_out: Sequence[tuple[list[str], CurrentFit]],
    smooth: Smooth,
) -> Array | None:
    """Return the share (n,) of the currents' variance that fits to other paths explain.

    left_out: fits, each with the names of its left-out recordings. None if all recordings follow
    one path.
    """
    unseen = {name: fit for names, fit in left_out for name in names}
    if not unseen:
        return None
    return explained_share(records, [predict(unseen[own.name], own) for own in records], smooth)


def with_unproven(fit: CurrentFit, explained: Array | None, measured: Effort) -> CurrentFit:
    """Return a fit with a remark on each moving joint that left-out fits predict no better than a
    constant does.

    explained: as of `explained_by_others`; measured: the predicted effort.
    """
    shares = np.full(len(fit.joints), np.inf) if explained is None else explained
    text = (
        f"fits to the other paths predict its {measured.quantity} worse than a constant does: "
        "record contact-free motion along several paths"
    )
    unproven = Remark(CauseCode.UNPROVEN_FIT, text)
    joints = [
        own
        if share > 0 or CauseCode.NO_MOTION in (one.code for one in own.remarks)
        else replace(own, remarks=(*own.remarks, unproven))
        for own, share in zip(fit.joints, shares, strict=True)
    ]
    return replace(fit, joints=tuple(joints))


def with_far_friction(fit: CurrentFit, load: Array, prior: Prior) -> CurrentFit:
    """Return a fit with a remark on each joint whose friction is far from what the prior expects.

    load: mean size (n,) [Nm] of the torque on each joint. Terms of speed may then replace dry
    friction, which keeps the prior's value.
    """
    if not prior.typical:
        return fit
    per_unit = np.stack(
        [np.ones_like(load), FAR_AT_SPEED * np.ones_like(load), np.nan_to_num(load)]
    )
    own = [prior.typical[name] for name in ("coulomb", "viscous", "load")]
    mean = (per_unit * [one.mean for one in own]).sum(axis=0)  # of the friction (n,) [Nm]
    std = np.linalg.norm(per_unit * [one.std for one in own], axis=0)

    def remarked(joint: JointFit, load: float, mean: float, std: float) -> JointFit:
        (friction,) = friction_curve(joint, np.array([FAR_AT_SPEED]), load).tolist()
        deviations = (friction - mean) / std
        if abs(deviations) < FAR_DEVIATIONS:
            return joint
        text = (
            f"its friction at {FAR_AT_SPEED:g} rad/s is {number(friction, '.2g')} Nm, "
            f"{number(abs(deviations), '.0f')} standard deviations from the usual "
            f"{number(mean, '.2g')} Nm: which part of it is dry friction is uncertain, and so are "
            "forces at rest; look at brake, gear and payload"
        )
        return replace(joint, remarks=(*joint.remarks, Remark(CauseCode.FAR_FRICTION, text)))

    each = zip(fit.joints, np.nan_to_num(load), mean, std, strict=True)
    return replace(fit, joints=tuple(remarked(*one) for one in each))


def _without_replicates(fit: CurrentFit) -> CurrentFit:
    """Return a fit with one of its bootstrap replicates, sufficient for predictions."""
    kept = [replace(one.estimate, replicates=one.estimate.replicates[:1]) for one in fit.joints]
    joints = zip(fit.joints, kept, strict=True)
    return replace(fit, joints=tuple(replace(one, estimate=own) for one, own in joints))


def require_no_stop_sign(contradictions: Mapping[str, Contradictions]) -> None:
    """Raise ContradictionError if a recording has a stop sign; contradictions: by recording."""
    signs = {name: one.stop_signs[0] for name, one in contradictions.items() if one.stop_signs}
    if signs:
        first = next(iter(signs))
        text = (
            f"recordings to fit on have stop signs ({', '.join(signs)}); of {first}: "
            f"{signs[first].detail}; correct them, or remove them from the study"
        )
        raise ContradictionError(CauseCode.CONTRADICTING_RECORDINGS, text)


def require_single_runs(qualities: Mapping[str, Quality]) -> None:
    """Raise ContradictionError if two recordings are copies of one run, which would count twice.

    qualities: by recording.
    """
    for pair in same_runs({name: one.fingerprint for name, one in qualities.items()}):
        text = (
            f"recordings to fit on are one run: {' and '.join(pair)}; remove one of them from the "
            "study"
        )
        raise ContradictionError(CauseCode.COPIED_RECORDINGS, text)


def accepted_doubts(fit: CurrentFit, prior: Prior, accepted: Mapping[str, str]) -> list[Remark]:
    """Return a remark if torque constants, or gains, are not those of the arm but the study accepts
    it.

    Raises ContradictionError if the study does not accept it.
    """
    try:
        if prior.measured == TORQUE:
            require_gains_of_one(fit)
        else:
            require_known_constants(fit, prior)
    except ContradictionError as sign:
        if sign.remark.kind not in accepted:
            raise
        text = accepted_sign(sign.remark.text, accepted[sign.remark.kind])
        return [Remark(CauseCode.ACCEPTED_STOP_SIGN, text)]
    return []


def require_known_side(arm: Robot) -> None:
    """Raise ContradictionError if the arm's torques may be the motors' or the joints', so that
    nothing can be fitted (`unknown_side`).
    """
    if text := unknown_side(arm):
        raise ContradictionError(CauseCode.UNKNOWN_SIDE, text, "side")


def require_gains_of_one(fit: CurrentFit) -> None:
    """Raise ContradictionError when measured torques have other gains than 1 by the description.

    A single joint, where a spring or a column may be the cause, keeps the gain of 1.
    """
    gains = [joint.contradicted for joint in fit.joints]
    each = [
        _other_gain(joint, gain) for joint, gain in enumerate(gains, start=1) if gain is not None
    ]
    if len(each) > MAX_JOINTS_OF_OTHER_GAIN or any(0 < (gain or 0) < MIN_GAIN for gain in gains):
        text = (
            "the description or the side of the torques is wrong: the gain of a measured torque is "
            f"1, but these would need {', '.join(each)}; look at the side (`effort: motor_torque` "
            "with each `gear_ratio`, or `joint_torque`), at the rotors and at the links"
        )
        raise ContradictionError(CauseCode.CONTRADICTING_GAINS, text, "constants")


def _other_gain(joint: int, gain: float) -> str:
    told = f"{number(gain, '.3g')} Nm/Nm on joint {joint}"
    turned = (
        " (the sign is reversed: write -1 for this joint into a list of all joints under "
        "`units: actual_torque`)"
    )
    return told if gain > 0 else told + turned


def require_known_constants(fit: CurrentFit, prior: Prior) -> None:
    """Raise ContradictionError when fitted torque constants are far from those of the arm.

    Any constant that is too small means a wrong unit, arm or payload. Constants that are too large
    belong to joints with a current that does not follow the torque, which the fit has detected;
    more than MAX_JOINTS_WITHOUT_LOAD of them contradict the arm. Those within their own error are
    ignored.
    """
    makers = (1 / prior.inverse_constant.mean).tolist()
    pairs = zip(fit.joints, makers, strict=True)
    lost = np.array([joint.surely_above(maker) for joint, maker in pairs])
    wrong = too_small(fit, prior)
    if wrong.any() or lost.sum() > MAX_JOINTS_WITHOUT_LOAD:
        wrong |= lost
        found = [joint.contradicted for joint in fit.joints]
        fitted = np.where(lost, np.array(found, dtype=float), torque_constants(fit))
        unit = prior.measured.constant_unit
        each = [
            other_constant(j + 1, fitted[j], makers[j], unit)
            for j in np.flatnonzero(wrong).tolist()
        ]
        text = contradicting_constants(each, prior.measured)
        raise ContradictionError(CauseCode.CONTRADICTING_CONSTANTS, text, "constants")
