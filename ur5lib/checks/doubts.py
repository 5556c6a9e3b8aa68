"""What a description lacks whose links explain an arm's motion far worse than any links do."""

from collections.abc import Iterator

import numpy as np

from ur5lib.checks.by_motion import MAX_LEAD_OF_ANY_LINKS, MIN_ERRORS, MotionChecks
from ur5lib.checks.whole_motion import Misfit, Regression, WholeMotion, lead
from ur5lib.records.quality import Finding
from ur5lib.timeseries.arrays import Array

DOUBT = "links in doubt"  # the finding


def doubted_links(checks: MotionChecks) -> Iterator[Finding]:
    """Yield notes of what would heal the description of joints that move: rotors, a load on the
    flange, springs, else other links; each names its joints.
    """
    first = checks.declared
    if first.by_links is None:
        return
    arm, best = checks.arm, first.by_any_links
    doubted = [joint for joint in checks.moving if _is_worse(first.by_links, best, joint)]
    for code, misfit in _remedies(checks.motion, doubted) if doubted else ():
        healed = [j for j in doubted if not _is_worse(misfit, best, j)]
        doubted = [joint for joint in doubted if joint not in healed]
        if healed:
            yield _doubt(code, arm.name, healed)
    if doubted and not arm.has_ur_motors():  # whose links are known
        yield _doubt("doubtful links", arm.name, doubted)


def _is_worse(misfit: Misfit, by_any_links: Misfit, joint: int) -> bool:
    """Return whether any links explain the efforts of a joint better than some explanation."""
    ahead = lead(by_any_links, misfit, [joint])
    return ahead.size > MAX_LEAD_OF_ANY_LINKS and ahead.errors > MIN_ERRORS


def _doubt(code: str, arm: str, joints: list[int]) -> Finding:
    values = {"arm": arm, "joints": [joint + 1 for joint in joints]}
    return Finding("robot", DOUBT, "note", len(joints), values, code)


def _remedies(motion: WholeMotion, joints: list[int]) -> Iterator[tuple[str, Misfit]]:
    """Yield what each remedy leaves unexplained; joints: from 0, of which springs may be."""
    left = motion.torque - motion.scale(motion.torque) * motion.links

    def with_columns(columns: Array) -> Misfit:
        return Regression(np.concatenate([columns, motion.friction], axis=2)).misfit(left)

    yield "missing rotors", with_columns(motion.regressor[:, :, 10 * len(motion.joints) :])
    yield "missing load", motion.with_any_load()
    q = motion.means.q
    springs = np.zeros((*q.shape, 3 * len(joints)))
    for k, joint in enumerate(joints):
        own = q[:, joint]
        springs[:, joint, 3 * k : 3 * k + 3] = np.column_stack([own, np.sin(own), np.cos(own)])
    yield "missing spring", with_columns(springs)
