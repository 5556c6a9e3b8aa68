"""Published numbers, and how many of them are rebuilt."""

from collections.abc import Iterator

import numpy as np

from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.thesis.printed_numbers import EQUAL, UNEXPLAINED

COMPUTED_DIGITS = 4  # of computed numbers


def sources(results: Results) -> list[str]:
    """Return the published tables with rebuilt numbers."""
    return sorted({*results.rows("printed")["source"]})


def rebuilt(results: Results) -> Iterator[str]:
    """Report how many published numbers are rebuilt."""
    rows = results.rows("printed")
    if len(rows):
        equal, missed = (rows["status"] == EQUAL).sum(), bool(unexplained(results))
        yield say("printed.found", equal=equal, count=len(rows), left=missed)


def unexplained(results: Results) -> list[str]:
    """Return each unexplained number with its table and row, and the difference in per cent: that
    of the erratum's number, or else of the rebuilt one.
    """
    sentences = []
    for row in results.rows("printed", status=UNEXPLAINED).itertuples():
        nearest, source = row.rebuilt, "rebuilt"
        if not np.isnan(row.as_erratum_says):
            nearest, source = row.as_erratum_says, f"erratum {row.erratum:.0f} gives"
        gap = 100 * (nearest / row.printed - 1)
        place = f"joint {row.number}" if str(row.number).isdecimal() else row.number
        words = {"nearest": nearest, "source": source, "gap": gap, "digits": COMPUTED_DIGITS}
        sentences.append(say("printed.missed", row=row, place=place, **words))
    return sentences
