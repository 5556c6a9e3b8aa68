"""What the published numbers add to the findings: unexplained ones, and a failed claim."""

from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from ur5lib.force.estimators import ESTIMATES, LEADING
from ur5lib.report.results import Results
from ur5lib.topics.thesis.printed_numbers import EQUAL, UNEXPLAINED

TABLES = ("printed",)
CLAIMED_ESTIMATE, CLAIMED_COMPONENT = "F*", "Fz"  # the thesis detects pushes by these


class ClaimScore(NamedTuple):
    """How an estimate detects pushes along z.

    pushes: those that reach the threshold at the sensor; found: of these; above: largest share of a
    contact-free recording in which the estimate exceeds the threshold.
    """

    found: int
    pushes: int
    above: float


def shown_first(results: Results, table: str) -> list[str]:
    """Return the recordings with printed values of a table."""
    return [*results.rows("printed", table=table)["recording"].unique()]


def findings(results: Results) -> Iterator[str]:
    """Report the published numbers that nothing explains, and the claim if it fails."""
    rows = results.rows("printed")
    status = rows["status"] if len(rows) else pd.Series(dtype=str)
    left, equal = int((status == UNEXPLAINED).sum()), int((status == EQUAL).sum())
    if left:
        yield (
            f"{left} of {len(status)} published numbers are unexplained; {equal} are rebuilt, "
            f"errata explain {len(status) - equal - left}."
        )
    yield from _claim(results)


def _claim(results: Results) -> Iterator[str]:
    """Report missed pushes or false detections if they refute the claim to detect pushes."""
    claimed, ours = score(results, CLAIMED_ESTIMATE), score(results, LEADING)
    if claimed is None or ours is None:
        return
    missed, name = claimed.pushes - claimed.found, ESTIMATES[CLAIMED_ESTIMATE]
    claim = f"The thesis claims to detect pushes from 10 N on, but its {name}"
    if missed:
        own = ours.pushes - ours.found
        yield f"{claim} misses {missed} of {claimed.pushes} along z (ours: {own})."
    elif claimed.above:
        yield (f"{claim} exceeds 10 N in {100 * claimed.above:.0f} % of a run without contact.")


def score(results: Results, estimate: str) -> ClaimScore | None:
    """Return an estimate's score, None without the recordings for it.

    Pushes are counted on recordings with printed errors, time above the threshold on validate
    recordings.
    """
    printed, validated = shown_first(results, "force_mae"), results.with_role("validate")
    rows = {"component": CLAIMED_COMPONENT, "estimate": estimate}
    pushed = results.rows("fixed_threshold", recording=printed, **rows)
    free = results.rows("fixed_threshold", recording=validated, **rows)
    if pushed.empty or free.empty:
        return None
    found, pushes = (int(pushed[name].sum()) for name in ("found", "pushes"))
    return ClaimScore(found, pushes, float(free["time_above"].max()))
