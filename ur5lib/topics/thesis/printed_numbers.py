"""Every published number with the rebuilt one, and whether an erratum explains a difference."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.timeseries.arrays import Array
from ur5lib.topics.thesis.reference import Lookup, PrintedTable, PublishedValues

PRINTED_COLUMNS = [
    "table",
    "source",
    "quantity",
    "recording",
    "row",
    "number",
    "printed",
    "rebuilt",
    "ratio",
]
PRINTED_COLUMNS += ["as_erratum_says", "erratum", "right", "status"]
EQUAL, UNEXPLAINED = "equal", "unexplained"


class ExplainedRow(NamedTuple):
    """The numbers (6,) of a published row, computed with the error that an erratum describes."""

    erratum: int
    printed: str
    row: str
    numbers: Array


def compared(
    reference: PublishedValues,
    tables: Mapping[str, pd.DataFrame],
    explained: Sequence[ExplainedRow],
) -> Iterator[dict[str, object]]:
    """Yield a row of printed.csv for each published number of the recordings in the study's tables
    (by name).
    """
    for name, table in reference.printed.items():
        for row in dict(table.values):
            about = {
                "table": name,
                "source": table.sources.get(row, table.source),
                "quantity": table.quantity or name,
                "recording": table.recording,
                "row": row,
            }
            ways = [way for way in explained if (way.printed, way.row) == (name, row)]
            by_erratum = {way.erratum: way.numbers for way in ways}
            yield from (about | number for number in _beside(table, tables, row, by_erratum))


def _beside(
    table: PrintedTable,
    tables: Mapping[str, pd.DataFrame],
    row: str,
    by_erratum: Mapping[int, Array],
) -> Iterator[dict[str, object]]:
    """Yield a row for each number of one published row, compared with ours; a single number is
    compared with the largest of six.
    """
    printed = dict(table.values)[row]
    rebuilt = _found(table.rebuilt, tables, table.recording, row)
    right = _found(table.right, tables, table.recording, row)
    if len(printed) == 1 and len(rebuilt):
        rebuilt, right = (pd.Series({"largest": numbers.max()}) for numbers in (rebuilt, right))
        by_erratum = {key: np.array([numbers.max()]) for key, numbers in by_erratum.items()}
    last_digit = 10.0 ** -_decimals(table)
    for place, (number, value) in enumerate(rebuilt.items()):
        candidates = {erratum: float(numbers[place]) for erratum, numbers in by_erratum.items()}
        least = table.below_one if abs(printed[place]) < 1 else 0.0
        tolerance = max(table.relative * abs(printed[place]), 0.5 * last_digit, least)
        status = judged(printed[place], value, candidates, tolerance)
        yield {"number": number, **status, "right": right.get(number)}


def judged(
    printed: float, rebuilt: float, by_erratum: Mapping[int, float], tolerance: float
) -> dict[str, object]:
    """Return whether a published number is rebuilt, explained by an erratum, or unexplained
    (`status`), with the numbers behind it.

    by_erratum: the number computed with each erratum's error; the one nearest to the printed number
    is returned, and explains it if equal. tolerance: largest difference that counts as equal.
    """
    comparison = {"printed": printed, "rebuilt": rebuilt, "ratio": rebuilt / printed}
    status = UNEXPLAINED
    if by_erratum:
        nearest = min(by_erratum, key=lambda erratum: abs(by_erratum[erratum] - printed))
        comparison |= {"as_erratum_says": by_erratum[nearest], "erratum": nearest}
        if abs(by_erratum[nearest] - printed) <= tolerance:
            status = f"erratum {nearest}"
    if abs(rebuilt - printed) <= tolerance:  # false for NaN
        status = EQUAL
    return comparison | {"status": status}


def _found(
    lookup: Lookup | None, tables: Mapping[str, pd.DataFrame], recording: str, row: str
) -> "pd.Series[float]":
    """Return the numbers of a published row in the study's tables, by joint or component; NaN where
    the study cannot rebuild them.
    """
    if lookup is None:
        return pd.Series(dtype=float)
    table = tables[lookup.table]
    column, cells = lookup.of(row)
    if "recording" in table:  # tables of fits to several have none
        table = table[table["recording"] == recording]
    numbers = table[lookup.number].unique()
    for name, value in cells.items():
        table = table[table[name] == value]
    return table.set_index(lookup.number)[column].reindex(numbers)


def _decimals(table: PrintedTable) -> int:
    """Return the largest number of decimals in a table."""
    numbers = chain.from_iterable(dict(table.values).values())
    texts = (np.format_float_positional(number, trim="-") for number in numbers)
    return max(len(text.partition(".")[2]) for text in texts)
