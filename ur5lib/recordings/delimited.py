"""Reader of delimited tables of numbers (pyarrow) that counts, locates and skips damaged lines."""

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
PREAMBLE = re.compile(rb"(?:[ \t]*(?:[#%][^\n]*|sep=.)?\n)*")  # blank, comment, Excel's "sep=;"
# What spreadsheet programs turn numbers into: dates, times, thousands, ### in narrow cells.
SPREADSHEET = re.compile(r"###|\d:\d|\d[./-]\d+[./-]\d|\d[. -]+[A-Z][a-z]{2}|[A-Z][a-z]{2}[. -]+\d")
BLOCK = 1 << 16  # bytes; a block of this size with a damaged line is read line by line
TAIL = 20  # lines that show what a complete last line looks like


def read_numbers(
    path: Path, names: list[str] | None, device: Device, findings: list[Finding]
) -> pd.DataFrame:
    """Return the complete rows of a delimited table; other lines are skipped and reported.

    names: of the columns, in order; None takes them from the header line. The separator is a
    comma, semicolon, tab or blank; where it is a semicolon, commas are decimal points. Returns
    float64, with NaN for empty cells and cells that say NaN. Raises InputError when the file cannot
    be read, is not text, lacks a required header, or most of its lines are not complete rows.
    """
    data = _read_text(path, device, findings)
    top = PREAMBLE.match(data).end()  # type: ignore[union-attr]
    first = data[top : _end_of_line(data, top)].strip()
    delimiter = _delimiter(first)
    if delimiter == b";" and b"," in data:
        findings.append(
            Finding(device, "decimal commas", "note", 1, f"{path.name}: read as decimal points")
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
        _report_damaged(path, lines, len(damaged), fault, table, device, findings)
    return table


def drop_untimed(
    table: pd.DataFrame, path: Path, device: Device, findings: list[Finding]
) -> pd.DataFrame:
    """Return the rows that have a `time`."""
    timed = np.isfinite(table["time"].to_numpy(float))
    if timed.all():
        return table
    detail = f"{path.name}: rows without a time are discarded"
    findings.append(Finding(device, "missing times", "warning", int((~timed).sum()), detail))
    return table[timed].reset_index(drop=True)


def first_line(path: Path) -> str:
    """Return the beginning of a file, for messages."""
    with path.open("rb") as stream:
        return repr(stream.readline(60).decode(errors="replace").strip())


def first_cells(path: Path) -> list[str]:
    """Return the cells of a table's first line, below comments. Raises InputError as reading it."""
    data = _read_text(path, "robot", [])
    top = PREAMBLE.match(data).end()  # type: ignore[union-attr]
    first = data[top : _end_of_line(data, top)].strip()
    delimiter = _delimiter(first)
    return [cell.decode(errors="replace").strip() for cell in first.split(delimiter)]


def _delimiter(line: bytes) -> bytes:
    return next((mark for mark in (b";", b",", b"\t") if mark in line), b" ")


def _read_text(path: Path, device: Device, findings: list[Finding]) -> bytes:
    expect_file(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"{path} is missing or cannot be read ({error.strerror}); "
            "add the file, or remove the recording from the study"
        ) from error
    if data.startswith(b"\x1f\x8b"):
        findings.append(Finding(device, "compressed file", "note", 1, f"{path.name}: decompressed"))
        data = _unpack(path, data)
    if data.startswith(b"\xef\xbb\xbf"):
        findings.append(Finding(device, "byte-order mark", "note", 1, f"{path.name}: ignored"))
        data = data[3:]
    # Zeros further down may be a lost disk block: that is a damaged line.
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") or b"\0" in data[:1000]:
        raise InputError(f"{path}, line 1: not a text file; save it as plain CSV (UTF-8)")
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data.replace(b'"', b"") if b'"' in data else data


def _unpack(path: Path, data: bytes) -> bytes:
    try:
        return gzip.decompress(data)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{path} is a damaged gzip file; copy it again from its source") from error


def _end_of_line(data: bytes, start: int) -> int:
    """Return the offset at which the next line begins."""
    return data.find(b"\n", start) + 1 or len(data)


def _end_of_rows(
    path: Path, data: bytes, top: int, delimiter: bytes, device: Device, findings: list[Finding]
) -> int:
    """Return the offset at which the last complete line ends."""
    last = max(top, data.rfind(b"\n") + 1)
    if last == len(data) or _ends_whole(data[top:last], data[last:], delimiter):
        return len(data)
    detail = f"{path.name}, line {_line(data, last)}: last line is cut off, skipped"
    findings.append(Finding(device, "torn last line", "note", 1, detail))
    return last


def _ends_whole(before: bytes, last: bytes, delimiter: bytes) -> bool:
    """Return whether a last line without a newline has the same form as the lines before it."""
    models = before.rsplit(b"\n", TAIL + 1)[-TAIL - 1 : -1]
    forms = {_form(model, delimiter) for model in models}
    return forms == {_form(last, delimiter)} and _form(last, delimiter)[1] > 0


def _form(line: bytes, delimiter: bytes) -> tuple[int, int]:
    """Return how many cells a line has, and how many decimals its last cell has."""
    cells = line.split(delimiter)
    return len(cells), len(cells[-1].strip().partition(b".")[2])


def _line(data: bytes, place: int) -> int:
    """Return the number of the line that begins at an offset."""
    return data.count(b"\n", 0, place) + 1


def _number(cell: bytes) -> float:
    """Return a cell's number, NaN for an empty cell. Raises ValueError for anything else."""
    text = cell.strip().decode(errors="replace")
    if "_" in text:  # float() would accept 1_000
        raise ValueError(text)
    return math.nan if text in NOT_A_NUMBER else float(text)


def _is_cell(cell: bytes) -> bool:
    """Return whether a cell holds a number or is empty."""
    try:
        _number(cell)
    except ValueError:
        return False
    return True


def _is_number(cell: bytes) -> bool:
    return _is_cell(cell) and math.isfinite(_number(cell))


def _is_header(line: bytes, delimiter: bytes, count: int) -> bool:
    """Return whether a line consists of as many names as there are columns."""
    cells = [cell.strip() for cell in line.split(delimiter)]
    return len(cells) == count and all(re.match(rb"[A-Za-z#]", cell) for cell in cells)


def _header_names(path: Path, line: bytes, delimiter: bytes) -> list[str]:
    cells = line.split(delimiter)
    if _is_number(cells[0]):
        raise InputError(
            f"{path}, line 1: no header; use format table-csv and name the columns in the study"
        )
    names = [cell.decode(errors="replace").strip() for cell in cells]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(
            f"{path}, line 1: column {twice[0]!r} appears twice; give each column its own name"
        )
    return names


def _parse(
    data: bytes, start: int, end: int, names: list[str], delimiter: bytes
) -> tuple[list[pa.Table], list[int]]:
    """Parse the rows between two offsets; return them and the offsets of damaged lines.

    The range is bisected, so that a few damaged lines do not slow down a long file.
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
    """Return why a line is damaged."""
    if len(cells) != width:
        return f"it has {len(cells)} cells"
    wrong = next(cell for cell in cells if not _is_cell(cell)).strip().decode(errors="replace")
    cause = "; a spreadsheet program may have changed it" if SPREADSHEET.search(wrong) else ""
    return f"{wrong[:20]!r} is not a number{cause}"


def _report_damaged(
    path: Path,
    lines: list[int],
    count: int,
    fault: str,
    table: pd.DataFrame,
    device: Device,
    findings: list[Finding],
) -> None:
    """Report which lines are damaged and what is wrong with the first. lines: the first five.

    Raises InputError when most lines are damaged: then the columns differ from those declared.
    """
    width = len(table.columns)
    if table.empty:
        raise InputError(
            f"{path}, line {lines[0]}: expected {width} numbers ({fault}), and no other line "
            "fits either; correct `columns` in the study, or record it again"
        )
    if len(table) < count:
        raise InputError(
            f"{path}, line {lines[0]}: expected {width} numbers ({fault}); {count} of "
            f"{len(table) + count} lines do not fit; correct the file, or `columns` in the study"
        )
    more = f" and {count - 5} more" if count > 5 else ""
    where = f"{path.name}, line {', '.join(map(str, lines))}{more} ({fault})"
    detail = f"{where}: expected {width} numbers, skipped"
    findings.append(Finding(device, "damaged lines", "warning", count, detail))
