"""Published numbers beside the rebuilt ones, and those that stay unexplained."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ur5lib.report.printed_numbers import EQUAL, UNEXPLAINED
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say

DIGITS = 4  # of computed numbers


def sources(results: Results) -> list[str]:
    """Return the published tables with rebuilt numbers."""
    return sorted({*results.rows("printed")["source"]})


def summary(results: Results) -> Iterator[Sentence]:
    """Report how many published numbers are rebuilt."""
    rows = results.rows("printed")
    if len(rows):
        equal, left = (rows["status"] == EQUAL).sum(), bool(unexplained(results))
        yield say("printed.found", equal=equal, count=len(rows), left=left)


def unexplained_heading(results: Results) -> list[str]:
    """Return the sentence above the list of unexplained numbers, if there are any."""
    return [say("printed.unexplained")] if unexplained(results) else []


def unexplained(results: Results) -> list[str]:
    """Return each unexplained number with its table and row, and the difference in per cent."""
    rows = results.rows("printed")
    return [_missed(row) for row in rows[rows["status"] == UNEXPLAINED].itertuples()]


def _missed(row: Any) -> str:
    """Return how far the erratum's number, or else the rebuilt one, is from the printed one."""
    nearest, source = row.rebuilt, "rebuilt"
    if not np.isnan(row.as_erratum_says):
        nearest, source = row.as_erratum_says, f"erratum {row.erratum:.0f} gives"
    gap = 100 * (nearest / row.printed - 1)
    place = f"joint {row.number}" if str(row.number).isdecimal() else row.number
    words = {"nearest": nearest, "source": source, "gap": gap, "digits": DIGITS}
    return say("printed.missed", row=row, place=place, **words)
