"""How much a file may contain: some kilobytes can unpack to many gigabytes."""

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ur5lib.errors import InputError

DEFAULT_GIGABYTES = 2.0  # of numbers; an hour at 500 Hz of 130 columns has 1.9
LIMIT_VARIABLE = "UR5_MOST_GB"  # in the environment: another limit
BYTES_PER_NUMBER = 8  # bytes of a number in memory, however few it has in the file
USUAL_COMPRESSION = 20  # bytes for each byte of a compressed file
BYTES_PER_COLUMN = 100_000  # bytes that a table has at least for each of its columns
MIN_LINES = 32  # that a table has at least


def most_bytes() -> float:
    """Return how many bytes the numbers of a file may take in memory."""
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
    """Return how many bytes a line may have; an hour of numbers at 500 Hz has fewer."""
    return int(most_bytes() / MIN_LINES)


def expect_room(path: Path, numbers: float) -> None:
    """Raise InputError where a file has so many numbers that they would take too much memory."""
    if BYTES_PER_NUMBER * numbers > (most := most_bytes()):
        raise too_large(path, f"{most / 1e9:g} GB of numbers ({most / BYTES_PER_NUMBER:,.0f})")


class Unpacking:
    """The number of bytes that a compressed file may still unpack to; more raises InputError."""

    def __init__(self, path: Path) -> None:
        """Take the compressed file; the limit is the memory for numbers and USUAL_COMPRESSION times
        its size.
        """
        self.path = path
        self.left = int(most_bytes()) + USUAL_COMPRESSION * path.stat().st_size

    def count(self, size: int) -> None:
        """Count bytes. Raises InputError where they are more than the file may unpack to."""
        self.left -= size
        if self.left < 0:
            raise too_large(self.path, f"{USUAL_COMPRESSION} times as much as it has bytes")

    def unpacked(self, data: bytes, new: Callable[[], Any]) -> bytes:
        """Return the unpacked bytes of a part of the file, and count them; new: makes a
        decompressor of bz2, lz4 or zstd.

        Raises EOFError where the part is incomplete.
        """
        frames = list[bytes]()
        while data:
            one = new()
            frames.append(one.decompress(data, self.left + 1))
            self.count(len(frames[-1]))
            if not one.eof:
                raise EOFError(self.path)
            data = one.unused_data or b""
        return b"".join(frames)


def too_large(path: Path, content: str) -> InputError:
    """Return the error for a file that contains more than allowed; content: the limit in words."""
    return InputError(
        f"{path} holds more than {content}; "
        f"if it should, allow more by `export {LIMIT_VARIABLE}=10` before the "
        "command, else copy it again from its source"
    )
