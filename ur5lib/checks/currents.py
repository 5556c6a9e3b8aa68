"""Checks of measured currents: their unit, their joints' motion, and loads that nothing declares.

Each joint's current is explained by the dry and viscous friction of its own motion, by gravity or
the controller's target, and by inertia. Friction brakes, so that its coefficients have a sign. How
much of the current is left, and how it changes from frame to frame, distinguishes exchanged columns
and delayed ones from right ones; friction distinguishes turned ones.
"""

from collections.abc import Container, Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.channels import CURRENT, MEASURED_CURRENT, TARGET_CURRENT, TORQUE, Effort
from ur5lib.checks.block_means import BlockMeans, combination, fitted_load, size
from ur5lib.checks.channels import MIN_MOVING_SPEED
from ur5lib.checks.delays import CURRENT_NOISE, Delays, delays_by_motion
from ur5lib.checks.innovations import innovation_likelihoods
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_columns, load_torque
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Mask

# A difference of log-likelihoods, of two joints before all others. In right recordings, it is at
# most 5.
MIN_LEAD_OF_EXCHANGE = 60.0
MIN_GEAR_RATIO = 20.0  # below it, friction may be less than what links leave unexplained
# Nm; a joint with less gravity torque does not show the unit of its current
MIN_GRAVITY_TORQUE = 3.0
MIN_CONSTANT, MAX_CONSTANT = 2.5, 40.0  # Nm/A; the torque constants of common arms lie between
# It is the largest ratio to the maker's torque constant, or its inverse. Beyond all errors, right
# recordings need a factor of 1.51, without the worst arm 1.34.
MAX_CONSTANT_RATIO = 1.75
MAX_NAMED_RATIO = 10.0  # of a constant to the known one; a larger one shows that none is
MILLIAMPERE_CODES = (CauseCode.CURRENT_IN_MA, CauseCode.CURRENT_NOT_IN_MA)
CONSTANTS_OF_UNITS = {  # Nm per “A” of what is no current in A, by the cause
    CauseCode.TORQUE_AS_CURRENT: (0.5, 2.0),
    CauseCode.CURRENT_IN_MA: (1e-3 * MIN_CONSTANT, 1e-3 * MAX_CONSTANT),
    CauseCode.CURRENT_NOT_IN_MA: (1e3 * MIN_CONSTANT, 1e3 * MAX_CONSTANT),
    CauseCode.OPPOSITE_CURRENT: (-MAX_CONSTANT, -MIN_CONSTANT),
}
MIN_STANDARD_ERRORS = 5.0  # standard errors that are no chance
# Gravity, friction and inertia may leave this share of a current's square.
MAX_SHARE_UNEXPLAINED = 0.5
MIN_UNDECLARED_LOAD = 1.0  # kg; right recordings show up to 0.3 kg, all of it friction
MIN_MOVING_BLOCKS = 30  # blocks of a joint in motion that show a load
# Such a load explains at least this share of the difference of the currents.
MIN_SHARE_EXPLAINED_BY_LOAD = 0.2


class Answers(NamedTuple):
    """Log-likelihoods of the measured currents by the joints' motions.

    delays: of all currents, by their delay; of_joints: (6, 6), row j: of the current of joint j,
    column k: by the motion of joint k.
    """

    delays: Delays
    of_joints: Array

    def ahead(self) -> Array:
        """Return by how much the log-likelihood of each current (row) by each joint's motion
        (column) exceeds that by the best of the other joints, (6, 6).
        """
        return np.array(
            [[own[k] - np.delete(own, k).max() for k in range(len(own))] for own in self.of_joints]
        )

    def of_exchanges(self) -> Array:
        """Return the log-likelihood that the currents of two joints are exchanged beyond that by
        the best of the other joints, (6, 6): negative where it speaks against this.
        """
        ahead = self.ahead()
        return np.asarray(ahead + ahead.T)


def answers(
    robot: pd.DataFrame, means: BlockMeans, arm: Robot, step: float, cutoff: float
) -> Answers:
    """Return the log-likelihoods of the measured currents by the joints' motions.

    robot: a repaired table; means: over its blocks; arm: with what it carries; step: [s]; cutoff:
    of the currents' low-pass [Hz].
    """
    by_motion = delays_by_motion(robot, arm, step, cutoff)
    lags = np.rint(by_motion.seconds / step).astype(np.int64)
    likelihoods = innovation_likelihoods(robot, step, lags)
    delays = by_motion.given(np.einsum("ljj->jl", likelihoods))
    variance = _unexplained_squares(means, arm) + CURRENT_NOISE**2
    of_joints = likelihoods[len(lags) // 2] + means.log_likelihood(variance)
    return Answers(delays, of_joints)


def is_driven(robot: pd.DataFrame) -> bool:
    """Return whether a target velocity is to move a joint; True if targets were not recorded.
    Friction does not brake a joint that a contact moves.
    """
    if "target_qd_0" not in robot:
        return True
    return bool((np.nanmean(channel(robot, "target_qd") ** 2, axis=0) > MIN_MOVING_SPEED**2).any())


def moving_joints(means: BlockMeans) -> Mask:
    """Return which joints (6,) move."""
    return np.asarray(np.sqrt((means.qd**2).mean(axis=0)) > MIN_MOVING_SPEED)


def exchanged_currents(answers: Answers) -> Iterator[Finding]:
    """Find two joints, each of which explains the other's current better than all others do."""
    gains = np.triu(answers.of_exchanges(), 1)
    j, k = np.argwhere(gains == gains.max())[0].tolist()
    if gains[j, k] > MIN_LEAD_OF_EXCHANGE:
        yield exchanged_efforts((j, k), CURRENT)


def exchanged_efforts(pair: tuple[int, int], measured: Effort) -> Finding:
    """Return the stop sign of two joints, from 0, with exchanged efforts."""
    detail = (
        f"the {measured.quantity}s of joints {pair[0] + 1} and {pair[1] + 1} are exchanged: each "
        f"follows the motion of the other joint; correct the columns of {measured.channel}"
    )
    return contradiction(CauseCode.EXCHANGED_CURRENTS, "order", detail, [pair[0] + 1, pair[1] + 1])


def rubbing_joints(arm: Robot) -> Mask:
    """Return which joints (n,) have friction that the efforts show: all by currents, by torques
    those with a gear of at least MIN_GEAR_RATIO.
    """
    return (np.array(arm.gear_ratios()) >= MIN_GEAR_RATIO) | (arm.measured == CURRENT)


def follows_its_model(means: BlockMeans, arm: Robot) -> bool:
    """Return whether, on most moving joints, gravity, friction and inertia explain the measured
    currents better than their targets; True if no joint moves.

    A controller computes its targets from such a model, whatever has smoothed a measurement.
    """
    moving = np.flatnonzero(moving_joints(means)).tolist() if len(means.q) else []
    gravity, rest = gravity_columns(arm, means.q), [means.qdd, np.ones((len(means.q), 1))]
    closer = []
    for joint in moving:
        basis, _ = np.linalg.qr(np.column_stack([means.friction(joint), gravity[joint], *rest]))
        both = (means.currents[name][:, joint] for name in (MEASURED_CURRENT, TARGET_CURRENT))
        measured, target = (size(current - basis @ (basis.T @ current)) for current in both)
        closer.append(measured < target)
    return not closer or float(np.mean(closer)) > 0.5


def _unexplained_squares(means: BlockMeans, arm: Robot) -> Array:
    """Return the mean squares (6, 6) of each current that the motion of each joint does not
    explain.

    Row j: the current of joint j; column k: the motion and the target of joint k.
    """
    targets = means.currents.get("target_current")
    expected = means.gravity(arm) if targets is None else targets
    current = means.effort
    joints = range(current.shape[1])
    explained = [_columns(means, expected[:, k], k, targets is None) for k in joints]
    return np.stack([least_squares_left(*columns, current) for columns in explained], axis=1)


def _columns(means: BlockMeans, expected: Array, joint: int, inertia: bool) -> tuple[Array, Array]:
    """Return the regression columns of a current with coefficients that are not negative, (M, k),
    and those with coefficients of either sign.
    """
    free = np.column_stack([means.qdd[:, joint]] * inertia + [np.ones(len(expected))])
    return np.column_stack([means.friction(joint), expected]), free


def least_squares_left(positive: Array, free: Array, values: Array) -> Array:
    """Return the least mean squares (n,) that columns leave of values (M, n).

    positive: (M, k), whose coefficients are not negative; free: (M, m). The best coefficients are
    those without bounds on some of the columns, so that all selections are tried: k is small, and
    scipy's optimizers take longer to load than all checks.
    """
    left = np.full(values.shape[1], np.inf)
    for chosen in product((False, True), repeat=positive.shape[1]):
        columns = np.column_stack([positive[:, chosen], free])
        found, *_ = np.linalg.lstsq(columns, values)
        allowed = (found[: sum(chosen)] >= 0).all(axis=0)
        squares = ((values - columns @ found) ** 2).mean(axis=0)
        left = np.where(allowed, np.minimum(left, squares), left)
    return left


class Held(NamedTuple):
    """The part of a current that balances gravity: current per torque of gravity [A/Nm], its
    standard error, and the share of the current's square that is left unexplained.
    """

    slope: float
    error: float
    unexplained: float


def foreign_currents(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find efforts in another unit than A: they are too large or too small to balance gravity.

    arm: with what it carries.
    """
    if arm.measured == TORQUE:
        return
    gravity = means.gravity(arm)
    joint = int(np.argmax((gravity**2).mean(axis=0)))
    if np.sqrt((gravity[:, joint] ** 2).mean()) < MIN_GRAVITY_TORQUE:
        return
    least, most = possible_constants(arm, joint)
    for name, current in means.currents.items():
        held = held_gravity(means, gravity, current, joint)
        away = MIN_STANDARD_ERRORS * held.error
        if held.unexplained < MAX_SHARE_UNEXPLAINED and not (
            held.slope + away > 1 / most and held.slope - away < 1 / least
        ):
            constant = 1 / (held.slope or 1e-9)
            shown = CONSTANTS_OF_UNITS if abs(held.slope) > away else {}
            causes = (c for c, (low, high) in shown.items() if low <= constant <= high)
            cause = next(causes, CauseCode.NO_CURRENT)
            motors = f"motors have {number(least, '.3g')} to {number(most, '.3g')} Nm/A"
            detail = _unit_in_words(cause, name, joint, number(constant, ".3g"), motors)
            if cause == CauseCode.NO_CURRENT and abs(constant) > MAX_NAMED_RATIO * most:
                detail = unheld(name, joint)
            yield contradiction(cause, "unit", detail, [joint + 1])


def possible_constants(arm: Robot, joint: int) -> tuple[float, float]:
    """Return the torque constants [Nm/A] between which that of a joint lies: those of common arms,
    or that of the arm's description, where this is beyond; joint: from 0.
    """
    described = arm.maker_torque_constants()[joint]
    least = np.fmin(MIN_CONSTANT, described / MAX_CONSTANT_RATIO)
    return float(least), float(np.fmax(MAX_CONSTANT, described * MAX_CONSTANT_RATIO))


def _unit_in_words(cause: CauseCode, name: str, joint: int, constant: str, motors: str) -> str:
    """Return the sentence on the unit of a channel; cause: of the stop sign; constant: what gravity
    shows [Nm/A]; motors: what motors have, in words.
    """
    holds = f"gravity's torque on joint {joint + 1} is {constant} Nm per A of"
    if cause == CauseCode.TORQUE_AS_CURRENT:
        return (
            f"{name} is a torque in Nm, not a current in A ({holds} {name}); record currents, and "
            "name this column actual_current_as_torque"
        )
    if cause == CauseCode.CURRENT_IN_MA:
        return (
            f"{name} is in mA, not in A ({holds} {name}); give its unit, `{name}: mA`, under "
            "`units`"
        )
    if cause == CauseCode.CURRENT_NOT_IN_MA:
        return f"{name} is in A, not in mA ({holds} {name} as declared); correct its unit"
    if cause == CauseCode.OPPOSITE_CURRENT:
        return (
            f"{name} has the opposite sign ({holds} it, and {motors}); give its "
            f"unit, `{name}: opposite`, under `units`, or correct `gravity`"
        )
    return f"{holds} {name}, but {motors}; correct its unit or column, or `gravity`"


def unheld(name: str, joint: int) -> str:
    """Return the sentence on efforts of a channel that balance no gravity by any possible constant;
    joint: from 0.
    """
    return (
        f"{name} of joint {joint + 1} does not balance gravity there: something carries the arm; "
        "or correct `robot`, `gravity`, the links, or the columns"
    )


def undeclared_load(
    means: BlockMeans, arm: Robot, carrying: Robot, odd: Container[int] = ()
) -> Iterator[Finding]:
    """Find a load that neither study nor controller declares, by currents that differ from their
    targets.

    arm: with the payload that the controller was given; carrying: with the declared one; odd:
    joints, from 0, with wrong targets, which are left out.
    """
    if {"actual_current", "target_current"} - means.currents.keys():
        return
    declared = means.gravity(carrying) - means.gravity(arm)
    columns, torque = _unexpected_torque(means, arm, declared, odd)
    if len(torque):
        mass, left = fitted_load(columns, torque)
        _, error = combination(columns, torque, [1.0])  # large where only a wrist moves
        explained = left**2 < (1 - MIN_SHARE_EXPLAINED_BY_LOAD) * size(torque) ** 2
        if mass > max(MIN_UNDECLARED_LOAD, MIN_STANDARD_ERRORS * error) and explained:
            detail = (
                f"by the currents, the arm carries {number(mass, '.1f')} kg more than the study "
                "declares; declare it as `payload`, or fit to recordings without a load"
            )
            yield contradiction(CauseCode.UNDECLARED_LOAD, "payload", detail)


def held_gravity(means: BlockMeans, gravity: Array, current: Array, joint: int) -> Held:
    """Return how much of a joint's current balances gravity, fitted together with friction and
    inertia to the blocks in which the joint moves, or to all if these are few.

    gravity: torque (M, n) [Nm]; current: (M, n) [A]; joint: from 0.
    """
    rows = means.rubbing(joint)
    effort = current[rows, joint]
    columns = np.column_stack([gravity[:, joint], means.friction(joint), means.qdd])[rows]
    inverse = np.linalg.pinv(columns)
    solution = inverse @ effort
    residual = size(effort - columns @ solution)
    error = residual / np.sqrt(max(1, len(effort) - columns.shape[1])) * np.linalg.norm(inverse[0])
    return Held(float(solution[0]), float(error), (residual / size(effort)) ** 2)


def _unexpected_torque(
    means: BlockMeans, arm: Robot, declared: Array, odd: Container[int]
) -> tuple[Array, Array]:
    """Return torque per load (n, 4), and the torque (n,) by which measured currents exceed their
    targets.

    The rows are of all joints that bear gravity, while they move, without friction and divided by
    the spread of the joint's torque. At rest, stiction bears an unknown part of what a posture
    demands, which looks like a load. declared: torque (M, 6) [Nm] of the load that the study
    declares, which is subtracted; odd: joints that are left out.
    """
    gravity, loads = means.gravity(arm), load_torque(arm, means.q)
    measured, target = means.currents["actual_current"], means.currents["target_current"]
    rows = [np.empty((0, 5))]
    for joint in range(gravity.shape[1]):
        moves = np.abs(means.qd[:, joint]) > MIN_MOVING_SPEED
        if joint in odd or np.count_nonzero(moves) < MIN_MOVING_BLOCKS:
            continue
        held = held_gravity(means, gravity, target, joint)
        least, most = possible_constants(arm, joint)
        in_amperes = 1 / most < held.slope < 1 / least
        if held.unexplained < MAX_SHARE_UNEXPLAINED and in_amperes:
            torque = (measured - target)[moves, joint] / held.slope - declared[moves, joint]
            pair = np.column_stack([loads[moves, joint], torque])
            friction = means.friction(joint)[moves]
            pair -= friction @ np.linalg.lstsq(friction, pair, rcond=None)[0]
            rows.append(pair / max(pair[:, -1].std(), 0.1))
    every = np.vstack(rows)
    return every[:, :-1], every[:, -1]
