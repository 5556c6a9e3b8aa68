"""What a description lacks if its links explain an arm's motion far worse than any links do."""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import combinations

import numpy as np

from ur5lib.checks.by_motion import MAX_LEAD_OF_ANY_LINKS, MIN_ERRORS, MotionChecks
from ur5lib.checks.whole_motion import STRETCHES, Misfit, Regression, WholeMotion, lead
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.phrases import numbered
from ur5lib.records.quality import Finding
from ur5lib.robots.inertia import inertial_parameters, rigid_bodies
from ur5lib.timeseries.arrays import Array

# A load's centre of mass lies within this distance of the last joint's frame.
MAX_CENTER_DISTANCE = 0.3  # m
Remedy = tuple[CauseCode, Misfit, list[int]]


def doubted_links(checks: MotionChecks) -> Iterator[Finding]:
    """Yield a note for each correction of the description that would help joints of which any links
    explain the efforts far better: rotors, a load on the flange, springs, else other links.
    """
    first = checks.declared
    if first.by_links is None:
        return
    arm, best = checks.arm, first.by_any_links
    doubted = [joint for joint in checks.moving if _is_worse(first.by_links, best, joint)]
    for cause, misfit, joints in _remedies(checks.motion, doubted) if doubted else ():
        healed = [j for j in doubted if j in joints and not _is_worse(misfit, best, j)]
        doubted = [joint for joint in doubted if joint not in healed]
        if healed:
            yield _doubt(cause, arm.name, healed)
    if doubted and not arm.has_ur_motors():  # a UR's links are certain
        yield _doubt(CauseCode.DOUBTFUL_LINKS, arm.name, doubted)


def doubts_by_joint(findings: Iterable[Finding]) -> dict[int, Finding]:
    """Return, by joint from 1, the likeliest of the notes on its links: rotors, a load or springs
    before other links, then the one that was found most often.
    """
    found: dict[int, list[Finding]] = {}
    for one in findings:
        for joint in one.joints if one.code == Found.LINKS_IN_DOUBT else ():
            found.setdefault(joint, []).append(one)
    return {joint: max(own, key=partial(_weight, own)) for joint, own in found.items()}


def _weight(doubts: list[Finding], doubt: Finding) -> tuple[bool, int]:
    return doubt.cause != CauseCode.DOUBTFUL_LINKS, [one.cause for one in doubts].count(doubt.cause)


def _is_worse(misfit: Misfit, by_any_links: Misfit, joint: int) -> bool:
    """Return whether any links explain the efforts of a joint far better than what has this
    `misfit`.
    """
    ahead = lead(by_any_links, misfit, [joint])
    return ahead.size > MAX_LEAD_OF_ANY_LINKS and ahead.errors > MIN_ERRORS


def _doubt(cause: CauseCode, arm: str, joints: list[int]) -> Finding:
    numbers = tuple(joint + 1 for joint in joints)
    detail = doubt_in_words(cause, arm, numbers)
    code = Found.LINKS_IN_DOUBT
    return Finding("robot", code, "note", len(joints), detail, cause=cause, joints=numbers)


def doubt_in_words(cause: CauseCode | None, arm: str, joints: Sequence[int]) -> str:
    """Return what the torques of joints, from 1, show of an arm's description."""
    named = f"{numbered(joints)} of {arm}"
    return {
        CauseCode.MISSING_ROTORS: (
            f"the torques of {named} show rotors of motors that its description lacks; give their "
            "`rotor_inertia` and `gear_ratio` in `motors`"
        ),
        CauseCode.SURPLUS_ROTORS: (
            f"the torques of {named} show less inertia than its description has there, as if "
            "without the motors' rotors; correct `rotor_inertia` in `motors`"
        ),
        CauseCode.MISSING_LOAD: (
            f"the torques of {named} show a load on the flange that nothing declares; declare it "
            "as `payload`"
        ),
        CauseCode.MISSING_SPRING: (
            f"the torques of {named} show a spring or a counterbalance; write `balanced_joints: "
            f"[{', '.join(map(str, joints))}]` into its description"
        ),
        CauseCode.DOUBTFUL_LINKS: (
            f"other links would explain the torques of {numbered(joints)} far better than those "
            f"that the description of {arm} has; correct them, or say `links: unknown` there"
        ),
    }[cause or CauseCode.DOUBTFUL_LINKS]


def _remedies(motion: WholeMotion, joints: list[int]) -> Iterator[Remedy]:
    """Yield, for each correction of the description, the cause, its misfit and the joints, from 0,
    that it may heal: no rotor has a negative inertia, a load has a mass near the flange, and a UR
    no spring.
    """
    scale, last = motion.scale(motion.torque), 10 * (len(motion.joints) - 1)
    left = motion.torque - scale * motion.links

    def fitted(columns: Array) -> tuple[Misfit, Array, Array]:
        """Return the misfit of columns fitted with friction, their coefficients, and MIN_ERRORS
        standard errors of these (jackknife).
        """
        regression = Regression(np.concatenate([columns, motion.friction], axis=2))
        found = regression.coefficients(left)[:, : columns.shape[2]]
        spread = np.sqrt(STRETCHES - 1) * found.std(axis=0)
        return regression.misfit(left), found.mean(axis=0), MIN_ERRORS * spread

    misfit, inertia, error = fitted(motion.regressor[:, :, last + 10 :])
    bodies = rigid_bodies(motion.arm, motion.arm.fullest_model())
    described = inertial_parameters(motion.arm, bodies)[last + 10 :]
    more = (described == 0) & (inertia > error)
    yield CauseCode.MISSING_ROTORS, misfit, np.flatnonzero(more).tolist()
    less = (described > 0) & (inertia < -error) & (described + inertia > -error)
    yield CauseCode.SURPLUS_ROTORS, misfit, np.flatnonzero(less).tolist()
    misfit, body, error = fitted(scale[:, None] * motion.regressor[:, :, last : last + 10])
    if body[0] > max(error[0], np.linalg.norm(body[1:4]) / MAX_CENTER_DISTANCE):
        yield CauseCode.MISSING_LOAD, misfit, joints
    if motion.arm.has_ur_motors():
        return
    q = motion.means.q
    pairs = combinations(motion.joints, 2)
    alike = {joint for pair in pairs if motion.means.move_alike(pair) for joint in pair}
    joints = [joint for joint in joints if joint not in alike]  # other links do as well there
    springs = np.zeros((*q.shape, 3 * len(joints)))
    for k, joint in enumerate(joints):
        own = q[:, joint]
        springs[:, joint, 3 * k : 3 * k + 3] = np.column_stack([own, np.sin(own), np.cos(own)])
    yield CauseCode.MISSING_SPRING, fitted(springs)[0], joints
