"""A file to which rows are appended, and which stays readable however its writer ends."""

import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

FLUSH_PERIOD = 1.0  # s; a killed writer loses at most the rows of this time
TAIL = 1 << 16  # bytes


class Journal:
    """A CSV of whole lines: rows are written in batches, and an incomplete one is cut off again.

    path: new; names: of the columns; period: of the batches [s]. Raises OSError if the
    file exists, or rows cannot be written; earlier rows stay.
    """

    def __init__(self, path: Path, names: Sequence[str], period: float = FLUSH_PERIOD) -> None:
        self.path, self._period = path, period
        self._file = path.open("xb", buffering=0)
        self._size, self._lines = 0, [",".join(names)]
        self.rows = -1  # written rows, without the line of names
        self._flush()

    def write(self, lines: Iterable[str]) -> None:
        """Append rows, each a line without its end."""
        self._lines += lines
        if self._lines and time.monotonic() - self._flushed >= self._period:
            self._flush()

    def close(self) -> None:
        """Write the remaining rows, and close the file. Raises OSError, with the file closed."""
        try:
            self._flush()
        finally:
            self._file.close()

    def _flush(self) -> None:
        lines, self._lines = self._lines, []
        self._flushed = time.monotonic()
        data, written = "".join(f"{line}\n" for line in lines).encode("ascii"), 0
        try:
            while written < len(data):
                written += self._file.write(memoryview(data)[written:])
        finally:
            whole = data[:written].rfind(b"\n") + 1
            count = data.count(b"\n", 0, whole)
            self._size, self.rows = self._size + whole, self.rows + count
            if whole < len(data):
                self._lines = [*lines[count:], *self._lines]
                with suppress(OSError):  # the first error says more
                    self._file.truncate(self._size)
                    self._file.seek(self._size)


def journal_of(path: Path, names: Sequence[str], period: float = FLUSH_PERIOD) -> Journal:
    """Return a new journal of a file: the first `<name>.<number>.part.csv` that is not taken, also
    not at this moment.
    """
    number = 1
    while True:
        try:
            return Journal(path.with_name(f"{path.stem}.{number}.part.csv"), names, period)
        except FileExistsError:
            number += 1


def left_behind(path: Path) -> list[str]:
    """Return a line of text for each journal of a file: of a run that was cut off, or goes on."""
    parts = sorted(path.parent.glob(f"{path.stem}.*.part.csv"))
    return [
        f"{part} was left by another run, or is written by one, with {rows_in(part)} samples; it "
        "can be read as a CSV"
        for part in parts
    ]


def rows_in(path: Path) -> int:
    """Return the number of complete rows without the line of names."""
    with path.open("rb") as file:
        count = sum(data.count(b"\n") for data in iter(lambda: file.read(TAIL), b""))
    return max(0, count - 1)
