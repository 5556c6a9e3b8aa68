"""Dynamics, friction and contact force of Universal Robots arms, from recordings."""

from typing import TYPE_CHECKING

__version__ = "0.2.0"

if TYPE_CHECKING:
    from pathlib import Path

    from ur5lib.finished import FinishedStudy


def load(folder: "str | Path") -> "FinishedStudy":
    """Return the results of a study, e.g. `ur5lib.load("results/mine").forces("pushed")`.

    Raises InputError where the folder holds none.
    """
    from ur5lib.finished import FinishedStudy  # pandas, which not every user of the package needs

    return FinishedStudy(folder)
