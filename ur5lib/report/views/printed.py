"""Published numbers beside the rebuilt ones, and those that stay unexplained."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.pipeline.estimators import ESTIMATES
from ur5lib.report.cells import number, significant
from ur5lib.report.document import Cell
from ur5lib.report.printed_numbers import COLUMNS, EQUAL, UNEXPLAINED
from ur5lib.report.results import Body, Column, Results, tabulated
from ur5lib.report.sentences import Sentence, say

DIGITS = 4  # of computed numbers
NAMES = {**ESTIMATES, "euler": "Euler angles"}  # of rows


def sources(results: Results) -> list[str]:
    """Return the published tables with rebuilt numbers."""
    return sorted({*_rows(results)["source"]})


def numbers(results: Results, source: str) -> Body:
    """Return every number of a published table: printed, rebuilt, by the erratum, and right."""
    columns: dict[str, Column] = {
        "quantity": "quantity",
        "row": lambda row: NAMES.get(row.row, row.row),
        "joint or component": "number",
        "printed": lambda row: _number(row.printed, 6),
        "rebuilt": lambda row: _number(row.rebuilt),
        "ratio": lambda row: number(row.ratio, 3),
        "by an erratum": lambda row: _number(row.as_erratum_says),
        "right": lambda row: _number(row.right),
        "status": "status",
    }
    return tabulated(results.rows("printed", source=source).itertuples(), columns)


def summary(results: Results) -> Iterator[Sentence]:
    """Report how many published numbers are rebuilt."""
    rows = _rows(results)
    if len(rows):
        equal, left = (rows["status"] == EQUAL).sum(), bool(unexplained(results))
        yield say("printed.found", equal=equal, count=len(rows), left=left)


def unexplained_heading(results: Results) -> list[str]:
    """Return the sentence above the list of unexplained numbers, if there are any."""
    return [say("printed.unexplained")] if unexplained(results) else []


def unexplained(results: Results) -> list[str]:
    """Return each unexplained number with its table and row, and the difference in per cent."""
    rows = _rows(results)
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


def _rows(results: Results) -> pd.DataFrame:
    return results.tables.get("printed", pd.DataFrame(columns=COLUMNS))


def _number(value: float, digits: int = DIGITS) -> Cell:
    return Cell("–" if np.isnan(value) else significant(value, digits).replace("-", "−"))
