"""The thesis's claim of Section 6, that F̂*_z detects 10 N and more reliably, judged by numbers."""

from collections.abc import Iterator
from typing import NamedTuple

from ur5lib.pipeline.estimators import ESTIMATES
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say

CLAIMED, OURS, AXIS = "F*", "Fmap", "Fz"


class Score(NamedTuple):
    """How an estimate detects pushes: found of all that reach the threshold at the sensor, and the
    largest share of a contact-free recording for which the estimate is above it.
    """

    found: int
    pushes: int
    above: float

    @property
    def reliable(self) -> bool:
        """Whether every push is found and nothing else is above the threshold."""
        return self.found == self.pushes and self.above == 0


def score(results: Results, estimate: str) -> Score | None:
    """Return an estimate's score, None without such recordings.

    Pushes are counted on recordings with printed errors, time above on validate recordings.
    """
    rows = results.rows("fixed_threshold", component=AXIS, estimate=estimate)
    pushed = rows[rows["recording"].isin(results.printed("force_mae", "printed_mae"))]
    free = rows[rows["recording"].isin(results.with_role("validate"))]
    if pushed.empty or free.empty:
        return None
    found, pushes = (int(pushed[name].sum()) for name in ("found", "pushes"))
    return Score(found, pushes, float(free["time_above"].max()))


def judged(results: Results) -> Iterator[Sentence]:
    """Report whether the claim holds, and why not."""
    claimed = score(results, CLAIMED)
    if claimed is None:
        return
    yield say("claim.judged", claimed=claimed)


def compared(results: Results) -> list[str]:
    """Return a sentence with the scores of F̂*_z and F̂ᵐᵃᵖ, by which the claim is judged."""
    claimed, ours = score(results, CLAIMED), score(results, OURS)
    if claimed is None or ours is None:
        return []
    scores = {CLAIMED: claimed, OURS: ours}.items()
    parts = [say("claim.score", name=ESTIMATES[name], score=value) for name, value in scores]
    return [say("claim.compared", pushes=claimed.pushes, parts=parts)]
