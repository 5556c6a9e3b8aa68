"""Whether a recording begins in the posture in which the one that it is said to follow ended."""

import numpy as np

from ur5lib.records.account import AccountRow
from ur5lib.records.codes import Found
from ur5lib.records.motion import SAME_POSTURE
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding
from ur5lib.timeseries.arrays import Array


def moved_between(before: str, change: Array) -> Finding | None:
    """Return the warning that an arm was moved between two recordings, None where it was not.

    before: the name of the first; change: (n,) [rad], from its last to the other's first posture.
    """
    joint = int(np.argmax(np.abs(change)))
    if abs(change[joint]) <= SAME_POSTURE:
        return None
    detail = (
        f"joint {joint + 1} begins {number(abs(change[joint]), '.2g')} rad from where it ended in "
        f"{before}: the arm was moved in between, and what friction remembers of {before} is not "
        "used; correct `after`, or remove it"
    )
    return Finding("robot", Found.MOVED_IN_BETWEEN, "warning", 1, detail, joints=(joint + 1,))


def stated_succession(before: str, change: Array) -> AccountRow:
    """Return the row of a recording's account on how near it begins to where the one that the study
    names before it ended.
    """
    most = float(np.abs(change).max())
    within = f"begins within {most:.1e} rad of where {before} ended, on all joints"
    return AccountRow(
        "after",
        "the recording before",
        "option",
        "proven" if most <= SAME_POSTURE else "check",
        within,
    )
