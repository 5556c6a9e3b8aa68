"""Lists of numbers in a table's cells, as Python and NumPy print them: a column for each number."""

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
