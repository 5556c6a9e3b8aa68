"""Checks of currents against their targets: a fraction or a multiple of these, in joints that bear.

Gravity shows which of the two is wrong, where one has the motor's torque constant.
"""

from collections.abc import Container, Iterator

import numpy as np

from ur5lib.channels import MEASURED_CURRENT, TARGET_CURRENT
from ur5lib.checks.arm import Constants, torque_constants
from ur5lib.checks.block_means import BlockMeans, combination
from ur5lib.checks.currents import moving_joints
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot

# Current per target. It is 0.87 to 1.5 in right recordings, loads included.
MIN_RATIO_TO_TARGET, MAX_RATIO_TO_TARGET = 0.8, 2.0
MIN_BORNE_CURRENT = 1.0  # A; a joint that bears something has a target of this root mean square


def scaled_currents(means: BlockMeans, odd: Container[int]) -> Iterator[Finding]:
    """Find currents that are a fraction or a multiple of their targets.

    odd: joints from 0 with wrong targets.
    """
    for joint, ratio in unlike_targets(means):
        if joint not in odd:
            detail = (
                f"the current of joint {joint + 1} is {number(ratio, '.2f')} times its target; "
                "correct its unit or column, or declare the load as `payload`"
            )
            yield contradiction(CauseCode.SCALED_CURRENT, "unit", detail, [joint + 1])


def odd_targets(means: BlockMeans, arm: Robot) -> dict[int, Finding]:
    """Return warnings of wrong targets, by joint from 0, where current and target differ by a
    factor.

    Gravity shows the motor's torque constant in the current, nearer than in its target. arm: with
    its load.
    """
    unlike = dict(unlike_targets(means))
    if not unlike:
        return {}
    measured, targeted = torque_constants(means, arm), torque_constants(means, arm, TARGET_CURRENT)
    both = measured.ratio.keys() & targeted.ratio.keys()
    nearer = {joint for joint in both if measured.away(joint) < targeted.away(joint)}
    return {
        joint: _odd_target(joint, 1 / ratio, measured, targeted)
        for joint, ratio in unlike.items()
        if joint in nearer - measured.foreign().keys()
    }


def _odd_target(joint: int, ratio: float, measured: Constants, targeted: Constants) -> Finding:
    """Return the warning of the target of a joint, from 0; ratio: of target to current; measured,
    targeted: torque constants by each.
    """
    known = measured.known[joint]
    by_gravity, by_target = (one.ratio[joint] * known for one in (measured, targeted))
    detail = (
        f"target_current of joint {joint + 1} is {number(ratio, '.2f')} times actual_current, "
        f"which gravity confirms ({number(by_gravity, '.3g')} Nm/A, by the target "
        f"{number(by_target, '.3g')}; known: {number(known, '.3g')}): the target is not that of "
        "this motor, and the fit takes no torque constant from it"
    )
    return Finding("robot", Found.ODD_TARGET, "warning", 1, detail, joints=(joint + 1,))


def unlike_targets(means: BlockMeans) -> Iterator[tuple[int, float]]:
    """Yield joints, from 0, with a current that is a fraction or multiple of its target, and the
    ratio."""
    if {MEASURED_CURRENT, TARGET_CURRENT} - means.currents.keys():
        return
    moves = moving_joints(means)
    for joint in range(min(3, len(moves))):  # wrists bear almost nothing
        target, friction = means.currents[TARGET_CURRENT][:, joint], means.friction(joint)
        # without friction, which targets of some arms contain, and inertia: only a load shows it
        others = np.column_stack([friction, means.qdd[:, joint]])
        borne = target - others @ np.linalg.lstsq(others, target, rcond=None)[0]
        # at rest, of a joint where others change the load
        if (
            not (moves[joint] and np.sqrt((borne**2).mean()) > MIN_BORNE_CURRENT)
            and borne.std() <= MIN_BORNE_CURRENT
        ):
            continue
        load = np.abs(target) * friction[:, 0]
        columns = np.column_stack([target, friction, load, means.qdd[:, joint]])
        rows = means.rubbing(joint)
        slope, error = combination(columns[rows], means.effort[rows, joint], [1.0])
        if slope + 5 * error < MIN_RATIO_TO_TARGET or slope - 5 * error > MAX_RATIO_TO_TARGET:
            yield joint, slope
