"""The residual model of the external torque without contact."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import starmap

import numpy as np

from ur5lib.channels import CURRENT, TORQUE
from ur5lib.errors import RefusalError, Remark
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import (
    RELAXATION_TIME,
    JointState,
    finite_rows,
    is_still,
)
from ur5lib.force.force_input import ForceInput, inputs
from ur5lib.force.hidden_contacts import Fitted, hidden_contacts, without
from ur5lib.force.residual_model import (
    MIN_RENEWAL_RATE,
    ResidualModel,
    Residuals,
    TorqueStretch,
    fit_residual_model,
)
from ur5lib.identification.currents import breakaway_torque, constants_band, torque_constants
from ur5lib.identification.samples import MIN_PATHS
from ur5lib.records.codes import CauseCode
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.motion import Motion
from ur5lib.records.phrases import as_written, numbered
from ur5lib.records.premises import MARGIN
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import Span, unbroken, within

MIN_REST_DURATION = 10.0  # s; a shorter rest does not determine friction at rest
# Usual error along an unseen path, by joint state, relative to Coulomb friction: in motion the
# median of joints of four arms; at rest the RMS of the joints of a UR5 (0.77, 1.02, 0.76) and a
# UR10e (0.31, 0.40, 0.36) fitted to one recording. The second are the fast part of this error: at
# rest the median of their joints (0.4, 0.15); in motion less than theirs (0.55 to 0.8), since a
# wrong level of friction changes slowly.
ERRORS_AT_USUAL_SPEED = np.array([0.13, 0.13, 0.6, 0.75, 0.6])
ERRORS_IN_FAST_MOTION = np.array([0.5, 0.5, 0.5, 0.4, 0.15])
# An arm usually has this speed [rad/s], and this load in Coulomb friction.
USUAL_SPEED, USUAL_LOAD = 0.5, 3.0  # rad/s
CONTACT_ROUNDS = 4  # at most so often, contacts are sought in the recordings to fit on
# Standard deviation of joints in motion over that by medians, mean of the joints: 1.0 to 1.14 on
# five real arms, up to 1.33 on the stand but for two studies, 1.5 to 5.5 with pushes in the fits.
HEAVY_TAILS = 1.4
FORCE_DIRECTIONS = 3  # a force needs a finite torque on this many joints, or on all


@step("arm", "residuals.json", recordings="fit", arm="described")
def fit_residuals(
    friction: Friction,
    currents: Mapping[str, Currents],
    motion: Mapping[str, Motion],
    kinematics: Mapping[str, Kinematics],
    arm: Robot,
    contact_force_n: float | None,
    cutoff_hz: float,
) -> Residuals:
    """Return the residual model of the external torque without contact; empty without a fit.

    currents, motion, kinematics: of the arm's `fit` recordings; contact_force_n: of a typical
    contact [N], None: by the arm's payload; cutoff_hz: of the currents. Contacts that hide in these
    recordings are left out.
    """
    if friction.from_:
        touched = friction.touched
        currents = {name: untouched(one, touched.get(name, [])) for name, one in currents.items()}
        recordings = [(currents[name], motion[name]) for name in currents]
        found = residual_models(recordings, friction, cutoff_hz)
        runs = {
            name: Fitted(one, kinematics[name])
            for name in currents
            for one in inputs([(currents[name], motion[name])], cutoff_hz)
        }
        prior = ContactPrior.of(arm, contact_force_n, ContactPlace())
        found = without_contacts(found, runs, prior, friction, cutoff_hz)
        every = {name: [*touched.get(name, []), *found.contacts.get(name, [])] for name in currents}
        return replace(found, contacts={name: own for name, own in every.items() if own})
    return usual_residuals(friction.fit, cutoff_hz) if friction.fit.joints else Residuals()


def untouched(currents: Currents, contacts: Sequence[tuple[float, float]]) -> Currents:
    """Return currents with an unknown external torque in contacts, from and to [s]."""
    if currents.external_torque is None or not contacts:
        return currents
    touched = within(currents.time, contacts, MARGIN)
    torque = np.where(touched[:, None], np.nan, currents.external_torque)
    return replace(currents, external_torque=torque)


def residual_models(
    recordings: Sequence[tuple[Currents, Motion]], friction: Friction, cutoff: float
) -> Residuals:
    """Return the residual model, or the reason why there is none.

    recordings: to fit, without contact, predicted by fits without their own path; cutoff: of the
    torques [Hz]. If they show too little, the errors are those of other arms.
    """
    if friction.explained is not None:
        unknown = np.flatnonzero(~(friction.explained > 0)) + 1
        if len(friction.explained) - len(unknown) < min(FORCE_DIRECTIONS, len(friction.explained)):
            return Residuals(refused=_unknown_torques(unknown.tolist()))
    try:
        model = _residual_model(inputs(recordings, cutoff), friction, cutoff)
    except RefusalError as refusal:
        if friction.measured == CURRENT:
            return replace(usual_residuals(friction.fit, cutoff), remarks=(refusal.remark,))
        return Residuals(refused=refusal.remark)
    return Residuals(model, remarks=tuple(_remarks(friction.paths, recordings, cutoff)))


def without_contacts(
    found: Residuals,
    runs: Mapping[str, Fitted],
    prior: ContactPrior,
    friction: Friction,
    cutoff: float,
) -> Residuals:
    """Return the residual model fitted again without the contacts that it finds in its own
    recordings, until it finds no other; cutoff: of the torques [Hz].

    Where errors have heavy tails, contacts are sought by medians, and taken if they explain these.
    """
    if found.tau_ext is None or found.tau_ext.usual:
        return found
    about = found.tau_ext, runs, prior, friction, cutoff
    try:
        model, contacts, is_heavy = _without(*about, HEAVY_TAILS)
        if is_heavy:  # as of wrong friction
            model, contacts, _ = _without(*about, np.inf)
    except RefusalError:  # too little is left without them
        return found
    times = {name: _times(own, runs[name].kinematics.time) for name, own in contacts.items() if own}
    remarks = (*found.remarks, *starmap(_hidden, times.items()))
    return replace(found, tau_ext=model, remarks=remarks, contacts=times)


def _without(
    model: ResidualModel,
    runs: Mapping[str, Fitted],
    prior: ContactPrior,
    friction: Friction,
    cutoff: float,
    heavy: float,
) -> tuple[ResidualModel, dict[str, list[Span]], bool]:
    """Return the model without contacts, these, and whether tails stay heavier than `heavy`."""
    contacts, free, is_heavy = dict[str, list[Span]](), [one.input for one in runs.values()], False
    for _ in range(CONTACT_ROUNDS):
        before, typical = contacts, _residual_model(free, friction, cutoff, by_medians=True)
        is_heavy = bool((model.spread / typical.spread)[JointState.MOVING].mean() > heavy)
        seeking = typical if is_heavy else model
        contacts = {name: hidden_contacts(one, seeking, prior) for name, one in runs.items()}
        if contacts == before or not any(contacts.values()):
            break
        free = [without(one.input, contacts[name]) for name, one in runs.items()]
        model = _residual_model(free, friction, cutoff)
    return model, contacts, is_heavy


def _times(contacts: Sequence[Span], time: Array) -> list[tuple[float, float]]:
    """Return from and to [s] of spans, since the first sample."""
    return [
        (float(time[first] - time[0]), float(time[last - 1] - time[0])) for first, last in contacts
    ]


def _hidden(name: str, contacts: Sequence[tuple[float, float]]) -> Remark:
    at = as_written([start for start, _ in contacts], ".1f")
    alarms = "an alarm" if len(contacts) == 1 else "alarms"
    text = (
        f"“{name}” has {alarms} at {at} s, counted as false: these spans are left out of errors "
        "of a free arm and of the threshold of alarms, but not of its friction; if something "
        "touched the arm there, cut them off by `from_s` and `to_s`, or give the recording the "
        "role contact"
    )
    return Remark(CauseCode.HIDDEN_CONTACT, text)


def _unknown_torques(joints: Sequence[int]) -> Remark:
    text = (
        f"fits to other paths predict {numbered(joints)} worse than a constant, or nothing tests "
        "them, so that the torque of a contact is unknown; record contact-free motions along "
        "several paths"
    )
    return Remark(CauseCode.UNKNOWN_TORQUES, text)


def usual_model(fit: CurrentFit, cutoff: float) -> ResidualModel:
    """Return the residual model with errors that are usual for arms; cutoff: of the torques [Hz].

    The errors are ERRORS_AT_USUAL_SPEED and, at a usual speed and load, those of coefficients that
    no motion confirmed.
    """
    coulomb, constant = breakaway_torque(fit), torque_constants(fit)
    load = USUAL_LOAD * coulomb  # Nm
    ones = np.ones_like(load)
    columns = np.stack([load, ones, ones, USUAL_SPEED * ones, load], axis=1)  # of BASE
    base = slice(columns.shape[1])
    doubts = np.stack(
        [np.zeros((5, 5)) if own.doubt is None else own.doubt[base, base] for own in fit.joints]
    )
    doubted = constant * np.sqrt(np.einsum("jp,jpq,jq->j", columns, doubts, columns))
    spread = np.hypot(doubted, ERRORS_AT_USUAL_SPEED[:, None] * coulomb)
    return ResidualModel(
        spread=spread,
        change=ERRORS_IN_FAST_MOTION[:, None] * spread,
        rate=np.array(
            [
                MIN_RENEWAL_RATE,
                MIN_RENEWAL_RATE,
                1 / RELAXATION_TIME,
                1 / RELAXATION_TIME,
                MIN_RENEWAL_RATE,
            ]
        ),
        independent=1 / (2 * cutoff),
        breakaway=coulomb,
        constants_doubt=constants_band(fit),
    )


def usual_residuals(fit: CurrentFit, cutoff: float) -> Residuals:
    """Return the residual model without contact-free recordings; cutoff: of the torques [Hz]."""
    model = usual_model(fit, cutoff).of_few_paths(MIN_PATHS)
    return Residuals(tau_ext=replace(model, usual=True))


def _remarks(
    paths: int, recordings: Sequence[tuple[Currents, Motion]], cutoff: float
) -> Iterator[Remark]:
    """Yield a remark if all recordings follow one path, and if the arm rests too little to
    determine errors at rest.
    """
    if paths == 1:
        text = (
            "all fit recordings follow one path, which does not show how the torque varies between "
            "paths, so that nothing tests the bands; record another path"
        )
        yield Remark(CauseCode.ONE_PATH_OF_ALL, text)
    if paths < MIN_PATHS:
        runs = inputs(recordings, cutoff)
        still = [is_still(one.states) & finite_rows(one.torque) for one in runs]
        rest = sum(float(own.sum() * one.period) for own, one in zip(still, runs, strict=True))
        if rest < MIN_REST_DURATION:
            text = (
                f"the arm rests for {rest:.0f} s of the fit recordings only, so that pushes at "
                "rest may remain unnoticed; record half a minute at rest, in several poses"
            )
            yield Remark(CauseCode.LITTLE_REST, text)


def _residual_model(
    runs: Sequence[ForceInput], friction: Friction, cutoff: float, by_medians: bool = False
) -> ResidualModel:
    """Return the residual model of some runs; where these have too few paths, other arms' errors
    contribute; by_medians: as of `fit_residual_model`.
    """
    stretches = [
        TorqueStretch(one.torque[rows], one.states[rows], one.period)
        for one in runs
        for rows in unbroken(one.segment)
    ]
    fit, sensed = friction.fit, friction.measured == TORQUE
    model = fit_residual_model(stretches, cutoff, breakaway_torque(fit), by_medians)
    model = model.with_usual_rest(stretches)
    # the errors of other arms are those of motor currents
    missing = 0 if sensed else max(0, MIN_PATHS - friction.paths)
    if missing:
        model = model.at_least(usual_model(fit, cutoff), missing / MIN_PATHS)
    model = model.of_few_paths(friction.paths + missing)
    return replace(model, constants_doubt=constants_band(fit), sensed=sensed)
