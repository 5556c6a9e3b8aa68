"""Mistakes that the checks of a recording would not notice: one note each, with the reason."""

from collections.abc import Container, Iterable, Iterator
from itertools import combinations

from ur5lib.channels import TARGET_CURRENT, TORQUE
from ur5lib.checks.arm import Pair, fitting_arms, torque_constants
from ur5lib.checks.checked import MIN_BLOCKS, Checked
from ur5lib.checks.currents import MIN_GRAVITY_TORQUE, MIN_LEAD_OF_EXCHANGE
from ur5lib.checks.readings import exchanged_order, in_order
from ur5lib.checks.sensed_torques import size_ratio
from ur5lib.checks.tool import (
    MAX_TOOL_DISTANCE,
    tool_and_angles,
    tool_distance,
    tool_off_flange,
)
from ur5lib.checks.torques import is_foreign
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number, numbered
from ur5lib.records.quality import Finding, Severity

POSE, MOMENT = "actual_TCP_pose", "target_moment"
MAX_NAMED = 3  # at most this many other arms are named


def unchecked(checked: Checked) -> list[Finding]:
    """Return a note on each kind of mistake that the checks could not notice in a recording without
    a stop sign.
    """
    if len(checked.means.q) < MIN_BLOCKS:
        seconds = number(len(checked.robot) * checked.step, ".1f")
        detail = f"arm, columns, units and clocks could not be checked: {seconds} s are too short"
        return [_note(Found.NOTHING_CHECKED, detail)]
    return [*_arm(checked), *_order(checked), *_currents(checked), *checked.doubted_links]


def _note(code: Found, detail: str) -> Finding:
    return Finding("robot", code, "note", 1, detail)


def _arm(checked: Checked) -> Iterator[Finding]:
    """Yield the note on other arms that the recording fits as well, if no torque of the controller
    excludes them.
    """
    if checked.means.torque is not None or not checked.arm.tells_gravity():
        return
    own = checked.arm.name, checked.arm.link_poses()  # under whatever name
    others = [o for o in checked.others if o.name != own[0] and o.link_poses() != own[1]]
    if f"{POSE}_0" in checked.robot:
        others = [one for one in others if not any(tool_off_flange(checked.robot, one))]
    if checked.tells_by_gravity():
        fitting = fitting_arms(checked.means, checked.loaded, others)
        others = [one for one in others if one.name in fitting]
    if others:
        telling = MOMENT, POSE, checked.arm.measured.channel
        absent = [name for name in telling if f"{name}_0" not in checked.robot]
        names, more = [one.name for one in others[:MAX_NAMED]], len(others[MAX_NAMED:])
        names += [f"{more} more"] * bool(more)
        detail = (
            f"`robot: {checked.arm.name}` could not be told from {' or '.join(names)}: "
            f"{' or '.join(absent)} would tell"
        )
        yield _note(Found.ARM_NOT_CHECKED, detail)


def _order(checked: Checked) -> Iterator[Finding]:
    """Yield the note on the pairs of joints of which exchanged columns could not be noticed."""
    shown = {
        *_pairs_shown_by_pose(checked),
        *_pairs_shown_by_torque(checked),
        *_pairs_shown_by_motion(checked),
    }
    open_pairs = [pair for pair in combinations(in_order(checked.arm), 2) if pair not in shown]
    if open_pairs:
        detail = (
            f"exchanged columns of joints {_named(open_pairs)} could not be noticed: neither pose, "
            "torque nor current tells these joints apart"
        )
        yield _note(Found.ORDER_NOT_CHECKED, detail)


def _named(pairs: Iterable[Pair]) -> str:
    """Return pairs of joints, from 0, as text with numbers from 1."""
    return ", ".join(f"{j + 1}-{k + 1}" for j, k in pairs)


def _pairs_shown_by_pose(checked: Checked) -> Iterator[Pair]:
    """Yield the pairs that, exchanged, would take the tool off the flange."""
    if f"{POSE}_0" not in checked.robot:
        return
    (tool, q), order = tool_and_angles(checked.robot), in_order(checked.arm)
    for pair in combinations(order, 2):
        moved = q[:, exchanged_order(order, *pair)]
        if tool_distance(tool, moved, checked.arm) > MAX_TOOL_DISTANCE:
            yield pair


def _pairs_shown_by_torque(checked: Checked) -> Iterator[Pair]:
    """Yield the pairs that, exchanged, the controller's torque would not fit."""
    means, torque, in_place = checked.means, checked.means.torque, in_order(checked.arm)
    if torque is None:
        return
    for pair in combinations(in_place, 2):
        order = exchanged_order(in_place, *pair)
        moved = means.part(columns=order)
        if is_foreign(moved, torque[:, order], checked.arm, checked.payloads):
            yield pair


def _pairs_shown_by_motion(checked: Checked) -> Iterator[Pair]:
    """Yield the pairs that, exchanged, the efforts would not fit."""
    if checked.means.torque is None and checked.motion is not None:
        yield from filter(checked.motion.tells_order, checked.motion.exchanged_joints)


def _currents(checked: Checked) -> Iterator[Finding]:
    """Yield the notes on what could not be checked of the currents: units, signs, columns and
    clock.
    """
    means, sensed = checked.means, checked.arm.measured == TORQUE
    if not means.has_efforts():
        yield _no_currents(checked)
        return
    told = checked.arm.tells_gravity() and not sensed
    bearing = torque_constants(means, checked.loaded).ratio if told else {}
    if told and not bearing and TARGET_CURRENT not in means.currents:
        detail = (
            "the unit of actual_current could not be checked: gravity bears less than "
            f"{MIN_GRAVITY_TORQUE:g} Nm on every joint, or does not explain the currents"
        )
        yield _note(Found.UNIT_NOT_CHECKED, detail)
    if sensed and size_ratio(means, checked.loaded) is None:
        detail = (
            f"the unit of actual_torque could not be checked: {checked.arm.name} has no `weight` "
            "[kg], or bears little here"
        )
        yield _note(Found.SIZE_NOT_CHECKED, detail)
    if checked.answers is None and not sensed:
        detail = (
            "order, sign and delay of actual_current could not be checked: no motor moves its "
            "joint against friction"
        )
        yield _note(Found.CURRENTS_NOT_CHECKED, detail)
        return
    yield from _by_motion(checked, bearing)


def _no_currents(checked: Checked) -> Finding:
    severity: Severity = "warning" if checked.fitted else "note"
    measured = checked.arm.measured
    detail = (
        f"no {measured.channel}: without {measured.quantity}s, there are no friction, no "
        f"{measured.constant}s and no contact forces; record them, or name their columns"
    )
    return Finding("robot", Found.NO_CURRENTS, severity, 1, detail)


def _by_motion(checked: Checked, bearing: Container[int]) -> Iterator[Finding]:
    """Yield the notes on what the motion could not show of the efforts; bearing: joints, from 0, of
    which gravity shows the constant, and thus the sign.
    """
    joints, motion = range(len(checked.arm.joints)), checked.motion
    open_signs = [
        j + 1
        for j in joints
        if j not in bearing and not (motion is not None and motion.tells_sign(j))
    ]
    if open_signs:
        detail = (
            f"the sign of the current or torque of {numbered(open_signs)} could not be checked: "
            "too little is borne, moved or rubbed there"
        )
        yield _note(Found.SIGN_NOT_CHECKED, detail)
    if pairs := [*_pairs_alike(checked)]:
        detail = (
            f"exchanged currents or torques of joints {_named(pairs)} could not be noticed: one of "
            "the two moves too little, or as the other"
        )
        yield _note(Found.COLUMNS_NOT_CHECKED, detail)
    if checked.delays is None:
        detail = (
            "sign and delay of actual_torque could not be checked by friction, as those of motor "
            "currents are"
        )
        yield _note(Found.TORQUES_NOT_CHECKED, detail)
    elif (delay := checked.delays.longest_unnoticed()) >= checked.delays.shortest:
        detail = (
            f"delays of up to {delay:.2f} s between the motion and its motors could not be "
            "noticed: the arm moves too little"
        )
        yield _note(Found.CLOCK_NOT_CHECKED, detail)


def _pairs_alike(checked: Checked) -> Iterator[Pair]:
    """Yield the pairs of joints of which exchanged currents, or measured torques, could not be
    noticed.
    """
    motion, lead = checked.motion, None
    if checked.answers is not None:
        lead = checked.answers.ahead().diagonal()
    for j, k in combinations(range(len(checked.arm.joints)), 2):
        answered = lead is not None and lead[j] + lead[k] > MIN_LEAD_OF_EXCHANGE
        if not answered and (motion is None or not motion.tells_efforts((j, k))):
            yield j, k
