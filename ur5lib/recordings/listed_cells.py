"""Lists of numbers in a table's cells, in brackets or with a separator of their own between them: a
column for each number.
"""

import re

# This many show what the first row contains; NumPy breaks long lists into lines.
HEAD_BYTES = 100_000
LIST = re.compile(  # a tuple has two numbers at least
    rb'"?(?:array)?(?:\(?\[+|\((?=[^()]*[,;\s]))([-+.,;\s\deEnaifNAIF]*)[\])]+"?'
)
BETWEEN_NUMBERS = re.compile(rb"[\s,;]+")
NUMBER_WORDS = re.compile(rb"nan|inf|array|none|null|e", re.IGNORECASE)
OPENED = re.compile(rb"[\[(]")  # each list; found ten times as fast where there is none
CELL_STARTS = b"\n", b",", b";", b"\t"
MARKS = ((b";", b","), (b"\t", b","), (b";", b" "), (b"\t", b" "), (b",", b" "))  # and within
NUMBER = re.compile(rb"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*|\s*nan\s*", re.IGNORECASE)
LETTER, PLACE = re.compile(rb"[A-Za-z]"), b"\0"


def with_lists_apart(block: bytes) -> bytes:
    """Return lines of a table in which each number of a list has a column of its own.

    In the header, the line above the first list, a list's name becomes `<name>_0` and so on. Lists
    of different lengths make rows of different widths, which the reader reports.
    """
    if not OPENED.search(block[:HEAD_BYTES]):
        return block
    lists = LIST.finditer(block[:HEAD_BYTES])
    start = next((found.start() for found in lists if _is_cell(found, block)), None)
    if start is None:
        return block
    begin = block.rfind(b"\n", 0, start) + 1
    above, head = block[:begin].rstrip(b"\n").rpartition(b"\n")[::2]
    named, rows = LETTER.search(NUMBER_WORDS.sub(b"", head)) is not None, block[begin:]
    if begin and not named:
        return block
    first = LIST.sub(lambda found: PLACE * _count(found), rows[:HEAD_BYTES]).partition(b"\n")[0]
    mark = next((mark for mark in (b";", b"\t", b",") if mark in first), b",")
    apart = LIST.sub(lambda found: _apart(found, mark), rows)
    return b"\n".join([above, _names(head, first, mark), apart]).lstrip(b"\n") if named else apart


def with_one_mark(block: bytes) -> bytes:
    """Return lines of a table in which a second separator, between the numbers of a cell, is the
    first one; a cell's name becomes `<name>_0` and so on.

    A comma between two numbers alone is a decimal comma.
    """
    head, *rows = block[:HEAD_BYTES].split(b"\n", 3)[:3]
    for mark, inner in MARKS:
        widths = [[*map(len, _parts(row, mark, inner))] for row in (rows or [head]) if row.strip()]
        least = 3 if inner == b"," else 2
        if not widths or any(own != widths[0] for own in widths) or len(widths[0]) < 2:
            continue
        if max(widths[0]) >= least and all(_are_numbers(row, mark, inner) for row in rows[:1]):
            return _with_mark(block, head, widths[0], mark, inner)
    return block


def _parts(row: bytes, mark: bytes, inner: bytes) -> list[list[bytes]]:
    """Return the parts of each cell of a row."""
    between = None if inner == b" " else inner
    return [cell.strip().split(between) for cell in row.split(mark)]


def _are_numbers(row: bytes, mark: bytes, inner: bytes) -> bool:
    return all(NUMBER.fullmatch(one) for cell in _parts(row, mark, inner) for one in cell)


def _with_mark(block: bytes, head: bytes, widths: list[int], mark: bytes, inner: bytes) -> bytes:
    """Return lines with one separator, the first of them `head`; widths: numbers of each cell."""
    named, rows = LETTER.search(NUMBER_WORDS.sub(b"", head)) is not None, block
    if named:
        names, rows = _parts(head, mark, inner), block[len(head) + 1 :]
        if [*map(len, names)] == widths:
            head = mark.join(one for cell in names for one in cell)
        elif len(head.split(mark)) == len(widths):
            first = mark.join(PLACE * width if width > 1 else b"" for width in widths)
            head = _names(head, first, mark)
        else:
            return block
    within = rb"[ ]*%s[ ]*" % re.escape(inner) if inner != b" " else rb"(?<=[\d.])[ ]+(?=[-+.\dn])"
    parted = re.sub(within, mark, rows)
    return head + b"\n" + parted if named else parted


def _is_cell(found: re.Match[bytes], block: bytes) -> bool:
    """Return whether a list is a cell, rather than a number in a name, as in `q[0]`."""
    return _count(found) > 1 or block[found.start() - 1 : found.start()] in (b"", *CELL_STARTS)


def _numbers(found: re.Match[bytes]) -> list[bytes]:
    return [number for number in BETWEEN_NUMBERS.split(found[1]) if number]


def _apart(found: re.Match[bytes], mark: bytes) -> bytes:
    numbers = found[1].replace(b"\n", b" ").strip()
    return numbers if mark in numbers else mark.join(_numbers(found))


def _count(found: re.Match[bytes]) -> int:
    return len(_numbers(found))


def _names(head: bytes, first: bytes, mark: bytes) -> bytes:
    """Return a header with a name for each number. first: the row below, with PLACE for each
    number.
    """
    names, widths = head.split(mark), [cell.count(PLACE) for cell in first.split(mark)]
    if len(names) != len(widths):
        return head
    bare = [name.strip().strip(b'"') for name in names]
    return mark.join(
        b"%s_%d" % (bare[k], place) if width > 1 else names[k]
        for k, width in enumerate(widths)
        for place in range(max(width, 1))
    )
