"""A report as data: sections of paragraphs, tables, figures and lists, numbered throughout.

HTML and PDF are made from the same object, so both say the same in the same order.
"""

import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

State = Literal["good", "usable", "do not use", "not determined"]
Mark = Literal["lowest", "highest"]
UNDETERMINED = "undetermined"  # replaces a number that the data do not determine


@dataclass(frozen=True)
class Cell:
    """A table's cell; `mark`: whether it is the smallest or the largest error of its row."""

    text: str
    mark: Mark | None = None


def _is_number(cell: Cell) -> bool:
    return cell.text == UNDETERMINED or not re.search(r"[A-Za-z]|\d–", cell.text)


@dataclass(frozen=True)
class Reference:
    """A mention of a table or figure by its label; its text is known once all are numbered."""

    label: str
    text: str = ""


@dataclass(frozen=True)
class Paragraph:
    """Running text, with mentions of tables and figures."""

    spans: list[str | Reference]
    kind: str = "paragraph"


@dataclass(frozen=True)
class Heading:
    """Opens a part of a section."""

    text: str
    kind: str = "heading"


@dataclass(frozen=True)
class Items:
    """A list; `numbered` when others refer to its numbers."""

    items: list[str]
    numbered: bool = False
    kind: str = "items"


@dataclass(frozen=True)
class Table:
    """A table with one header row; the first column names the rows.

    source: the file it was made from, relative to the study's results.
    """

    caption: str
    header: list[str]
    rows: list[list[Cell]]
    label: str = ""
    source: str = ""
    number: int = 0
    kind: str = "table"

    def alignment(self) -> list[str]:
        """ "left" for columns that hold words, "right" for numbers."""
        columns = zip(*self.rows, strict=True) if self.rows else [[] for _ in self.header]
        return ["right" if all(map(_is_number, column)) else "left" for column in columns]


@dataclass(frozen=True)
class Picture:
    """A figure: an SVG file, its caption, and what it shows in words for who cannot see it.

    source: its numbers, relative to the study's results; rule: what made it; of: the recording or
    arm that it is of, if it is of one.
    """

    caption: str
    path: Path
    alternative: str
    label: str = ""
    source: str = ""
    rule: str = ""
    of: str = ""
    number: int = 0
    kind: str = "picture"


@dataclass(frozen=True)
class Number:
    """A number that the summary states.

    place: recording, joint or component that it is of; low, high: ends of its interval, which
    `interval` names; baseline: the same number of what `baseline_of` names.
    """

    name: str
    value: float
    unit: str
    place: str = ""
    low: float | None = None
    high: float | None = None
    interval: str = ""
    baseline: float | None = None
    baseline_of: str = ""


@dataclass(frozen=True)
class Verdict:
    """What the results say about one topic, at a glance.

    evidence: the number behind the sentence, with its interval and its baseline; drawing: an SVG,
    empty if there is nothing to draw; caption: what the drawing shows; numbers: those of sentence
    and evidence.
    """

    topic: str
    state: State
    sentence: str
    evidence: str = ""
    drawing: str = ""
    caption: str = ""
    numbers: tuple[Number, ...] = ()


@dataclass(frozen=True)
class Verdicts:
    """Verdicts side by side."""

    verdicts: list[Verdict]
    kind: str = "verdicts"


@dataclass(frozen=True)
class Equation:
    """An equation in typst's notation, and in words for who cannot see it."""

    source: str
    alternative: str
    kind: str = "equation"


@dataclass(frozen=True)
class Code:
    """Text shown as typed."""

    text: str
    kind: str = "code"


Block = Paragraph | Heading | Items | Table | Picture | Verdicts | Equation | Code
NAMES = {"table": "Table", "picture": "Figure"}


@dataclass(frozen=True)
class Section:
    """A part of the report under its own heading."""

    title: str
    blocks: list[Block] = field(default_factory=list)


@dataclass(frozen=True)
class Document:
    """A complete report; `notice`: text on every page, if any."""

    title: str
    subtitle: str
    sections: list[Section]
    notice: str = ""

    def numbered(self) -> "Document":
        """Return the document with tables and figures numbered from 1, also where mentioned.

        Mentions of what is not in the document raise KeyError.
        """
        counts = {"table": 0, "picture": 0}
        names: dict[str, str] = {}

        def count(block: Block) -> Block:
            if not isinstance(block, Table | Picture):
                return block
            counts[block.kind] += 1
            names[block.label] = f"{NAMES[block.kind]} {counts[block.kind]}"
            return replace(block, number=counts[block.kind])

        def resolve(block: Block) -> Block:
            if not isinstance(block, Paragraph):
                return block
            spans = [
                replace(span, text=names[span.label]) if isinstance(span, Reference) else span
                for span in block.spans
            ]
            return replace(block, spans=spans)

        sections = self.sections
        for change in (count, resolve):
            sections = [replace(part, blocks=[*map(change, part.blocks)]) for part in sections]
        return replace(self, sections=sections)

    def blocks(self) -> Iterator[Block]:
        """Yield all blocks, in order."""
        for section in self.sections:
            yield from section.blocks

    def as_data(self) -> dict[str, Any]:
        """Return the document as plain data, for templates; paths become text."""
        data: dict[str, Any] = asdict(self)
        plain = (block for section in data["sections"] for block in section["blocks"])
        for block, fields in zip(self.blocks(), plain, strict=True):
            if isinstance(block, Table):
                fields["alignment"] = block.alignment()
            if isinstance(block, Picture):
                fields["path"] = str(block.path)
        return data
