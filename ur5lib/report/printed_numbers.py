"""Every published number beside the rebuilt one, and whether an erratum explains a difference."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.report.reference import Lookup, PrintedTable, Reference
from ur5lib.timeseries.arrays import Array

COLUMNS = ["source", "quantity", "recording", "row", "number", "printed", "rebuilt", "ratio"]
COLUMNS += ["as_erratum_says", "erratum", "right", "status"]
EQUAL, UNEXPLAINED = "equal", "unexplained"


class Explained(NamedTuple):
    """The numbers (6,) of a published row, computed with the error that an erratum describes."""

    erratum: int
    printed: str
    row: str
    numbers: Array


def compared(
    reference: Reference, tables: Mapping[str, pd.DataFrame], explained: Sequence[Explained]
) -> Iterator[dict[str, object]]:
    """Yield a row for each published number of the recordings in the study's tables (by name)."""
    for name, table in reference.printed.tables().items():
        for row, printed in dict(table.values).items():
            ways = [way for way in explained if (way.printed, way.row) == (name, row)]
            for number in _beside(table, tables, row, printed, ways):
                yield {
                    "source": table.sources.get(row, table.source),
                    "quantity": table.quantity or name,
                    "recording": table.recording,
                    "row": row,
                    **number,
                }


def judged(
    printed: float, rebuilt: float, by_erratum: Mapping[int, float], tolerance: float
) -> dict[str, object]:
    """Return a number's status with the numbers behind it.

    by_erratum: the number with each erratum's error; the nearest to the print is shown, and
    explains it if equal. tolerance: largest difference that counts as equal.
    """
    gaps = {abs(number - printed): erratum for erratum, number in by_erratum.items()}
    shown: dict[str, object] = {}
    status = UNEXPLAINED
    if gaps:
        nearest = gaps[min(gaps)]
        shown = {"as_erratum_says": by_erratum[nearest], "erratum": nearest}
        if min(gaps) <= tolerance:
            status = f"erratum {nearest}"
    if abs(rebuilt - printed) <= tolerance:  # also false where nothing could be rebuilt
        status = EQUAL
    ratio = rebuilt / printed
    return {"printed": printed, "rebuilt": rebuilt, "ratio": ratio, **shown, "status": status}


def _beside(
    table: PrintedTable,
    tables: Mapping[str, pd.DataFrame],
    row: str,
    printed: Sequence[float],
    ways: Sequence[Explained],
) -> Iterator[dict[str, object]]:
    """Yield the numbers of one published row; a single one is compared with the largest of six."""
    rebuilt = _found(table.rebuilt, tables, table.recording, row)
    right = _found(table.right, tables, table.recording, row)
    by_erratum = {way.erratum: way.numbers for way in ways}
    if len(printed) == 1 and len(rebuilt):
        rebuilt, right = (pd.Series({"largest": numbers.max()}) for numbers in (rebuilt, right))
        by_erratum = {key: np.array([numbers.max()]) for key, numbers in by_erratum.items()}
    digits = _decimals(table)
    for place, (number, value) in enumerate(rebuilt.items()):
        candidates = {erratum: float(numbers[place]) for erratum, numbers in by_erratum.items()}
        tolerance = _tolerance(table, printed[place], digits)
        status = judged(printed[place], value, candidates, tolerance)
        yield {"number": number, **status, "right": right.get(number)}


def _found(
    lookup: Lookup | None, tables: Mapping[str, pd.DataFrame], recording: str, row: str
) -> "pd.Series[float]":
    """Return the numbers of a published row in the study's tables, by joint or component."""
    if lookup is None:
        return pd.Series(dtype=float)
    table = tables[lookup.table]
    key = {"recording": recording} if "recording" in table else {}  # a fit is of several
    for column, value in (key | lookup.cells(row)).items():
        table = table[table[column] == value]
    return table.set_index(lookup.number)[lookup.column(row)]


def _tolerance(table: PrintedTable, printed: float, decimals: int) -> float:
    """Return the difference that counts as equal: some per cent, or half of the last digit."""
    least = table.below_one if abs(printed) < 1 else 0.0
    return max(table.relative * abs(printed), 0.5 * 10**-decimals, least)


def _decimals(table: PrintedTable) -> int:
    """Return the most decimals of a table's numbers."""
    rows = dict(table.values).values()
    shown = [np.format_float_positional(number, trim="-") for row in rows for number in row]
    return max(len(text.partition(".")[2]) for text in shown)
