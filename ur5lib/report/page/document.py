"""A report as data: sections of paragraphs, tables, figures and lists, numbered throughout.

HTML, PDF and the summary are made from the same object, so that they agree. The report's contents
(`contents.yaml`, and `report.yaml` of each topic) are the same blocks, not yet filled: they name
views, `module.function`, that fill them from a study's results.
"""

import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from itertools import chain
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from ur5lib.records.verdicts import State
from ur5lib.strict import Strict, read_yaml
from ur5lib.workspace.places import PACKAGE

Mark = Literal["lowest", "highest"]
MOST_SHOWN = 4  # recordings with tables and figures of their own in one section
MOST_ROWS = 60  # shown of a table; its CSV file has all
PAGES_OF_TOPICS = sorted(PACKAGE.glob("topics/*/report.yaml"))
UNDETERMINED_TEXT = "undetermined"  # replaces a number that the data do not determine


@dataclass(frozen=True)
class Cell:
    """A table's cell.

    mark: set for the smallest and the largest error of a row; link: the file that it names,
    relative to the study's results.
    """

    text: str
    mark: Mark | None = None
    link: str = ""

    def is_number(self) -> bool:
        """Whether it holds a number, one that is not determined among them."""
        return self.text == UNDETERMINED_TEXT or not re.search(r"[A-Za-z]|\d–", self.text)


@dataclass(frozen=True)
class Mention:
    """A mention of a table, figure or section by its label; its text is known once it is numbered.

    page: of what is mentioned, if it is another one, relative to the study's results.
    """

    label: str
    text: str = ""
    page: str = ""


class FromContents:
    """A block that `contents.yaml` may declare; unknown keys are errors."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid")


@dataclass(frozen=True)
class Paragraph(FromContents):
    """Running text, with mentions of tables and figures.

    text: as in the contents, with mentions as @name, {of} for the recording or arm of repeated
    blocks, {leading} for the leading estimate; sentences that mention a table or figure that is not
    shown are left out. beside: the text is shown only where this table or figure is. sentences: the
    view that returns paragraphs.
    """

    spans: list[str | Mention] = field(default_factory=list)
    text: str = ""
    beside: str = ""
    sentences: str = ""


@dataclass(frozen=True)
class Heading(FromContents):
    """A heading within a section."""

    heading: str


@dataclass(frozen=True)
class Items(FromContents):
    """A list, numbered or not; entries: the view of its items; above: what introduces it."""

    items: list[str] = field(default_factory=list)
    numbered: bool = False
    entries: str = ""
    above: str = ""


@dataclass(frozen=True)
class TableBlock:
    """A table with one header row; the first column names the rows.

    source: the file it was made from, relative to the study's results.
    """

    caption: str
    header: list[str]
    rows: list[list[Cell]]
    label: str = ""
    source: str = ""
    number: int = 0

    def alignment(self) -> list[str]:
        """ "left" for columns that hold words, "right" for numbers."""
        columns = zip(*self.rows, strict=True) if self.rows else [[] for _ in self.header]
        return ["right" if all(map(Cell.is_number, column)) else "left" for column in columns]


@dataclass(frozen=True)
class DeclaredTable(FromContents):
    """A table of the contents, which becomes a `TableBlock`; left out without rows.

    table: its name, by which texts mention it: the table of results, and what of it is shown, if
    not all, as in force_mae.summary. rows: the view that returns its rows, by default all; where: a
    query of pandas that selects among them, with @of as in texts. lines: columns whose values share
    a line, by default one line a row. columns, last: cells by header, from the first row of a line,
    by default those of `lines`; cells: those of each value of the columns `across`, between the
    former. Cells are templates (`sentences.cell`), headers of `cells` likewise; a column of empty
    cells or dashes is left out. marked: the column of errors whose smallest and largest are marked
    in each line, in the cells that begin with its name, but no smallest one above `zero_` of it.
    """

    table: str
    caption: str
    rows: str = ""
    where: str = ""
    lines: list[str] = field(default_factory=list)
    columns: dict[str, str] = field(default_factory=dict)
    across: list[str] = field(default_factory=list)
    cells: dict[str, str] = field(default_factory=dict)
    last: dict[str, str] = field(default_factory=dict)
    marked: str = ""

    @property
    def by_recording(self) -> bool:
        """Whether its rows, which the first column names, or its cells are of single recordings."""
        return "recording" in {*self.lines, *self.across, *[*self.columns.values()][:1]}

    @property
    def results(self) -> str:
        """Return the name of the table of results that it shows."""
        return self.table.partition(".")[0]


@dataclass(frozen=True)
class Picture(FromContents):
    """A figure: an SVG file, its caption, and the alternative text for readers who cannot see it.

    figure: its name, figures/<of>/<figure>.svg; omitted if it has no data. source: CSV file of its
    numbers, relative to the study's results; rule: the rule that draws it; of: the recording or arm
    that it shows, empty for figures of the whole study.
    """

    caption: str
    path: Path = Path()
    alternative: str = ""
    label: str = ""
    source: str = ""
    rule: str = ""
    of: str = ""
    figure: str = ""
    number: int = 0


@dataclass(frozen=True)
class Number:
    """A number of a card, as text.

    name: what it is; place: its interval, joint, axis, recording and rivals; key: by which it is
    found in another build; before: its text and date in the last build, if it was another.
    """

    name: str
    text: str
    place: str = ""
    key: tuple[str, ...] = ()
    before: str = ""


@dataclass(frozen=True)
class Card:
    """What may be used of one topic: a state, the reasons, and numbers; further: those folded."""

    topic: str
    state: State
    sentence: str = ""
    numbers: tuple[Number, ...] = ()
    further: tuple[Number, ...] = ()
    accepted: tuple[str, ...] = ()


@dataclass(frozen=True)
class Cards(FromContents):
    """Cards next to each other; judged: the view that returns them."""

    cards: list[Card] = field(default_factory=list)
    judged: str = ""


@dataclass(frozen=True)
class Code(FromContents):
    """Text to be copied; listing: the view that returns several; folded: what unfolds it."""

    text: str = ""
    listing: str = ""
    folded: str = ""


Block = Paragraph | Heading | Items | TableBlock | Picture | Cards | Code
NUMBERED_KINDS: dict[type, str] = {TableBlock: "Table", Picture: "Figure"}


@dataclass(frozen=True)
class Section:
    """A part of the report under its own heading."""

    title: str
    blocks: list[Block] = field(default_factory=list)

    @property
    def label(self) -> str:
        """Return the label by which links lead to it."""
        return "section-" + re.sub(r"\W+", "-", self.title.lower())

    def counted(self) -> str:
        """Return how many tables and figures it has, in words."""
        counts = {
            word: sum(isinstance(block, kind) for block in self.blocks)
            for kind, word in ((TableBlock, "table"), (Picture, "figure"))
        }
        words = [f"{n} {word}{'s' if n > 1 else ''}" for word, n in counts.items() if n]
        return " and ".join(words) or "details"


@dataclass(frozen=True)
class Document:
    """A complete report; `notice`: text on every page, if any; home: from it to the results.

    pages: what its contents list beside its own sections.
    """

    title: str
    subtitle: str
    sections: list[Section]
    notice: str = ""
    home: str = ""
    pages: list[Mention] = field(default_factory=list)

    def numbered(self) -> "Document":
        """Return the document with tables and figures numbered from 1, also where mentioned.

        Mentions of what it does not show raise KeyError.
        """
        counts = dict.fromkeys(NUMBERED_KINDS.values(), 0)
        mentions: dict[str, Mention] = {}

        def count(block: Block) -> Block:
            if not isinstance(block, TableBlock | Picture):
                return block
            kind = NUMBERED_KINDS[type(block)]
            counts[kind] += 1
            mentions[block.label] = Mention(block.label, f"{kind} {counts[kind]}")
            return replace(block, number=counts[kind])

        def resolve(block: Block) -> Block:
            if not isinstance(block, Paragraph):
                return block
            spans = [
                mentions[span.label] if isinstance(span, Mention) and not span.text else span
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
        """Return the document as plain data, for templates; `kind` names the class of a block."""
        data = asdict(self)
        plain = (block for section in data["sections"] for block in section["blocks"])
        for section, own in zip(self.sections, data["sections"], strict=True):
            own["label"] = section.label
        for block, fields in zip(self.blocks(), plain, strict=True):
            fields["kind"] = type(block).__name__.removesuffix("Block").lower()
            if isinstance(block, TableBlock):
                fields["alignment"] = block.alignment()
            if isinstance(block, Picture):
                fields["path"] = str(block.path)
        return data


class Repeated(Strict):
    """Blocks repeated for each recording or arm.

    each: what lists them, a view or a method of `Results` with its arguments; most: how many of
    them, if not all.
    """

    each: str
    most: int | None = None
    heading: str = ""
    blocks: list[Block | DeclaredTable]


DeclaredBlock = Block | DeclaredTable | Repeated


class DeclaredSection(Strict):
    """A section; absent: the reason that the report states if the study has no data for it.

    order: its place among the sections; needs: the tables without which it is not asked.
    """

    title: str
    order: int = 0
    absent: str = ""
    needs: list[str] = Field(default_factory=list)
    blocks: list[DeclaredBlock]


class Topic(Strict):
    """What the report has on a topic, and the details.

    order, absent, needs: of its section.
    """

    title: str
    order: int
    absent: str = ""
    needs: list[str] = Field(default_factory=list)
    report: list[DeclaredBlock] = Field(default_factory=list)
    details: list[DeclaredBlock] = Field(default_factory=list)


class TopicPage(Topic):
    """What `report.yaml` in the folder of a topic adds to the report.

    run: to a recording's own page; names, sentences: as in `sentences.yaml`, the sentences of a
    topic that has the name of the folder.
    """

    run: list[DeclaredSection] = Field(default_factory=list)
    names: dict[str, dict[str, str]] = Field(default_factory=dict)
    sentences: dict[str, str] = Field(default_factory=dict)


class Contents(Strict):
    """The report with its details, by topic; run: the sections of a recording's own page."""

    topics: list[Topic]
    run: list[DeclaredSection]

    def report(self) -> list[DeclaredSection]:
        """Return the sections of the report."""
        return [
            DeclaredSection(title=one.title, absent=one.absent, needs=one.needs, blocks=one.report)
            for one in self.topics
            if one.report
        ]

    def details(self) -> list[DeclaredSection]:
        """Return the sections of all else."""
        return [
            DeclaredSection(title=one.title, needs=one.needs, blocks=one.details)
            for one in self.topics
            if one.details
        ]

    def blocks(self) -> Iterator[Block | DeclaredTable]:
        """Yield the blocks of all pages, those that are repeated once."""
        for part in [*self.report(), *self.details(), *self.run]:
            for block in part.blocks:
                yield from block.blocks if isinstance(block, Repeated) else [block]


@cache
def contents() -> Contents:
    """Return the report's contents, those of the topics among them, in their order."""
    own = Contents.model_validate(read_yaml(Path(__file__).with_name("contents.yaml")))
    pages = topic_pages().values()
    return Contents(
        topics=sorted([*own.topics, *pages], key=attrgetter("order")),
        run=sorted([*own.run, *chain(*(page.run for page in pages))], key=attrgetter("order")),
    )


@cache
def topic_pages() -> dict[str, TopicPage]:
    """Return what each topic adds to the report, by the name of its folder, in their order."""
    read = {path.parent.name: TopicPage.model_validate(read_yaml(path)) for path in PAGES_OF_TOPICS}
    return dict(sorted(read.items(), key=lambda page: page[1].order))
