"""Tables and sections of pages in Markdown."""

import re
from collections.abc import Iterable, Sequence

import pandas as pd


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


FOLDED = "<details markdown><summary>The numbers</summary>"
UNFOLDED = "</details>"


def folded(table: str) -> str:
    """Return a folded table in Markdown, since a picture shows its content."""
    return f"{FOLDED}\n\n{table}\n\n{UNFOLDED}"


def replaced(text: str, title: str, tables: str) -> str:
    """Return a page with new tables in a section, below its introduction; if the section has a
    folded table, only this is replaced.
    """
    old = section(text, title)
    if not old:
        return text
    fold = max(old.find(FOLDED), 0)
    start = old.find("\n|", fold) + 1
    words = old[:start] if start else f"{old.rstrip()}\n\n"
    after = old[old.index(UNFOLDED, start) :] if FOLDED in old else ""
    return text.replace(old, f"{words}{tables.rstrip()}\n\n{after}")


def section(text: str, title: str) -> str:
    """Return a section of a page with its heading, up to the next one; empty if there is none."""
    found = re.search(rf"^## {re.escape(title)}\n.*?(?=^## |\Z)", text, re.DOTALL | re.MULTILINE)
    return found.group() if found else ""


def table_in(text: str, title: str, head: str = "") -> pd.DataFrame:
    """Return a section's table as text: the first one with `head` as name of its first column.

    title: of the section, or of the page; head: "" for the first table.
    """
    whole = section(text, title) or text
    for block in re.findall(r"(?:^\|.*\n?)+", whole, re.MULTILINE):
        cells = [
            [cell.strip() for cell in line.strip("|\n").split("|")] for line in block.splitlines()
        ]
        if head in ("", cells[0][0]):
            return pd.DataFrame(cells[2:], columns=cells[0])
    raise ValueError(f"no table of “{title}” begins with {head}")
