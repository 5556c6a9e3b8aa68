"""A report as data: sections of paragraphs, tables, figures and lists, numbered throughout.

HTML and PDF are made from the same object, so both say the same in the same order.
"""

import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

Mark = Literal["lowest", "highest"]


@dataclass(frozen=True)
class Cell:
    """A table's cell; `mark` tells the smallest and the largest error of its row."""

    text: str
    mark: Mark | None = None


def _is_number(cell: Cell) -> bool:
    return not re.search(r"[A-Za-z]", cell.text)


@dataclass(frozen=True)
class Paragraph:
    """Running text."""

    text: str
    kind: str = "paragraph"


@dataclass(frozen=True)
class Items:
    """A list; `numbered` when others refer to its numbers."""

    items: list[str]
    numbered: bool = False
    kind: str = "items"


@dataclass(frozen=True)
class Table:
    """A table with one header row; the first column names the rows."""

    caption: str
    header: list[str]
    rows: list[list[Cell]]
    number: int = 0
    kind: str = "table"

    def alignment(self) -> list[str]:
        """ "left" for columns that hold words, "right" for numbers."""
        columns = zip(*self.rows, strict=True) if self.rows else [[] for _ in self.header]
        return ["right" if all(map(_is_number, column)) else "left" for column in columns]


@dataclass(frozen=True)
class Picture:
    """A figure: an SVG file, its caption, and what it shows in words for who cannot see it."""

    caption: str
    path: Path
    alternative: str
    number: int = 0
    kind: str = "picture"


@dataclass(frozen=True)
class Code:
    """Text shown as typed."""

    text: str
    kind: str = "code"


Block = Paragraph | Items | Table | Picture | Code


@dataclass(frozen=True)
class Section:
    """A part of the report under its own heading."""

    title: str
    blocks: list[Block] = field(default_factory=list)


@dataclass(frozen=True)
class Document:
    """A whole report; `notice`: what every page must say, if anything."""

    title: str
    subtitle: str
    sections: list[Section]
    notice: str = ""

    def numbered(self) -> "Document":
        """The same document with tables and figures counted from 1."""
        counts = {"table": 0, "picture": 0}

        def count(block: Block) -> Block:
            if not isinstance(block, Table | Picture):
                return block
            counts[block.kind] += 1
            return replace(block, number=counts[block.kind])

        sections = [
            replace(section, blocks=[count(block) for block in section.blocks])
            for section in self.sections
        ]
        return replace(self, sections=sections)

    def pictures(self) -> Iterator[Picture]:
        """The figures, in order."""
        for section in self.sections:
            yield from (block for block in section.blocks if isinstance(block, Picture))

    def as_data(self) -> dict[str, Any]:
        """The document as plain data, for templates; paths become text."""
        data: dict[str, Any] = asdict(self)
        for section, plain in zip(self.sections, data["sections"], strict=True):
            for block, fields in zip(section.blocks, plain["blocks"], strict=True):
                if isinstance(block, Table):
                    fields["alignment"] = block.alignment()
                if isinstance(block, Picture):
                    fields["path"] = str(block.path)
        return data
