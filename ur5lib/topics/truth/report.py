"""The report's part on estimates beside the truth: how many intervals hold it."""

from collections.abc import Iterator

import pandas as pd
from scipy.special import bdtr, bdtrc

from ur5lib.report.page.sentences import names, say
from ur5lib.report.results import Results

REMARKABLE_CHANCE = (
    0.025  # below this chance, the count of intervals that contain the truth is remarkable
)


def findings(results: Results) -> Iterator[str]:
    """Report how many stated intervals contain the truth."""
    yield from beside_truth(results.rows("truth"))


def beside_truth(truth: pd.DataFrame) -> Iterator[str]:
    """Report how many stated intervals contain the simulated truth, and the expected count."""
    stated = truth["within95"].dropna()
    if len(stated):
        count, inside = len(stated), int((stated == "yes").sum())
        yield say("truth.found", count=count, held=inside)
        many, few = (
            bdtrc(inside - 1, count, 0.95),
            bdtr(inside, count, 0.95),
        )  # of independent values
        chance = min(many, few)
        surprise = {"chance": chance if chance < REMARKABLE_CHANCE else None, "many": many < few}
        yield say("truth.right intervals", count=count, **surprise)


def intervals(results: Results) -> pd.DataFrame:
    """Return how many stated intervals contain the truth, by quantity."""
    stated = results.rows("truth").dropna(subset="within95")
    groups = stated.assign(inside=stated["within95"] == "yes").groupby("quantity", sort=False)
    return groups["inside"].agg(values="size", inside="sum").reset_index()


def single(results: Results) -> pd.DataFrame:
    """Return the single values: those fitted to several recordings, and of a recording's clocks."""
    return results.rows("truth", quantity=[*names("truth")])
