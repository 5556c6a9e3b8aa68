"""Delimited tables of numbers: parsed by pyarrow; damage is found, counted, located, left out."""

import gzip
import math
import re
import zlib
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv as pacsv

from ur5lib.errors import InputError
from ur5lib.recordings.quality import Device, Finding
from ur5lib.strict import expect_file

NOT_A_NUMBER = ["", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "null", "NULL"]
PREAMBLE = re.compile(rb"(?:[ \t]*(?:[#%][^\n]*|sep=.)?\n)*")  # blanks, comments, Excel's "sep=;"
# What spreadsheet programs make of numbers: dates, times, thousands, cells that are too narrow.
SPREADSHEET = re.compile(r"###|\d:\d|\d[./-]\d+[./-]\d|\d[. -]+[A-Z][a-z]{2}|[A-Z][a-z]{2}[. -]+\d")
BLOCK = 1 << 16  # bytes; where a line is damaged, blocks of this size are read line by line
TAIL = 20  # lines that tell how the last one must look


def read_numbers(
    path: Path, names: list[str] | None, device: Device, findings: list[Finding]
) -> pd.DataFrame:
    """The whole rows of a delimited table; what is not a row is left out and found.

    names: of the columns, in order; None takes them from the header line. Comma, semicolon, tab or
    blank separate; after a semicolon, a comma is a decimal point. Returns float64, NaN where a
    cell says so or is empty. Raises InputError when the file cannot be read, is not text, has no
    header where one is needed, or fewer lines that fit than others.
    """
    data = _read_text(path, device, findings)
    top = PREAMBLE.match(data).end()  # type: ignore[union-attr]
    first = data[top : _end_of_line(data, top)].strip()
    delimiter = next((mark for mark in (b";", b",", b"\t") if mark in first), b" ")
    if delimiter == b";" and b"," in data:
        findings.append(
            Finding(device, "decimal commas", "note", 1, f"{path.name}: read as points")
        )
        data = data.replace(b",", b".")
    if names is None or _is_header(first, delimiter, len(names)):
        names = names or _header_names(path, first, delimiter)
        top = _end_of_line(data, top)
    end = _end_of_rows(path, data, top, delimiter, device, findings)
    tables, damaged = _parse(data, top, end, names, delimiter)
    table = pa.concat_tables(tables).to_pandas()
    if damaged:
        first = data[damaged[0] : _end_of_line(data, damaged[0])].rstrip(b"\n")
        fault = _fault(first.split(delimiter), len(names))
        lines = [_line(data, place) for place in damaged[:5]]
        _tell_damaged(path, lines, len(damaged), fault, table, device, findings)
    return table


def drop_untimed(
    table: pd.DataFrame, path: Path, device: Device, findings: list[Finding]
) -> pd.DataFrame:
    """The rows that have a `time`."""
    timed = np.isfinite(table["time"].to_numpy(float))
    if timed.all():
        return table
    detail = f"{path.name}: rows without a time are left out"
    findings.append(Finding(device, "missing times", "warning", int((~timed).sum()), detail))
    return table[timed].reset_index(drop=True)


def first_line(path: Path) -> str:
    """How a file begins, for messages."""
    with path.open("rb") as stream:
        return repr(stream.readline(60).decode(errors="replace").strip())


def _read_text(path: Path, device: Device, findings: list[Finding]) -> bytes:
    expect_file(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"{path} is missing or cannot be read ({error.strerror}); "
            "put it there or take the recording out of the study"
        ) from error
    if data.startswith(b"\x1f\x8b"):
        findings.append(Finding(device, "compressed file", "note", 1, f"{path.name}: unpacked"))
        data = _unpack(path, data)
    if data.startswith(b"\xef\xbb\xbf"):
        findings.append(Finding(device, "byte-order mark", "note", 1, f"{path.name}: left out"))
        data = data[3:]
    # Further down, a lost block of a disk may read as zeros: that is a damaged line.
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") or b"\0" in data[:1000]:
        raise InputError(f"{path}, line 1: is not text; save it as plain CSV (UTF-8)")
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data.replace(b'"', b"") if b'"' in data else data


def _unpack(path: Path, data: bytes) -> bytes:
    try:
        return gzip.decompress(data)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path} is a damaged gzip file; get a fresh copy of it") from error


def _end_of_line(data: bytes, start: int) -> int:
    """Where the next line begins."""
    return data.find(b"\n", start) + 1 or len(data)


def _end_of_rows(
    path: Path, data: bytes, top: int, delimiter: bytes, device: Device, findings: list[Finding]
) -> int:
    """Where the last whole line ends."""
    last = max(top, data.rfind(b"\n") + 1)
    if last == len(data) or _ends_whole(data[top:last], data[last:], delimiter):
        return len(data)
    detail = f"{path.name}, line {_line(data, last)}: ends in the middle, left out"
    findings.append(Finding(device, "torn last line", "note", 1, detail))
    return last


def _ends_whole(before: bytes, last: bytes, delimiter: bytes) -> bool:
    """Whether a last line without an end is formed to the last digit like all those before."""
    models = before.rsplit(b"\n", TAIL + 1)[-TAIL - 1 : -1]
    forms = {_form(model, delimiter) for model in models}
    return forms == {_form(last, delimiter)} and _form(last, delimiter)[1] > 0


def _form(line: bytes, delimiter: bytes) -> tuple[int, int]:
    """How many cells a line has, and how many decimals its last one."""
    cells = line.split(delimiter)
    return len(cells), len(cells[-1].strip().partition(b".")[2])


def _line(data: bytes, place: int) -> int:
    """The number of the line that begins at a place."""
    return data.count(b"\n", 0, place) + 1


def _number(cell: bytes) -> float:
    """A cell's number. Raises ValueError when it is none; an empty cell is NaN."""
    text = cell.strip().decode(errors="replace")
    if "_" in text:  # Python reads 1_000
        raise ValueError(text)
    return math.nan if text in NOT_A_NUMBER else float(text)


def _is_cell(cell: bytes) -> bool:
    """Whether a cell may stand in a row: a number, or none."""
    try:
        _number(cell)
    except ValueError:
        return False
    return True


def _is_number(cell: bytes) -> bool:
    return _is_cell(cell) and math.isfinite(_number(cell))


def _is_header(line: bytes, delimiter: bytes, count: int) -> bool:
    """A line of as many names as there are columns, none of them a number."""
    cells = [cell.strip() for cell in line.split(delimiter)]
    return len(cells) == count and all(re.match(rb"[A-Za-z#]", cell) for cell in cells)


def _header_names(path: Path, line: bytes, delimiter: bytes) -> list[str]:
    cells = line.split(delimiter)
    if _is_number(cells[0]):
        raise InputError(f"{path}, line 1: is no header; name the columns (format table-csv)")
    names = [cell.decode(errors="replace").strip() for cell in cells]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(
            f"{path}, line 1: names the column {twice[0]!r} twice; give each column its own name"
        )
    return names


def _parse(
    data: bytes, start: int, end: int, names: list[str], delimiter: bytes
) -> tuple[list[pa.Table], list[int]]:
    """Rows between two places of a file, and where its damaged lines begin.

    By halves, so that a few damaged lines do not make a long file slow.
    """
    try:
        return [_parse_fast(memoryview(data)[start:end], names, delimiter)], []
    except pa.ArrowInvalid:
        middle = data.find(b"\n", (start + end) // 2, end) + 1
        if end - start <= BLOCK or not start < middle < end:
            return _parse_lines(data, start, end, names, delimiter)
    halves = [_parse(data, *half, names, delimiter) for half in ((start, middle), (middle, end))]
    return halves[0][0] + halves[1][0], halves[0][1] + halves[1][1]


def _parse_fast(text: memoryview, names: list[str], delimiter: bytes) -> pa.Table:
    if not text.nbytes:
        return _table(np.empty((0, len(names))), names)
    return pacsv.read_csv(
        pa.BufferReader(text),
        read_options=pacsv.ReadOptions(column_names=names),
        parse_options=pacsv.ParseOptions(delimiter=delimiter.decode(), quote_char=False),
        convert_options=pacsv.ConvertOptions(
            column_types=dict.fromkeys(names, pa.float64()), null_values=NOT_A_NUMBER
        ),
    )


def _parse_lines(
    data: bytes, start: int, end: int, names: list[str], delimiter: bytes
) -> tuple[list[pa.Table], list[int]]:
    rows, damaged, place = [], [], start
    for line in data[start:end].split(b"\n"):
        try:
            row = [_number(cell) for cell in line.split(delimiter)]
        except ValueError:
            row = []
        if len(row) == len(names):
            rows.append(row)
        elif line.strip():
            damaged.append(place)
        place += len(line) + 1
    return [_table(np.array(rows).reshape(-1, len(names)), names)], damaged


def _table(rows: np.ndarray, names: list[str]) -> pa.Table:
    return pa.table([pa.array(column, pa.float64()) for column in rows.T], names=names)


def _fault(cells: list[bytes], width: int) -> str:
    """Why a line is damaged."""
    if len(cells) != width:
        return f"{len(cells)} cells"
    wrong = next(cell for cell in cells if not _is_cell(cell)).strip().decode(errors="replace")
    who = ", a spreadsheet program may have changed it" if SPREADSHEET.search(wrong) else ""
    return f"{wrong[:20]!r} is no number{who}"


def _tell_damaged(
    path: Path,
    lines: list[int],
    count: int,
    fault: str,
    table: pd.DataFrame,
    device: Device,
    findings: list[Finding],
) -> None:
    """Tell which lines are damaged, and what is wrong with the first. lines: the first five.

    Raises InputError when most lines are damaged: then the columns are others, not the file.
    """
    width = len(table.columns)
    if table.empty:
        raise InputError(
            f"{path}, line {lines[0]}: holds no complete row of {width} numbers ({fault}), nor "
            "does any other line; record it again, or name its `columns` in the study"
        )
    if len(table) < count:
        raise InputError(
            f"{path}, line {lines[0]}: is not {width} numbers ({fault}), nor are "
            f"{count} of {len(table) + count} lines; correct the file or its columns"
        )
    more = f" and {count - 5} more" if count > 5 else ""
    where = f"{path.name}, line {', '.join(map(str, lines))}{more} ({fault})"
    detail = f"{where}: not {width} numbers, left out"
    findings.append(Finding(device, "damaged lines", "warning", count, detail))
