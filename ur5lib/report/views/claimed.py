"""The thesis's claim of Section 6, that F̂*_z detects 10 N and more reliably, judged by numbers."""

from collections.abc import Iterator
from typing import NamedTuple

from ur5lib.pipeline.estimators import ESTIMATES
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say

CLAIMED, OURS, AXIS = "F*", "Fmap", "Fz"


class Score(NamedTuple):
    """Pushes that reach the threshold at the sensor, those found of them, and the largest share of
    a recording without contact for which the estimate is above the threshold.
    """

    found: int
    pushes: int
    above: float

    @property
    def reliable(self) -> bool:
        """Whether every push is found and nothing else is above the threshold."""
        return self.found == self.pushes and self.above == 0


def score(results: Results, estimate: str) -> Score | None:
    """Return an estimate's score: of pushes where errors are printed, free where no fit has seen.

    None if there is no such recording.
    """
    rows = results.rows("fixed_threshold", component=AXIS, estimate=estimate)
    pushed = rows[rows["recording"].isin(results.printed("force_mae", "printed_mae"))]
    free = rows[rows["recording"].isin(results.with_role("validate"))]
    if pushed.empty or free.empty:
        return None
    found, pushes = (int(pushed[name].sum()) for name in ("found", "pushes"))
    return Score(found, pushes, float(free["time_above"].max()))


def judged(results: Results) -> Iterator[Sentence]:
    """Report whether the claim holds, and why not: the finding."""
    own = score(results, CLAIMED)
    if own is None:
        return
    yield say("claim.judged", own=own)


def compared(results: Results) -> list[str]:
    """Return the numbers that the claim is judged by, of F̂*_z and of F̂ᵐᵃᵖ."""
    own, beside = score(results, CLAIMED), score(results, OURS)
    if own is None or beside is None:
        return []
    scores = {CLAIMED: own, OURS: beside}.items()
    parts = [say("claim.score", name=ESTIMATES[name], one=one) for name, one in scores]
    return [say("claim.compared", own=own, parts=parts)]
