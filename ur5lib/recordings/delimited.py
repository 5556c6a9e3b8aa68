"""Reader of delimited tables of numbers (pyarrow) that counts, locates and skips damaged lines."""

import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv as pacsv

from ur5lib.channels import CHANNELS, channels_of
from ur5lib.errors import InputError
from ur5lib.recordings.limits import expect_room, most_columns, too_large
from ur5lib.recordings.recording import DAY
from ur5lib.recordings.text_blocks import text_blocks
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.timeseries.arrays import Array, Labels

ISO_DATE = re.compile(rb"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")
TIME_OF_DAY = re.compile(rb"\d{1,2}:\d\d:\d\d(?:[:.,]\d{1,9})?$")  # Excel's form, LabVIEW's
NAN_SPELLINGS = ["", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "null", "NULL", "None"]
SAMPLE_ROWS = 20  # this many rows show what a column contains
PREAMBLE = re.compile(rb"(?:[ \t]*(?:[#%][^\n]*|sep=.)?\n)*")  # blank, comment, Excel's "sep=;"
# What spreadsheet programs turn numbers into: dates, times, thousands, ### in narrow cells.
SPREADSHEET_CELL = re.compile(
    r"###|\d:\d|\d[./-]\d+[./-]\d|\d[. -]+[A-Z][a-z]{2}|[A-Z][a-z]{2}[. -]+\d"
)
BLOCK_BYTES = 1 << 16  # bytes; a block of this size with a damaged line is read line by line
TAIL_LINES = 20  # lines that show what a complete last line looks like
LEAD_LINES = 60  # lines that show where a table begins
# A table without names that is wider, and so much wider than long, is transposed.
MIN_SAMPLES, SAMPLES_A_ROW = 100, 5
BYTES_OF_CELL = 64  # of one apart, while a table is turned
MIN_LEAD_COUNT = 6  # rows and cells that a table has at least
SEPARATORS_BESIDE_COMMAS = (b";", b"\t")  # with these separators, commas are decimal points
UNNAMED_COLUMN = ""  # the column behind the last separator
MAX_NAMED_LINES = 5  # damaged lines that are named
MAX_DAMAGED_LINES = 1_000_000  # lines, before the file is given up
SEPARATORS = b",", b";", b"\t", b" "


class Form(NamedTuple):
    """The form of a delimited table: names of its columns, their delimiter, and which contain dates
    or other text.
    """

    names: list[str]
    delimiter: bytes
    dates: Sequence[str] = ()
    text: Sequence[str] = ()

    def numbers(self) -> list[str]:
        """Return the names of the columns that are read as numbers: all but text."""
        return [name for name in self.names if name not in self.text]


class TextTable:
    """A delimited text table, of which the beginning was read.

    The separator is a comma, semicolon, tab or blank; with semicolons and tabs, commas are decimal
    points. cells: of the line with the columns' names or, without names, of the first row; below:
    cells of the line under it.
    """

    def __init__(self, log: Log) -> None:
        """Read the beginning. Raises InputError when the file cannot be read, is not text, or
        contains more than may be read.
        """
        self.log, self._blocks = log, _table_blocks(log)
        self._first = next(self._blocks)
        self._top, self._line, self._comment = _first_row(self._first, log.path)
        self._delimiter = _delimiter(self._line)
        second = self._first[self._second() :].partition(b"\n")[0]
        lines = (self._comment, self._line) if self._comment else (self._line, second)
        self.cells, self.below = ([*map(_text, own.split(self._delimiter))] for own in lines)

    def has_names(self) -> bool:
        """Return whether the first line has names: not all of its cells are numbers or dates."""
        cells = [cell.replace(",", ".").encode() for cell in self.cells]
        return not all(_is_cell(cell) or _is_stamp(cell) for cell in cells)

    def rows(self, names: list[str] | None) -> tuple[pd.DataFrame, Labels]:
        """Return the complete rows (float64) and the number of each from 0 (N,), skipped lines
        counted.

        names: of the columns, in order; None takes them from the header line. Damaged lines are
        skipped and reported. Empty cells and the text NaN are NaN, dates are seconds since 1970;
        columns of other text are left out unless they are named like a channel. Raises InputError
        when the table lacks a required header, has mostly damaged lines, or contains more than may
        be read.
        """
        log, (top, form) = self.log, self._form(names)
        tables, damaged, fault, line = list[pa.Table](), np.empty(0, int), "", 1
        above, count = 1 + self._first.count(b"\n", 0, top), 0
        for block in chain([self._first], self._blocks):
            data = _with_points(block, form, log)
            end = _end_of_rows(data, top, line, form, log)
            parsed, places = _parse(data, top, end, form)
            tables += parsed
            count += sum(part.num_rows for part in parsed)
            expect_room(log.path, count * len(form.numbers()))
            if len(places):
                fault = fault or _fault(data, int(places[0]), form)
                newlines = np.flatnonzero(np.frombuffer(data, np.uint8) == ord("\n"))
                damaged = np.append(damaged, line + np.searchsorted(newlines, places))
                if len(damaged) > max(count, MAX_DAMAGED_LINES):
                    break
            top, line = 0, line + data.count(b"\n")
        table = _joined(tables)
        if len(damaged):
            _report_damaged(log, damaged, fault, table, len(form.names))
        lines = np.arange(above, above + len(table) + len(damaged))
        return table, np.setdiff1d(lines, damaged)[: len(table)] - above  # blank lines are no rows

    @property
    def delimiter(self) -> bytes:
        """Return what separates cells."""
        return self._delimiter

    def above(self, names: list[str] | None) -> int:
        """Return the number of lines above the rows; names: as of `rows`."""
        return self._first.count(b"\n", 0, self._form(names)[0])

    def _form(self, names: list[str] | None) -> tuple[int, Form]:
        """Return the offset at which the rows begin, and the table's form; names: None for those of
        the header.
        """
        top, delimiter, header = self._top, self._delimiter, self._comment
        if not header and (names is None or _is_header(self._line, delimiter, len(names))):
            header, top = self._line, self._second()
        names = names or _header_names(self.log.path, header, delimiter)
        lines = self._first[top:].split(b"\n", SAMPLE_ROWS)[:SAMPLE_ROWS]
        if delimiter in SEPARATORS_BESIDE_COMMAS:
            lines = [line.replace(b",", b".") for line in lines]
        cells = [line.split(delimiter) for line in lines if line.strip()]
        if cells and all(len(row) == len(names) + 1 and not row[-1].strip() for row in cells):
            names = [*names, UNNAMED_COLUMN]  # behind a separator at the end of each row
        rows = [row for row in cells if len(row) == len(names)]
        dates, text = text_columns(rows, names)
        return top, Form(names, delimiter, dates, [*text, UNNAMED_COLUMN])

    def _second(self) -> int:
        """Return the offset at which the line under the first one begins."""
        return _end_of_line(self._first, self._top)


def read_numbers(log: Log, names: list[str] | None) -> pd.DataFrame:
    """Return the complete rows of a delimited table; names: as of `TextTable.rows`."""
    return TextTable(log).rows(names)[0]


def drop_untimed(table: pd.DataFrame, log: Log) -> pd.DataFrame:
    """Return the rows with a finite `time`; the others are reported."""
    timed = np.isfinite(table["time"].to_numpy(float))
    meaning = "rows without a time are discarded"
    log.add(Found.MISSING_TIMES, "warning", np.count_nonzero(~timed), meaning)
    return table if timed.all() else table[timed].reset_index(drop=True)


def first_line(path: Path) -> str:
    """Return the beginning of a file, for messages."""
    with path.open("rb") as stream:
        return repr(stream.readline(60).decode(errors="replace").strip())


def _table_blocks(log: Log) -> Iterator[bytes]:
    """Yield the blocks of a table; one that has a row for each channel and a column for each sample
    is transposed.

    Raises InputError where these rows differ in length.
    """
    blocks = text_blocks(log)
    first = next(blocks)
    lines = [line for line in first.split(b"\n", LEAD_LINES) if line.strip()]
    mark = _delimiter(lines[0]) if lines else b","
    if _is_turned(lines, mark):
        for block in blocks:
            first += block
        expect_room(log.path, BYTES_OF_CELL / 8 * first.count(mark))
        between = None if mark == b" " else mark
        rows = [line.split(between) for line in first.split(b"\n") if line.strip()]
        if len({*map(len, rows)}) > 1:
            raise InputError(
                f"{log.path}: its lines differ in length, with a row of samples for each column; "
                "record it again, or copy it again"
            )
        meaning = f"turned, for it has a row of {len(rows[0]):,} samples for each column"
        log.add(Found.TURNED_TABLE, "note", 1, meaning)
        first = b"\n".join(map(mark.join, zip(*rows, strict=True))) + b"\n"
    yield first
    yield from blocks


def _is_turned(lines: Sequence[bytes], mark: bytes) -> bool:
    """Return whether a table is to be transposed: far wider than long, with numbers or dates in its
    first line.
    """
    cells = lines[0].split(mark) if lines else []
    wide = len(cells) >= max(MIN_SAMPLES, SAMPLES_A_ROW * len(lines)) and len(lines) < LEAD_LINES
    point = b"," if mark in SEPARATORS_BESIDE_COMMAS else b"."
    return wide and all(
        _is_cell(cell.replace(point, b".")) or ISO_DATE.search(cell) for cell in cells[1:]
    )


def _text(cell: bytes) -> str:
    return cell.decode(errors="replace").strip()


def _first_row(data: bytes, path: Path) -> tuple[int, bytes, bytes]:
    """Return the offset of the first line that is neither blank nor a comment, that line, and the
    comment above it if that names as many columns, else b"".

    Raises InputError where one of the first lines has more cells than a table has columns.
    """
    top = PREAMBLE.match(data).end()  # type: ignore[union-attr]
    lines = data[top:].split(b"\n", LEAD_LINES)[:LEAD_LINES]
    most = most_columns()
    if any(line.count(mark) >= most for line in lines for mark in SEPARATORS):
        raise too_large(path, f"{most:,} columns")
    top += _length_of_title(lines)
    first, below = data[top : _end_of_line(data, top)].rstrip(), data[_end_of_line(data, top) :]
    mark, row = _delimiter(first.strip()), below.partition(b"\n")[0]
    counts = {row.count(mark), row.rstrip().count(mark)}  # its last cells may be empty
    if not first.startswith(mark) or first.count(mark) not in counts:
        first = first.strip()  # else a blank or a tab is behind the index, which has no name
    comment = data[:top].strip().rpartition(b"\n")[2].lstrip(b"#% \t").strip()
    cells = first.split(mark)
    names = comment.split(mark) if comment.count(mark) == len(cells) - 1 else []
    header = len(names) > 1 and _is_cell(cells[0]) and not any(map(_is_cell, names))
    return top, first, comment if header else b""


def _length_of_title(lines: list[bytes]) -> int:
    """Return the number of bytes above a table's header, in lines with less than half of its cells.

    0 where there is no header below them.
    """
    forms = [(_delimiter(line), line.count(_delimiter(line)) + 1) for line in lines if line]
    (mark, width), count = Counter(forms).most_common(1)[0] if forms else ((b",", 0), 0)
    if count < MIN_LEAD_COUNT or width < MIN_LEAD_COUNT:
        return 0
    first = next(k for k, line in enumerate(lines) if line.count(mark) + 1 == width)
    cells = [cell for cell in lines[first].split(mark) if cell.strip()]  # an index has no name
    named = len(cells) >= width - 1 and not any(map(_is_cell, cells))
    short = all(2 * line.count(mark) + 2 < width for line in lines[:first])
    return sum(len(line) + 1 for line in lines[:first]) if named and short else 0


def _with_points(block: bytes, form: Form, log: Log) -> bytes:
    """Return a block of lines with decimal commas replaced by points."""
    if form.delimiter not in SEPARATORS_BESIDE_COMMAS or b"," not in block:
        return block
    own: list[Finding] = []
    Log(log.path, log.device, own).add(Found.DECIMAL_COMMAS, "note", 1, "read as decimal points")
    log.findings.extend(note for note in own if note not in log.findings)  # once for all blocks
    return block.replace(b",", b".")


def _delimiter(line: bytes) -> bytes:
    """Return what separates the cells of a line: a tab, if no cell has more than one comma."""
    tabbed = b"\t" in line and line.count(b",") <= line.count(b"\t") + 1
    marks = (b";", b"\t", b",") if tabbed else (b";", b",", b"\t")
    return next((mark for mark in marks if mark in line), b" ")


def _end_of_line(data: bytes, start: int) -> int:
    """Return the offset at which the next line begins."""
    return data.find(b"\n", start) + 1 or len(data)


def _end_of_rows(data: bytes, top: int, line: int, form: Form, log: Log) -> int:
    """Return the offset at which the last complete line ends; line: number of the block's first
    line, for the finding.
    """
    last = max(top, data.rfind(b"\n") + 1)
    if last == len(data) or _ends_whole(data[top:last], data[last:], form.delimiter):
        return len(data)
    number = str(line + data.count(b"\n", 0, last))
    log.add(Found.TORN_LAST_LINE, "note", 1, "last line is cut off, skipped", number)
    return last


def _ends_whole(before: bytes, last: bytes, delimiter: bytes) -> bool:
    """Return whether a last line without a newline has the same form as the lines before it."""
    models = before.rsplit(b"\n", TAIL_LINES + 1)[-TAIL_LINES - 1 : -1]
    forms = {_cells(model, delimiter) for model in models}
    return forms == {_cells(last, delimiter)} and _cells(last, delimiter)[1] > 0


def _cells(line: bytes, delimiter: bytes) -> tuple[int, int]:
    """Return how many cells a line has, and how many decimals its last cell has."""
    last = line.rpartition(delimiter)[2].strip()
    return line.count(delimiter) + 1, len(last.partition(b".")[2])


def _is_cell(cell: bytes) -> bool:
    """Return whether a cell contains a number or is empty."""
    return number_in(cell) is not None


def _is_header(line: bytes, delimiter: bytes, count: int) -> bool:
    """Return whether a line consists of `count` names."""
    cells = [cell.strip() for cell in line.split(delimiter)]
    named = [*filter(None, cells[:1]), *cells[1:]]  # an index has no name
    return len(cells) == count and all(re.match(rb"[A-Za-z#_/]", cell) for cell in named)


def _header_names(path: Path, line: bytes, delimiter: bytes) -> list[str]:
    cells = line.split(delimiter)
    if (first := number_in(cells[0])) is not None and np.isfinite(first):
        raise InputError(
            f"{path}, line 1: no header; use format table-csv and name the columns in the study"
        )
    names = [cell.decode(errors="replace").strip() for cell in cells]
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise InputError(
            f"{path}, line 1: column {twice[0]!r} appears twice; give each column its own name"
        )
    return names


def _parse(data: bytes, start: int, end: int, form: Form) -> tuple[list[pa.Table], Labels]:
    """Parse the rows between two offsets; return them and the offsets of damaged lines.

    The range is bisected, so that a few damaged lines do not slow down a long file.
    """
    try:
        return [_parse_fast(memoryview(data)[start:end], form)], np.empty(0, int)
    except pa.ArrowInvalid:
        middle = data.find(b"\n", (start + end) // 2, end) + 1
        if end - start <= BLOCK_BYTES or not start < middle < end:
            return _parse_lines(data, start, end, form)
    halves = [_parse(data, *half, form) for half in ((start, middle), (middle, end))]
    return halves[0][0] + halves[1][0], np.concatenate([halves[0][1], halves[1][1]])


def _joined(tables: list[pa.Table]) -> pd.DataFrame:
    """Return the tables as one frame, copied column by column, so that a long table is in memory
    only once.
    """
    table = pa.concat_tables(tables)
    tables.clear()
    names, waiting, columns = table.column_names, table.columns[::-1], {}
    del table
    for name in names:
        chunks = waiting.pop().chunks
        columns[name] = np.concatenate([chunk.to_numpy(zero_copy_only=False) for chunk in chunks])
        del chunks
        pa.default_memory_pool().release_unused()
    return pd.DataFrame(columns, copy=False)


def _parse_fast(text: memoryview, form: Form) -> pa.Table:
    if not text.nbytes:
        return _table(np.empty((0, len(form.numbers()))), form.numbers())
    kinds = dict.fromkeys(form.names, pa.float64()) | dict.fromkeys(form.dates, pa.string())
    table = pacsv.read_csv(
        pa.BufferReader(text),
        read_options=pacsv.ReadOptions(column_names=form.names, block_size=text.nbytes),
        parse_options=pacsv.ParseOptions(delimiter=form.delimiter.decode(), quote_char=False),
        convert_options=pacsv.ConvertOptions(
            column_types=kinds, null_values=NAN_SPELLINGS, include_columns=form.numbers()
        ),
    )
    for name in form.dates:
        seconds = pa.array(seconds_of_dates(table.column(name).to_pandas()), pa.float64())
        table = table.set_column(table.schema.get_field_index(name), name, seconds)
    return table


def _parse_lines(data: bytes, start: int, end: int, form: Form) -> tuple[list[pa.Table], Labels]:
    rows, damaged, place = [], list[int](), start
    for line in data[start:end].split(b"\n"):
        whole = line.count(form.delimiter) + 1 == len(form.names)
        row = _numbers(line.split(form.delimiter), form) if whole else [None]
        if None not in row:
            rows.append(row)
        elif line.strip():
            damaged.append(place)
        place += len(line) + 1
    table = _table(np.array(rows).reshape(-1, len(form.numbers())), form.numbers())
    return [table], np.array(damaged, int)


def _numbers(cells: list[bytes], form: Form) -> list[float | None]:
    """Return a row's numbers, None for another cell in a column of numbers."""
    return [
        seconds_of_date(cell) if name in form.dates else number_in(cell)
        for name, cell in zip(form.names, cells, strict=True)
        if name not in form.text
    ]


def _table(rows: np.ndarray, names: list[str]) -> pa.Table:
    return pa.table([pa.array(column, pa.float64()) for column in rows.T], names=names)


def _fault(data: bytes, place: int, form: Form) -> str:
    """Return why the line that begins at an offset is damaged."""
    line = data[place : _end_of_line(data, place)].rstrip(b"\n")
    if (count := line.count(form.delimiter) + 1) != len(form.names):
        listed = "; give each number of a list its own column" if b"[" in line else ""
        return f"it has {count} cells{listed}"
    cells = line.split(form.delimiter)
    read = [
        cell
        for name, cell in zip(form.names, cells, strict=True)
        if name not in form.text and not (name in form.dates and _is_stamp(cell))
    ]
    wrong = next(cell for cell in read if not _is_cell(cell)).strip().decode(errors="replace")
    cause = "; a spreadsheet program may have changed it" if SPREADSHEET_CELL.search(wrong) else ""
    return f"{wrong[:20]!r} is not a number{cause}"


def _report_damaged(log: Log, damaged: Labels, fault: str, table: pd.DataFrame, width: int) -> None:
    """Report which lines are damaged and what is wrong with the first.

    Raises InputError when most lines are damaged: then the columns differ from those declared.
    """
    count, first = len(damaged), int(damaged[0])
    if table.empty:
        raise InputError(
            f"{log.path}, line {first}: expected {width} numbers ({fault}), and no other line "
            "fits either; correct `columns` in the study, or record it again"
        )
    if len(table) < count:
        raise InputError(
            f"{log.path}, line {first}: expected {width} numbers ({fault}); {count} of "
            f"{len(table) + count} lines do not fit; correct the file, or `columns` in the study"
        )
    named = ", ".join(map(str, damaged[:MAX_NAMED_LINES]))
    more = f" and {count - MAX_NAMED_LINES} more" if count > MAX_NAMED_LINES else ""
    place = f"{named}{more} ({fault})"
    log.add(Found.DAMAGED_LINES, "warning", count, f"expected {width} numbers, skipped", place)


def number_in(cell: bytes) -> float | None:
    """Return a cell's number, NaN for an empty cell, None for anything else."""
    text = cell.strip().decode(errors="replace")
    if text in NAN_SPELLINGS:
        return math.nan
    try:
        return None if "_" in text else float(text)  # float() would accept 1_000
    except ValueError:
        return None


def text_columns(
    rows: Sequence[Sequence[bytes]], names: Sequence[str]
) -> tuple[list[str], list[str]]:
    """Return the names of the columns of dates, and of those of other text that no channel needs.

    rows: cells of the first rows, of which the first may have units. Both are empty if no column
    contains numbers.
    """
    columns = dict(zip(names, zip(*rows, strict=True), strict=False))
    worded = [name for name, cells in columns.items() if _is_text(cells)]
    if len(worded) == len(columns):
        return [], []
    dates = [name for name in worded if all(map(_is_stamp, columns[name][1:] or columns[name]))]
    units = {name: [CHANNELS[found].unit for found in channels_of(name)] for name in worded}
    modes = [name for name in worded if name != "timestamp" and {*units[name]} <= {"1"}]
    return dates, [name for name in modes if name not in dates]


def _is_stamp(cell: bytes) -> bool:
    """Return whether a cell contains a date with a time, or the time of a day."""
    return bool(ISO_DATE.match(cell.strip()) or TIME_OF_DAY.match(cell.strip()))


def _is_text(cells: Sequence[bytes]) -> bool:
    """Return whether cells contain text and no number."""
    found = [*map(number_in, cells)]
    return None in found and all(value is None or np.isnan(value) for value in found)


def seconds_of_dates(dates: pd.Series) -> Array:
    """Return the seconds since 1970 (N,) of ISO dates, in UTC if they name no zone; NaN for others.

    Times of day, as `12:30:05:250000`, become seconds since the first midnight, also beyond the
    next one.
    """
    if dates.str.match(TIME_OF_DAY.pattern.decode()).any():
        text = dates.str.strip().str.replace(r"^(\d+:\d+:\d+)[:,]", r"\1.", regex=True)
        since = pd.to_timedelta(text, errors="coerce").dt.total_seconds().to_numpy()
        return since + DAY * np.cumsum(np.nan_to_num(np.diff(since, prepend=since[:1])) < -DAY / 2)
    stamps = pd.to_datetime(dates, format="ISO8601", utc=True, errors="coerce")
    counted = stamps.astype("datetime64[ns, UTC]").astype("int64").to_numpy() * 1e-9
    return np.where(stamps.isna(), np.nan, counted)


def seconds_of_date(cell: bytes) -> float | None:
    """Return the seconds of one date or time of day, as `seconds_of_dates` does; None for other
    text.
    """
    if TIME_OF_DAY.match(cell.strip()):
        return float(seconds_of_dates(pd.Series([cell.strip().decode()]))[0])
    try:
        stamp = datetime.fromisoformat(cell.strip().decode(errors="replace"))
    except ValueError:
        return None
    return (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp()
