"""The file of an arm that `live.py` reads: parameters, and the noise of runs without contact."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ur5lib.errors import InputError, RefusalError, Remark
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import MIN_STOP_DURATION, RELAXATION_TIME
from ur5lib.force.force_input import MEAN_STICTION
from ur5lib.force.gate import quiet_force
from ur5lib.force.residual_model import (
    SHOWN_DURATION,
    USUAL_REST_STD,
    USUAL_RUBBING,
    USUAL_STICTION,
    TorqueStretch,
    fit_residual_model,
)
from ur5lib.records.codes import CauseCode
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.friction import Friction
from ur5lib.records.measured import Measured
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.friction import (
    BASE_TERMS,
    PRESLIDING_DISTANCE,
    ROOT_LINE,
    START_DISTANCE,
    coefficient_names,
)
from ur5lib.robots.inertia import RigidBodies, link_tail, rigid_bodies
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import DEAD_ZONE
from ur5lib.timeseries.trajectories import REST_SPEED
from ur5lib.topics.live.live import STATES, STILL, TERMS, UNMOVED, Live
from ur5lib.topics.live.live_recording import Followed, follow

# Standard deviations of the prior on a contact's force, in units of the typical force.
SIZES = (1 / 3, 1.0, 3.0, 9.0)
ANYWHERE = ContactPlace()
CONSTANTS: dict[str, Any] = {  # docs/live.md lists the data for their choice
    "gain": 35.0,  # 1/s, of the observer
    "rare": 0.2,  # this share of a free arm's samples has `wide` times the noise
    "wide": 2.0,
    "doubt": 1.0,  # factor on the wrench's standard deviation, larger if learnt on few paths
    "duration": 0.05,  # s; evidence must last this long before a contact is stated
    "slows": 0.65,  # a joint stops below this share of its mean speed over `duration`
    "stopping": 0.1,  # s; while one stops, evidence must last this long
    "release": 0.1,  # s; a contact ends when evidence was low for this long
    "hysteresis": 2.0,  # log-odds; the contact then lasts down to the threshold less this
    "freeze": 0.0,  # log-odds; above it, slow errors are not learnt
    "thaw": 0.5,  # s; they are learnt again after this time below `freeze`
    "slow": 100.0,  # s; time constant of slow errors: a push of 10 s keeps 80 % of its force
    "settle": RELAXATION_TIME,  # s; until a start is over, and friction is relaxed after a stop
    "stop": MIN_STOP_DURATION,  # s
    "reversal": 0.5,  # s; a joint counts as reversing for this long after it was slow
    "rest_speed": REST_SPEED,  # rad/s
    # rad; after this motion, friction no longer depends on its history
    "moved": 2 * START_DISTANCE,
    "window": 0.2,  # s; a touched arm's resting joints move within this time
    "confirmed": 0.1,  # s; the arm must rest this long after that move, or else it started to move
    "stays": 0.35,  # s; without a move for this long, such a contact is over
    "large": 1.3,  # typical forces; a larger force without a contact is not reported
    "blind": 4.5,  # typical forces; the arm is blind if the force's standard deviation is larger
    "missed": 2.5,  # standard deviations of what hides contacts, up to which most are missed
    "press": 7.0,  # typical forces; standard deviation of a slow press
    "faster": 3.0,  # nothing is stated beyond this multiple of the speeds in the study
    "least_step": 1e-4,  # s between samples
    "dead_zone": DEAD_ZONE,  # rad/s
    "max_gap": 0.1,  # s; after a longer gap, the run starts anew
    "margin": 4.0,  # samples beyond this multiple of the largest speeds and currents are dropped
    "jump": 0.02,  # rad; a position may jump by this much in addition
    "turns": 100.0,  # rad; samples with larger positions are dropped
    "acceleration": 20.0,  # rad/s²; with `encoder` [rad], the noise of the filter of positions
    "encoder": 5e-5,
}
MIN_LOG_ODDS = 1.6  # least threshold of a contact at the flange
MIN_BEFORE_FLANGE = 2.0  # and of one before it
# A joint at rest that moves more is touched: max(MIN_SHIFT, SHIFTS times a free arm's median).
MIN_SHIFT, SHIFTS = 1.2e-4, 4.0  # rad, 1
MIN_REST = 5.0  # s; least time at rest that determines this median
UNSHIFTED = CONSTANTS["turns"]  # rad; no joint moves that far at rest
RAREST = CONSTANTS["max_gap"] / 2  # s between samples
LEARNING_STEP = 0.008  # s
LONGEST = 300.0  # s; noise is learnt from the start of each recording up to this time
MIN_BREAKAWAY_SHARE = 0.004  # least breakaway torque over a motor's largest torque
MIN_SPEED = 0.1  # rad/s; least value for the largest speed in the study
BANDWIDTH = CONSTANTS["gain"] / (2 * np.pi)  # Hz


@dataclass(frozen=True)
class LiveFit:
    """live.json: what the live estimator learnt of an arm, the result of `learned`, empty without a
    fit; refused: why no force is stated.
    """

    known: dict[str, Any] = field(default_factory=dict)
    refused: Remark | None = None


def numbers(
    robot: Robot,
    friction: Friction,
    recording: str,
    payload: Payload | None,
    place: ContactPlace = ANYWHERE,
    contact_force_n: float | None = None,
) -> dict[str, Any]:
    """Return kinematics, links, rotors, gears and constants of an arm with a payload, and the
    assumptions on contacts.

    robot: as mounted; recording: the fit without its path is used, for "" the fit to all; place: of
    contacts; contact_force_n: of a typical contact [N], None: from the arm's payload. Raises
    InputError if a friction term couples joints.
    """
    arm, joints = robot.carrying(payload), friction.fit_for(recording).joints
    constant = 1 / np.array([joint.estimate.coefficients[0] for joint in joints])
    offset = constant * [joint.estimate.coefficients[1] for joint in joints]
    terms = _friction_terms(robot, friction, recording)
    bodies = rigid_bodies(arm, arm.fullest_model())
    rotor = bodies.rotor_inertia + terms.pop("rotor", 0.0)
    if unknown := sorted(terms.keys() - {*TERMS}):
        raise InputError(
            f"the friction term {unknown[0]} of {robot.name} is unknown to the live estimator; fit "
            "the study without it"
        )
    limits = np.array(arm.torque_limits())
    breakaway = np.maximum(terms["coulomb"], MIN_BREAKAWAY_SHARE * limits)
    for name, part in zip(("coulomb", "viscous"), ROOT_LINE, strict=True):
        terms[name] = terms[name] - part * terms.get("velocity_root", 0.0)  # fitted less its line
    coefficients = {name: values.tolist() for name, values in terms.items()}
    return {
        "links": [*_links(arm, bodies)],
        "gravity": [*arm.gravity],
        "rotor_inertia": rotor.tolist(),
        "torque_constant": constant.tolist(),
        "offset": offset.tolist(),
        "breakaway": breakaway.tolist(),
        "current": (limits / constant).tolist(),
        "friction": {"terms": coefficients, "presliding": _presliding(friction, recording)},
        "contacts": _contacts(ContactPrior.of(robot, contact_force_n, place), place),
    }


def _contacts(prior: ContactPrior, place: ContactPlace) -> dict[str, Any]:
    return {
        "place": [*place.point],
        "lever": prior.lever,
        "typical": prior.force,
        "sizes": [size * prior.force for size in SIZES],
    }


def _friction_terms(robot: Robot, friction: Friction, recording: str) -> dict[str, Array]:
    """Return the coefficients (n,) [Nm, ...] of friction by term, 0 for joints without the term."""
    joints = friction.fit_for(recording).joints
    terms = {name: np.zeros(len(joints)) for name in BASE_TERMS}
    for k, joint in enumerate(joints):
        constant, _, *values = joint.estimate.coefficients.tolist()
        for name, value in zip(coefficient_names(joint.terms), values, strict=True):
            if not name.startswith("balance_") or k + 1 in robot.balanced_joints:
                terms.setdefault(name, np.zeros(len(joints)))[k] = value / constant
    return terms


def _presliding(friction: Friction, recording: str) -> list[dict[str, Any]]:
    """Return for each presliding distance [rad] the share of dry friction in motion that reverses
    over it, and the additional friction at rest, `held` (n,) [Nm].

    h z + Σ h_d (z_d - z) = (h - Σ h_d) z + Σ h_d z_d, see `held_columns`.
    """
    joints = friction.fit_for(recording).joints
    held = {PRESLIDING_DISTANCE: np.zeros(len(joints))}
    for k, joint in enumerate(joints):
        own, *others = (joint.held / joint.estimate.coefficients[0]).tolist()
        held[PRESLIDING_DISTANCE][k] = own - sum(others)
        for distance, value in zip(joint.distances, others, strict=True):
            held.setdefault(distance, np.zeros(len(joints)))[k] += value
    return [
        {
            "distance": distance,
            "share": float(distance == PRESLIDING_DISTANCE),
            "held": own.tolist(),
        }
        for distance, own in held.items()
    ]


def _links(arm: Robot, bodies: RigidBodies) -> Iterator[dict[str, Any]]:
    """Yield each link in the axes of its joint, with the translation to the next joint."""
    for k, pose in enumerate(arm.link_poses()):
        rotation, position = link_tail(pose)
        yield {
            "rotation": rotation.tolist(),
            "position": position.tolist(),
            "mass": float(bodies.mass[k]),
            "center_of_mass": (position + rotation @ bodies.center_of_mass[k]).tolist(),
            "inertia": (rotation @ bodies.inertia[k] @ rotation.T).tolist(),
        }


def learned(
    runs: Sequence[tuple[Mapping[str, Any], Measured]], paths: int, false_per_min: float
) -> dict[str, Any]:
    """Return largest speeds, noise, threshold and constants, learnt from runs without contact.

    runs: `numbers` of the arm by the fit without the run's path, and the measured run; paths: their
    number; false_per_min: allowed alarms [1/min]. Raises RefusalError if runs are too short, are
    sampled too slowly, or a joint never moves.
    """
    period = float(np.median([run.period for _, run in runs]))
    if period > RAREST:
        text = (
            f"samples of the recordings without contact lie {period:.3f} s apart, while the live "
            f"estimator needs one each {RAREST:g} s; record faster"
        )
        raise RefusalError(CauseCode.RARE_SAMPLES_LIVE, text)
    thinned = [(arm, run.at(few_rows(run.period))) for arm, run in runs]
    speeds = [np.nanquantile(np.abs(velocity(run)), 0.999, axis=0) for _, run in thinned]
    breakaway = np.median([arm["breakaway"] for arm, _ in runs], axis=0)
    known = {
        "speed": np.maximum(np.max(speeds, axis=0), MIN_SPEED).tolist(),
        "noise": _noise(np.tile(breakaway, (len(STATES), 1)), breakaway, UNSHIFTED),
        "threshold": {"log_odds": MIN_LOG_ODDS},
        # while noise is learnt, nothing counts as a contact
        "constants": CONSTANTS | {"period": period, "freeze": np.inf, "quiet": [1.0]},
    }
    stretches, jacobians, shifts = [], [], []
    for arm, run in thinned:
        own = follow({**arm, **known}, run)
        started = slice(round(CONSTANTS["settle"] / run.period), None)
        jacobians.append(Live({**arm, **known}).sweep(run.q, 0 * run.q).jacobian[started])
        stretches.append(TorqueStretch(own.torque[started], own.state[started], run.period))
        rests = (own.state == STILL).all(axis=1)
        shifts.append((np.abs(own.shift[rests]).max(axis=1), run.period))
    model = fit_residual_model(stretches, BANDWIDTH, breakaway).with_usual_rest(stretches)
    unmoved = unmoved_std(stretches, breakaway)
    model = replace(model, spread=np.vstack([model.spread, unmoved])).of_few_paths(paths)
    shift = least_shift(shifts)
    known["noise"] = _noise(model.spread, breakaway, shift, model.stiction, model.rubbing)
    variance = np.concatenate([model.variance(model.spread, own.states) for own in stretches])
    quiet = quiet_force(np.concatenate(jacobians), variance)
    known["constants"] = CONSTANTS | {"period": period, "doubt": model.doubt, "quiet": [quiet]}
    followed = [(follow({**arm, **known}, run, limited=True), run.period) for arm, run in thinned]
    threshold = _threshold(followed, false_per_min) | {"before_flange": _before_flange(followed)}
    return known | {"threshold": threshold}


def unmoved_std(stretches: Sequence[TorqueStretch], breakaway: Array) -> Array:
    """Return the standard deviation (n,) [Nm] of joints that have not moved yet; at least the usual
    one at rest if the stretches contain little of this state.
    """
    shown = [own.period * (own.states == UNMOVED) for own in stretches]
    seconds = sum(one.sum(axis=0) for one in shown)
    total = sum(
        (one * own.torque**2).sum(axis=0) for one, own in zip(shown, stretches, strict=True)
    )
    square, usual = total / np.maximum(seconds, 1e-9), (USUAL_REST_STD * breakaway) ** 2
    unshown = SHOWN_DURATION / (SHOWN_DURATION + seconds)
    return np.sqrt(square + unshown * np.maximum(usual - square, 0.0))


def least_shift(shifts: Sequence[tuple[Array, float]]) -> float:
    """Return the threshold [rad] on the move of a resting joint that indicates a contact.

    shifts: largest move of a free arm's joints (N,) [rad], and period [s]. With less than MIN_REST
    of them, the threshold is UNSHIFTED, which no joint reaches.
    """
    if sum(len(own) * period for own, period in shifts) < MIN_REST:
        return UNSHIFTED
    return max(MIN_SHIFT, SHIFTS * float(np.median(np.concatenate([own for own, _ in shifts]))))


def velocity(run: Measured) -> Array:
    """Return q̇ (N, n) [rad/s], measured or by differences of q."""
    return np.gradient(run.q, run.period, axis=0) if run.qd is None else run.qd


def few_rows(period: float) -> slice:
    """Return the rows of a recording's first LONGEST s, thinned to LEARNING_STEP; period: [s]."""
    return slice(0, round(LONGEST / period), max(1, round(LEARNING_STEP / period)))


def _noise(
    std: Array,
    breakaway: Array,
    shift: float,
    stiction: float = USUAL_STICTION,
    rubbing: float = USUAL_RUBBING,
) -> dict[str, Any]:
    """Return by state (6, n) [Nm]: `std` of the noise; `absorbed`, the mean part of a contact's
    torque that dry friction takes up, and `hidden`, the standard deviation of this part, both as in
    `contact_wrench`; and `shift` [rad], the move at rest that indicates a contact.

    stiction, rubbing: largest absorbed torque at rest and in motion, in breakaway torques.
    """
    still = np.arange(len(STATES)) == STILL
    absorbed = np.where(still, MEAN_STICTION * stiction, 0.0)
    hidden = np.where(still, np.sqrt(1 - MEAN_STICTION**2) * stiction, rubbing)
    shares = {"absorbed": absorbed, "hidden": hidden}
    rows = {"std": std} | {name: np.outer(share, breakaway) for name, share in shares.items()}
    return {
        name: {state: own.tolist() for state, own in zip(STATES, values, strict=True)}
        for name, values in rows.items()
    } | {"shift": shift}


def _threshold(followed: Sequence[tuple[Followed, float]], allowed: float) -> dict[str, float]:
    """Return the threshold `log_odds` with at most the allowed alarms [1/min], the remaining rate
    `false_per_min`, and the `minutes` with a decision on contact.
    """
    peaks = sorted(
        float(own.evidence[first:last].max()) for own, _ in followed for first, last in own.alarms()
    )
    minutes = sum(own.known.sum() * period for own, period in followed) / 60
    most = int(allowed * minutes)
    above = np.nextafter(peaks[-most - 1], np.inf) if len(peaks) > most else MIN_LOG_ODDS
    remaining = min(len(peaks), most)
    return {"log_odds": float(above), "false_per_min": remaining / minutes, "minutes": minutes}


def _before_flange(followed: Sequence[tuple[Followed, float]]) -> float:
    """Return the log-odds of a contact before the flange that no run without contact exceeds but in
    an alarm at the flange.
    """
    shown = np.concatenate([own.before_flange[~own.contact] for own, _ in followed])
    return float(max(MIN_BEFORE_FLANGE, np.nextafter(shown.max(initial=-np.inf), np.inf)))
