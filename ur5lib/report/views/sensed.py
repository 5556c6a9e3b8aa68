"""Readings of force sensors where no friction was fitted, and the assumptions of forces there."""

from collections.abc import Iterator

from ur5lib.force.map_estimate import BREAKAWAY, LEAST_ERROR, SLOW
from ur5lib.report.contents import MOST_SHOWN
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say


def touched(results: Results) -> list[str]:
    """Return the recordings on which a force sensor reads a contact, the strongest first."""
    rows = results.tables["sensed"]
    rows = rows[rows["contacts"] > 0].sort_values("largest_force_n", ascending=False)
    return [*rows["recording"]]


def readings(results: Results) -> Iterator[Sentence]:
    """Report largest force and share in contact by sensor, where no friction was fitted."""
    if len(results.tables["friction"]):
        return
    for row in results.tables["sensed"][:MOST_SHOWN].itertuples():
        yield say("sensed.reading", row=row)


def uncalibrated(results: Results) -> Iterator[Sentence]:
    """Report the assumptions of the static estimate, which replaces a fit."""
    if (results.tables["force_mae"]["estimate"] == "static").any():
        limits = {"error": LEAST_ERROR, "breakaway": BREAKAWAY, "slow": SLOW}
        yield say("sensed.uncalibrated", **limits)
