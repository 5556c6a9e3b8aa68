"""Tables and sections of pages in Markdown; tables that a picture shows are CSV files of data/."""

import csv
import io
import re
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd

from ur5lib.tables import write_text

WIDTH = 140  # of a line of prose


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


FOLD = re.compile(r"<!-- data/(\w+)\.csv -->\n+(\|.*?)\n+<!-- end -->", re.DOTALL)
LINK = re.compile(r"\[The numbers\]\(data/(\w+)\.csv\)")


def folded(name: str, table: str) -> str:
    """Return a table in Markdown that becomes data/<name>.csv where its page is written."""
    return f"<!-- data/{name}.csv -->\n\n{table.strip()}\n\n<!-- end -->"


def read_page(page: Path) -> str:
    """Return a page with the tables that it links as data."""

    def table(link: re.Match[str]) -> str:
        text = (page.parent / "data" / f"{link[1]}.csv").read_text(encoding="utf-8")
        head, *rows = csv.reader(io.StringIO(text))
        return folded(link[1], markdown(head, rows))

    return LINK.sub(table, page.read_text(encoding="utf-8"))


def write_page(text: str, page: Path) -> None:
    """Write a page, its folded tables as data that it links."""

    def link(fold: re.Match[str]) -> str:
        rows = io.StringIO()
        csv.writer(rows, lineterminator="\n").writerows(cells_of(fold[2]))
        write_text(rows.getvalue(), page.parent / "data" / f"{fold[1]}.csv")
        return f"[The numbers](data/{fold[1]}.csv)"

    write_text(FOLD.sub(link, text), page)


def wrapped(text: str) -> str:
    """Return a page with its long lines of prose broken at WIDTH."""
    lines = []
    for line in text.split("\n"):
        prose = not line.startswith(("|", "!", "#", " "))
        lines += _broken(line) if prose and len(line) > WIDTH else [line]
    return "\n".join(lines)


def _broken(line: str) -> list[str]:
    indent = "  " if line.startswith("- ") else ""
    return textwrap.wrap(
        line, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False
    )


def cells_of(table: str) -> list[list[str]]:
    """Return the cells of a table in Markdown, without the rule below its head."""
    head, _, *rows = table.splitlines()
    lines = (line.strip().removeprefix("|").removesuffix("|") for line in (head, *rows))
    return [[cell.strip() for cell in line.split("|")] for line in lines]


def replaced(text: str, title: str, tables: str) -> str:
    """Return a page with new tables in a section, below its introduction; if the section has a
    folded table, only this is replaced.
    """
    old = section(text, title)
    if not old:
        return text
    if fold := FOLD.search(old):
        return text.replace(fold[0], folded(fold[1], tables))
    start = old.find("\n|") + 1
    words = old[:start] if start else f"{old.rstrip()}\n\n"
    return text.replace(old, f"{words}{tables.rstrip()}\n\n")


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
        first, *rows = cells_of(block)
        if head in ("", first[0]):
            return pd.DataFrame(rows, columns=first)
    raise ValueError(f"no table of “{title}” begins with {head}")
