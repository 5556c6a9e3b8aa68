"""Contact forces compared with the force sensor, their bands, and detected contacts."""

import pandas as pd

from ur5lib.force.estimators import GATED, NEW, PUBLISHED
from ur5lib.records.codes import Found
from ur5lib.report.results import Results
from ur5lib.report.topics import shown_first

REPORT_RANK = {
    name: place for place, name in enumerate([*NEW, *PUBLISHED])
}  # in the order of the report


def compared(results: Results) -> list[str]:
    """Return the recordings that the figures of forces show, in this order: those that topics ask
    for, those with a force sensor, other searched ones of the role `contact`.
    """
    touched = results.with_role("contact", searched(results)["recording"])
    beside = [*results.listed("force_mae"), *results.listed("sensed")]
    return results.shown([*shown_first(results, "force_mae"), *beside, *touched])


def with_moments(results: Results) -> list[str]:
    """Return recordings on which the leading estimate determines a moment in contact."""
    rows = results.rows("force_mae", kind="compensated", during="contact", determined="yes")
    return results.shown([*leading(rows[rows["component"].str.startswith("n")])["recording"]])


def searched(results: Results) -> pd.DataFrame:
    """Return the rows of detection.csv by this study's estimates, without published ones."""
    return results.rows("detection", estimate=GATED)


def leading(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the leading estimate: the first in the report's order."""
    rank = rows["estimate"].map(REPORT_RANK)
    return rows[rank == rank.min()]


def saturated(results: Results, among: list[str]) -> list[str]:
    """Return the recordings among some on which the force sensor saturates."""
    found = results.rows("quality", recording=among, device="force", code=Found.SATURATION)
    return [*found["recording"].unique()]
