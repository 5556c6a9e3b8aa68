"""Numbers in prose that are cells of docs/data, so that one thing has one value.

    errs by 6.6<!-- leaderboard: F̂ᵐᵃᵖ, no | No9 Singularity Free ForceSensor --> N

has the first number of the cell in data/leaderboard.csv whose row begins with "F̂ᵐᵃᵖ, no".
"""

import csv
import re
from pathlib import Path

DATA = Path(__file__).parents[2] / "docs" / "data"
NUMBER = r"[−-]?\d[\d.,]*(?<![.,])"
CELL = re.compile(rf"({NUMBER})( %)?<!-- (\w+): (.+?) \| (.+?) -->")


def with_cells(text: str, data: Path = DATA) -> str:
    """Return a page whose marked numbers are those of their cells. Raises ValueError where the
    table has no such cell, or several.
    """

    def now(marked: re.Match[str]) -> str:
        number, unit, table, row, column = marked.groups()
        found = re.search(NUMBER, cell(data / f"{table}.csv", row, column))
        if not found:
            raise ValueError(f"{table}.csv: no number in row {row!r}, column {column!r}")
        return f"{found[0]}{unit or ''}{marked[0][len(number) + len(unit or '') :]}"

    return CELL.sub(now, text)


def cell(table: Path, row: str, column: str) -> str:
    """Return the cell of the one row whose first cells, joined by ", ", begin with `row`."""
    with table.open(encoding="utf-8", newline="") as lines:
        head, *rows = csv.reader(lines)
    found = [cells for cells in rows if f"{', '.join(cells)}, ".startswith(f"{row}, ")]
    if len(found) != 1 or column not in head:
        raise ValueError(f"{table.name}: {len(found)} rows {row!r}, columns {head}, not {column!r}")
    return found[0][head.index(column)]
