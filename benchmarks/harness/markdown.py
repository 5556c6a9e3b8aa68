"""Tables and sections of pages in Markdown."""

import re
from collections.abc import Iterable, Sequence


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def replaced(text: str, title: str, tables: str) -> str:
    """Return a page with other tables in a section, below the lines that introduce it."""
    old = section(text, title)
    words = old[: old.index("\n|") + 1] if "\n|" in old else f"{old.rstrip()}\n\n"
    return text.replace(old, f"{words}{tables.rstrip()}\n\n") if old else text


def section(text: str, title: str) -> str:
    """Return a section of a page with its heading, up to the next one; empty if there is none."""
    found = re.search(rf"^## {re.escape(title)}\n.*?(?=^## |\Z)", text, re.DOTALL | re.MULTILINE)
    return found.group() if found else ""
