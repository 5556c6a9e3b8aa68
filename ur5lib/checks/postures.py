"""Checks of postures at rest: only gravity shows arm, order, units and signs."""

from collections.abc import Container, Iterator, Sequence
from itertools import combinations

import numpy as np
import pandas as pd

from ur5lib.channels import EFFORT_CHANNELS, Effort
from ur5lib.checks.arm import MIN_LEAD_OF_ARM, gains_of_arms, of_measured
from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.checked import MIN_BLOCKS, arms_alike
from ur5lib.checks.currents import MAX_CONSTANT_RATIO, foreign_currents
from ur5lib.checks.readings import exchanged_order, in_order, readings
from ur5lib.checks.torques import foreign_torque
from ur5lib.records.accepted import up_to_first_standing
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.phrases import number, numbered
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Payload, Robot
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

# A difference of log-likelihoods of two exchanged joints. It is at most 46 in recordings of a few
# postures.
MIN_LEAD_OF_EXCHANGED_JOINTS = 60.0
# Another arm leads by this many standard errors over these parts of the postures.
PARTS, MIN_ERRORS_OF_ARM = 10, 2.5
BEARING_JOINTS = 3  # joints from the base that bear others in every posture
MIN_ERRORS_OF_CORRELATION = 5.0  # gravity shows in a current by this many standard errors
# Friction is small compared with gravity of this standard deviation, over the largest torque.
MIN_GRAVITY_SHARE = 0.1
# A torque constant that contradicts the documented one has a smaller relative error.
MAX_CONSTANT_ERROR = 0.1
# The static friction of a joint is 0.04 to 0.06 of the motor's largest torque on the measured arms.
STATIC_FRICTION_SHARE = 0.06
# Share of such a current's variance that may be left. Friction leaves 0.1.
MAX_VARIANCE_UNEXPLAINED = 0.3


def posture_means(postures: pd.DataFrame) -> BlockMeans:
    """Return postures as blocks without motion; their efforts may have an offset, by friction at
    rest.
    """
    q = channel(postures, "actual_q")
    moment = channel(postures, "target_moment") if "target_moment_0" in postures else None
    currents = {
        name: channel(postures, name) for name in EFFORT_CHANNELS if f"{name}_0" in postures
    }
    still = np.zeros_like(q)
    return BlockMeans(q, still, still, moment, currents, offset=True, independent=1.0)


def posture_stop_signs(
    means: BlockMeans,
    arm: Robot,
    configured: Payload | None,
    declared: Payload | None,
    accepted: Container[str] = (),
) -> list[Finding]:
    """Return the stop signs of a recording of postures up to the first that is not accepted.

    arm: under the recording's gravity; configured: the payload that the controller was given;
    declared: the one that the study gives; accepted: kinds of stop signs.
    """
    contradictions = _contradictions(means, arm, configured, declared)
    return [*up_to_first_standing(contradictions, accepted)]


def _contradictions(
    means: BlockMeans, arm: Robot, configured: Payload | None, declared: Payload | None
) -> Iterator[Finding]:
    """Yield what contradicts the arm and what it carries, the strongest evidence first."""
    if len(means.q) < MIN_BLOCKS:
        return
    loaded = arm.carrying(declared)
    yield from foreign_torque(means, arm, [configured, declared])
    # of a smaller correlation, friction may be the cause
    turned = _correlation(means, loaded) < -np.sqrt(MAX_VARIANCE_UNEXPLAINED)
    for joint in np.flatnonzero(turned).tolist():
        detail = (
            f"the sign of the {means.measured.quantity} of joint {joint + 1} is reversed: it would "
            "drive the joint with gravity; correct the column, or `directions`"
        )
        yield contradiction(CauseCode.TURNED_CURRENT_AT_REST, "sign", detail)
    yield from foreign_currents(means, loaded)
    yield from _exchanged_joints(means, loaded)
    yield from _unexplained(means, loaded)
    yield from _foreign_arm(means, loaded, arms_alike(arm, declared))
    small = [one for smaller, one in _unlike_constants(means, loaded) if smaller]
    if small:
        detail = contradicting_constants(small, means.measured)
        yield contradiction(CauseCode.CONTRADICTING_CONSTANTS, "constants", detail)


def _exchanged_joints(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find the two joints, among those that bear others, with which exchanged gravity explains the
    currents far better.
    """
    in_place, measured = in_order(arm), of_measured(means)
    pairs = [*combinations(in_place[:BEARING_JOINTS], 2)]
    orders = [in_place, *(exchanged_order(in_place, *pair) for pair in pairs)]
    scores = {one.order: one.score for one in readings(measured, [arm], orders)}
    best = max(pairs, key=lambda pair: scores[exchanged_order(in_place, *pair)])
    gain = scores[exchanged_order(in_place, *best)] - scores[in_place]
    if gain > MIN_LEAD_OF_EXCHANGED_JOINTS:
        detail = (
            f"joints {best[0] + 1} and {best[1] + 1} are exchanged: gravity explains the "
            f"{means.measured.quantity}s far better with their columns swapped; correct the columns"
        )
        yield contradiction(CauseCode.EXCHANGED_JOINTS_AT_REST, "order", detail)


def _foreign_arm(means: BlockMeans, arm: Robot, others: Sequence[Robot]) -> Iterator[Finding]:
    """Find another arm with gravity that explains the currents far better; others: with their
    loads.
    """
    if best := _likelier_arm(means, arm, others):
        detail = (
            f"the {means.measured.quantity}s are not those of {arm.name}: the gravity of `robot: "
            f"{best}` explains them far better; correct `robot`, or columns and units"
        )
        yield contradiction(CauseCode.OTHER_ARMS_CURRENTS_AT_REST, "robot", detail)


def _likelier_arm(means: BlockMeans, arm: Robot, others: Sequence[Robot]) -> str | None:
    """Return the name of the arm that is likelier by far, also in standard errors (jackknife over
    parts of the postures); None if there is none.
    """
    measured = of_measured(means)
    gains = gains_of_arms(measured, arm, others)
    best = max(others, key=lambda one: gains[one.name], default=arm)
    gain = gains.get(best.name, 0.0)
    if gain <= MIN_LEAD_OF_ARM:
        return None
    part = np.arange(len(means.q)) * PARTS // len(means.q)
    left = [measured.part(np.flatnonzero(part != own)) for own in range(PARTS)]
    spread = np.std([gains_of_arms(own, arm, [best])[best.name] for own in left])
    return best.name if gain > MIN_ERRORS_OF_ARM * np.sqrt(PARTS - 1) * spread else None


def what_gravity_shows(means: BlockMeans, arm: Robot, payload: Payload | None) -> list[Finding]:
    """Return the note on what a recording of postures shows, and what it leaves unchecked.

    payload: on the arm's flange.
    """
    correlation, measured = _correlation(means, arm.carrying(payload)), means.measured
    shown = np.flatnonzero(np.isfinite(correlation)).tolist()
    others = np.flatnonzero(np.isnan(correlation)) + 1
    if len(means.q) < MIN_BLOCKS:
        told = "too few to check arm, units and the joints' order, for which 30 are needed"
    elif not shown:
        told = (
            f"gravity explains no {measured.quantity}, so that nothing can be checked and no "
            f"{measured.constant} be determined; record postures in which gravity on the joints "
            "differs"
        )
    else:
        shares = ", ".join(f"joint {j + 1}: {correlation[j] ** 2:.0%}" for j in shown)
        hidden = f"; {numbered(others)}, on which gravity hardly shows" if len(others) else ""
        told = (
            f"of the variance of the {measured.quantity}s, gravity explains {shares}; could not be "
            f"checked: friction, velocities, delays{hidden}{_alike_in_words(means, arm, payload)}"
        )
    detail = f"postures at rest, without time: {told}"
    return [Finding("robot", Found.POSTURES, "note", len(means.q), detail)]


def _alike_in_words(means: BlockMeans, arm: Robot, payload: Payload | None) -> str:
    alike = ", ".join(_arms_alike(means, arm, payload))
    return f"; whether the arm is one of {alike}, whose gravity is alike" if alike else ""


def large_constants(means: BlockMeans, arm: Robot) -> list[Finding]:
    """Return a warning of torque constants far above the documented ones; arm: with what it
    carries."""
    each = [one for smaller, one in _unlike_constants(means, arm) if not smaller]
    detail = (
        f"gravity gives {means.measured.constant}s far above the known ones ({', '.join(each)}): "
        f"the {means.measured.quantity} lacks torque, or `robot`, `payload`, columns or units are "
        "wrong"
    )
    return [Finding("robot", Found.TORQUE_CONSTANTS, "warning", len(each), detail)] if each else []


def _arms_alike(means: BlockMeans, arm: Robot, payload: Payload | None) -> list[str]:
    """Return the names of the other described arms with gravity that explains the currents almost
    as well, without the arm that does so far better.
    """
    loaded, others = arm.carrying(payload), arms_alike(arm, payload)
    gains = gains_of_arms(of_measured(means), loaded, others)
    alike = (name for name, gain in gains.items() if -MIN_LEAD_OF_ARM < gain != 0.0)
    known = arm.name, _likelier_arm(means, loaded, others)
    return [name for name in alike if name not in known]


def _correlation(means: BlockMeans, arm: Robot) -> Array:
    """Return the correlation (n,) of each current with gravity, NaN where it may be by chance."""
    pairs = zip(means.gravity(arm).T, means.effort.T, strict=True)
    correlation = np.array([_pair_correlation(*pair) for pair in pairs])
    error = np.sqrt((1 - correlation**2) / max(1, len(means.q) - 2))
    return np.where(np.abs(correlation) > MIN_ERRORS_OF_CORRELATION * error, correlation, np.nan)


def _pair_correlation(torque: Array, current: Array) -> float:
    """Return the correlation of a current with a torque (M,); zero where one is constant."""
    sizes = torque.std() * current.std()
    if sizes < 1e-9:
        return 0.0
    return float(np.mean((torque - torque.mean()) * (current - current.mean())) / sizes)


def _unexplained(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find a current that gravity does not explain, although the joint bears much of it."""
    heavy = means.gravity(arm).std(axis=0) / np.array(arm.torque_limits())
    joint = int(np.argmax(heavy))
    share = np.nan_to_num(_correlation(means, arm)[joint]) ** 2
    if heavy[joint] > MIN_GRAVITY_SHARE and share < 1 - MAX_VARIANCE_UNEXPLAINED:
        detail = (
            f"gravity explains {share:.0%} of the variance of the {means.measured.quantity} of "
            f"joint {joint + 1}, which should hold little else; correct `robot`, `gravity`, "
            "`payload`, or columns and units"
        )
        yield contradiction(CauseCode.GRAVITY_UNEXPLAINED, "robot", detail)


def _unlike_constants(means: BlockMeans, arm: Robot) -> Iterator[tuple[bool, str]]:
    """Yield, for each joint with a torque constant by gravity far from the documented one, whether
    it is smaller, and the joint with both constants in words.

    Lost torque cannot explain a smaller one: a unit, the arm or its load is wrong. A joint is not
    judged where friction may carry as much as gravity pulls: how its postures were reached changes
    the constant more than the documented ones differ. arm: with what it carries.
    """
    if len(means.q) < MIN_BLOCKS:
        return
    torque, current = means.gravity(arm), means.effort
    correlation, makers = _correlation(means, arm), np.array(arm.family_torque_constants())
    bears = torque.std(axis=0) > STATIC_FRICTION_SHARE * np.array(arm.torque_limits())
    for joint in np.flatnonzero(bears & np.isfinite(correlation * makers)).tolist():
        share = correlation[joint] ** 2
        error = np.sqrt((1 - share) / share / (len(torque) - 2))
        slope = correlation[joint] * current[:, joint].std() / torque[:, joint].std()
        ratio = 1 / slope / makers[joint]
        if error < MAX_CONSTANT_ERROR and not 1 / MAX_CONSTANT_RATIO < ratio < MAX_CONSTANT_RATIO:
            unit = means.measured.constant_unit
            yield ratio < 1, other_constant(joint + 1, 1 / slope, makers[joint], unit)


def other_constant(joint: int, fitted: float, known: float, unit: str) -> str:
    """Return in words a joint, from 1, with its constant and the documented one that it
    contradicts.
    """
    return f"joint {joint} with {number(fitted, '.3g')} instead of {number(known, '.3g')} {unit}"


def contradicting_constants(each: Sequence[str], measured: Effort) -> str:
    """Return the sentence of the stop sign of constants; each: as returned by `other_constant`."""
    return (
        f"{measured.constant}s contradict the known values ({', '.join(each)}); correct `robot`, "
        "`payload`, or columns and units"
    )
