"""Objects that show themselves on one screen of a terminal or notebook."""

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from html import escape
from typing import TextIO

import pandas as pd

from ur5lib.errors import printable

LOGGER = logging.getLogger("ur5lib")


class _Shown(logging.StreamHandler[TextIO]):
    """Prints what nobody takes otherwise: lines of INFO, where no handler is set."""

    def emit(self, record: logging.LogRecord) -> None:
        if not logging.root.handlers and LOGGER.handlers == [self]:
            print(self.format(record))


LOGGER.addHandler(_Shown())
if LOGGER.level == logging.NOTSET:  # a user may have set it before
    LOGGER.setLevel(logging.INFO)
MOST_ROWS, MOST_LETTERS = 16, 50  # of a table; of a cell


class Shown:
    """An object that is shown by a sentence and a table."""

    def _title(self) -> str:
        """Return a sentence: what it is, how much it contains, and what may be done with it."""
        raise NotImplementedError

    def summary(self) -> pd.DataFrame:
        """Return the table that shows it; numbers with their units in the column's names."""
        raise NotImplementedError

    def __dir__(self) -> list[str]:
        """Return the public names, which fit on a screen."""
        return [name for name in super().__dir__() if not name.startswith("_")]

    def __repr__(self) -> str:
        """Return title and table as text."""
        table = self.summary()
        text = table.to_string(index=False, max_rows=MOST_ROWS, max_colwidth=MOST_LETTERS)
        return printable("\n".join([self._title(), *([] if table.empty else [text])]))

    def _repr_html_(self) -> str:
        table = self.summary()
        rows = table.to_html(index=False, max_rows=MOST_ROWS, border=0, escape=True)
        return f"<p>{escape(self._title())}</p>{'' if table.empty else rows}"


@contextmanager
def bar(count: int) -> Iterator[Callable[[str], None]]:
    """Provide a function that shows the next of `count` steps by name, in a bar on a terminal."""
    if not sys.stderr.isatty():  # where rich would print an empty line
        yield lambda _: None
        return
    from rich.console import Console  # rich takes a tenth of a second, which only a fit needs
    from rich.progress import Progress

    console = Console(stderr=True, markup=False, emoji=False)
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task("", total=count)
        started = iter(range(count))
        yield lambda name: progress.update(
            task, completed=next(started), description=printable(name)
        )


def counted(count: int, what: str) -> str:
    """Return a number of things in words: "1 path" or "2 paths"; what: the word in the singular."""
    return f"{count} {what}{'s' * (count != 1)}"


def frames(parts: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Return data frames by recording as one: of a single recording by `time`, of several by
    `recording` and `time`.

    Its columns' units are in `frame.attrs["units"]`.
    """
    first, *others = parts.values()
    if not others:
        return first
    joined = pd.concat(parts, names=["recording"])
    joined.attrs["units"] = {
        k: v for part in parts.values() for k, v in part.attrs["units"].items()
    }
    return joined
