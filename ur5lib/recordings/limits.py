"""How much a file may contain: some kilobytes can unpack to many gigabytes."""

import math
import os
from pathlib import Path

from ur5lib.errors import InputError

DEFAULT_GIGABYTES = 1.0  # of numbers; an hour at 500 Hz with 60 channels has 0.9
LIMIT_VARIABLE = "UR5_MOST_GB"  # in the environment: another limit
BYTES_PER_NUMBER = 8  # bytes of a number in memory, however few it has in the file
TEXT_PER_NUMBER = 3  # bytes of text for each of those; numbers of 16 digits have 25 for 8
BYTES_PER_COLUMN = 100_000  # bytes that a table has at least for each of its columns
MIN_LINES = 32  # that a table has at least


def most_bytes() -> float:
    """Return how much the numbers of a file may take in memory."""
    given = os.environ.get(LIMIT_VARIABLE, "") or DEFAULT_GIGABYTES
    try:
        most = float(given)
    except ValueError:
        most = math.nan
    if not most > 0:
        raise InputError(
            f"{LIMIT_VARIABLE} is {given!r}; give a number of gigabytes, as {LIMIT_VARIABLE}=5"
        )
    return 1e9 * most


def most_columns() -> int:
    """Return how many columns a table may have."""
    return int(most_bytes() / BYTES_PER_COLUMN)


def longest_line() -> int:
    """Return how many bytes a line may have: all numbers of an hour at 500 Hz have fewer."""
    return int(most_bytes() / MIN_LINES)


def expect_room(path: Path, numbers: float) -> None:
    """Raise InputError where a file has so many numbers that they would take too much memory."""
    if BYTES_PER_NUMBER * numbers > (most := most_bytes()):
        raise too_large(path, f"{most / 1e9:g} GB of numbers ({most / BYTES_PER_NUMBER:,.0f})")


def expect_short_text(path: Path, size: int) -> None:
    """Raise InputError where a file unpacks to so much text that it takes too long. size: bytes."""
    if size > (most := TEXT_PER_NUMBER * most_bytes()):
        raise too_large(path, f"{most / 1e9:g} GB of text")


def too_large(path: Path, content: str) -> InputError:
    """Return the error of a file that contains more than some content."""
    return InputError(
        f"{path} holds more than {content}; "
        f"if it should, allow more by `export {LIMIT_VARIABLE}=10` before the "
        "command, else copy it again from its source"
    )
