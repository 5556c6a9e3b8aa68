"""Tables of the report: rows of a study's tables in the lines and columns that they declare."""

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import pandas as pd

from ur5lib.report.page.document import UNDETERMINED_TEXT, Cell, DeclaredTable, Mark
from ur5lib.report.page.formats import power
from ur5lib.report.page.sentences import cell, filled, names, spoken

RowValues = dict[Hashable, Any]  # the values of a row by column
Place = tuple[Hashable, ...]  # values of the columns `across`
Line = dict[Place, RowValues]

EMPTY_CELL = Cell("–")


class Body(NamedTuple):
    """A table's header and rows."""

    header: list[str]
    rows: list[list[Cell]]


def tabulate(declared: DeclaredTable, rows: pd.DataFrame, further: RowValues) -> Body:
    """Return header and rows of a table; further: values for its templates.

    Left out are rows and columns of dashes alone. Without any declared column: all columns and
    rows, numbers to four digits.
    """
    if not declared.columns | declared.cells:
        return _whole(rows)
    if rows.empty:
        return Body([], [])
    places = [*_places(rows, declared.across)]
    lines = _lines(rows.to_dict("records"), declared, places)
    columns = [
        *_columns(declared.columns or {name: name for name in declared.lines}, lines, further),
        *_across(declared, places, lines, further),
        *_columns(declared.last, lines, further),
    ]
    named = [(title, [cell or EMPTY_CELL for cell in cells]) for title, cells in columns]
    filled_columns = [(title, cells) for title, cells in named if {*cells} != {EMPTY_CELL}]
    body = zip(*(cells for _, cells in filled_columns), strict=True)
    known = [[*row] for row in body if len(row) == 1 or {*row[1:]} != {EMPTY_CELL}]
    return Body([title for title, _ in filled_columns], known)


def _whole(rows: pd.DataFrame) -> Body:
    cells = [
        [Cell(power(value, 4) if isinstance(value, float) else str(value)) for value in row]
        for row in rows.itertuples(index=False)
    ]
    return Body([str(name).replace("_", " ") for name in rows], cells)


def _places(rows: pd.DataFrame, across: Sequence[str]) -> Iterator[Place]:
    """Yield the values of the columns that stand side by side, in their order."""
    combinations = {*zip(*(rows[name] for name in across), strict=True)} if across else {()}
    yield from (
        place for place in product(*(_ordered(rows, n) for n in across)) if place in combinations
    )


def _ordered(rows: pd.DataFrame, column: str) -> list[Hashable]:
    """Return the values of a column: those with names in the order of these, then the others."""
    values, ranked = dict.fromkeys(rows[column]), names(column)
    return [
        *(value for value in ranked if value in values),
        *(v for v in values if v not in ranked),
    ]


def _lines(
    records: Sequence[RowValues], declared: DeclaredTable, places: Sequence[Place]
) -> list[Line]:
    """Return the records of each line by their place; without `lines`, one line a record."""
    lines: dict[Place, Line] = {}
    for number, record in enumerate(records):
        key = tuple(record[name] for name in declared.lines) or (number,)
        lines.setdefault(key, {}).setdefault(tuple(record[n] for n in declared.across), record)
    rank = [*names(declared.lines[0])] if declared.lines else []
    keys = sorted(lines, key=lambda key: rank.index(key[0]) if key[0] in rank else len(rank))
    return [{place: lines[key][place] for place in places if place in lines[key]} for key in keys]


def _columns(
    templates: dict[str, str], lines: Sequence[Line], further: RowValues
) -> Iterator[tuple[str, list[Cell | None]]]:
    """Yield columns of the first record of each line."""
    first = [next(iter(line.values())) for line in lines]
    for title, template in templates.items():
        yield spoken(title), [_cell(template, further | record) for record in first]


def _across(
    declared: DeclaredTable, places: Sequence[Place], lines: Sequence[Line], further: RowValues
) -> Iterator[tuple[str, list[Cell | None]]]:
    """Yield columns of the records side by side, their smallest and largest value marked."""
    shown = next((own for own in declared.cells.values() if own.startswith(declared.marked)), "")
    marks = [_marks(line, declared.marked, shown, further) for line in lines]
    for place in places:
        heading = next(line[place] for line in lines if place in line)
        for title, template in declared.cells.items():
            marked = declared.marked and template.startswith(declared.marked)
            cells = [
                _cell(template, further | line[place], mark.get(place) if marked else None)
                if place in line
                else None
                for line, mark in zip(lines, marks, strict=True)
            ]
            yield filled(title, further | heading), cells


def _marks(line: Line, marked: str, shown: str, further: RowValues) -> dict[Place, Mark | None]:
    """Return the marks of a line, whose records are compared where only the last place differs.

    shown: template of the marked cells.
    """
    groups: dict[Place, dict[Place, tuple[float, str | None]]] = {}
    zero = math.inf
    for place, record in line.items() if marked else ():
        if pd.notna(record[marked]):
            text = cell(shown, further | record)
            groups.setdefault(place[:-1], {})[place] = record[marked], text
            zero = min(zero, record.get(f"zero_{marked}", math.inf))
    return {
        place: mark for values in groups.values() for place, mark in extremes(values, zero).items()
    }


def _cell(template: str, values: RowValues, mark: Mark | None = None) -> Cell | None:
    text = cell(template, values)
    return None if text is None else Cell(text, None if text == UNDETERMINED_TEXT else mark)


def extremes(
    values: Mapping[Place, tuple[float, str | None]], zero: float = math.inf
) -> dict[Place, Mark | None]:
    """Mark the lowest and the highest entry, of value and text, where its text is its own; no
    lowest one that `zero`, the error of an estimate of zero, beats.
    """
    marks: dict[Place, Mark | None] = dict.fromkeys(values)
    texts = [text for _, text in values.values()]
    low, high = (end(value for value, _ in values.values()) for end in (min, max))
    for place, (value, text) in values.items() if len({*texts}) > 1 else ():
        if texts.count(text) == 1 and value in (low, high):
            marks[place] = "highest" if value == high else "lowest" if value < zero else None
    return marks
