"""Output of commands at work: text from outside, and the file that is being read."""

import sys
from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import Progress

from ur5lib.errors import printable

Item = TypeVar("Item")


def text_console(**settings: Any) -> Console:
    """Return a console that prints text from outside unchanged, without markup or emoji names."""
    return Console(markup=False, emoji=False, **settings)


def announced(items: Sequence[Item]) -> Iterator[Item]:
    """Yield files, or names of recordings; print each on stderr first, or show it in a progress bar
    on a terminal.
    """
    if sys.stderr.isatty():
        yield from _beside_a_bar(items)
        return
    for number, item in enumerate(items, 1):
        line = f"reading {printable(str(item))} ({number} of {len(items)})"
        print(line, file=sys.stderr, flush=True)
        yield item


def _beside_a_bar(items: Sequence[Item]) -> Iterator[Item]:
    with Progress(console=text_console(stderr=True), transient=True) as progress:
        bar = progress.add_task("reading", total=len(items))
        for item in items:
            progress.update(bar, description=f"reading {printable(str(item))}")
            yield item
            progress.advance(bar)
