"""The report of a study: its contents, filled from its results."""

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from functools import partial, reduce
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from ur5lib import __version__
from ur5lib.force.estimators import ESTIMATES, LEADING
from ur5lib.report.figures.traces import BAND_EDGES, ERROR, HIDDEN, LINE_COLUMN, UNFILTERED
from ur5lib.report.page.document import (
    MOST_ROWS,
    MOST_SHOWN,
    Block,
    Cards,
    Code,
    DeclaredBlock,
    DeclaredSection,
    DeclaredTable,
    Document,
    Heading,
    Items,
    Mention,
    Paragraph,
    Picture,
    Repeated,
    Section,
    TableBlock,
    contents,
)
from ur5lib.report.page.formats import day
from ur5lib.report.page.sentences import say, speaking_of, spoken
from ur5lib.report.page.tabulated import Body, tabulate
from ur5lib.report.page.topics import functions
from ur5lib.report.results import Results
from ur5lib.report.views import (
    cards,
    citing,
    contacts,
    currents,
    first_screen,
    forces,
    models,
    motion,
    recordings,
)

MODULES = cards, citing, contacts, currents, first_screen, forces, models, motion, recordings
VIEWS: dict[str, ModuleType] = {module.__name__.rpartition(".")[2]: module for module in MODULES}
REPLAYED = ("currents", "forces_estimated")  # figures of a recording, of which the last one counts
USES = "quality.trust"  # the table of what recordings serve
NOTICED, EACH_CONTACT = "noticed", "contact_errors"  # by recording; by contact
REPORT_FILE, DETAILS_FILE = "report.html", "details.html"
MENTION = re.compile(r"@([a-z_]+(?:\.[a-z_]+)?)")
CONDITIONAL_TEXT = re.compile(
    r"\{([\w ]+)\|(.*?)\}"
)  # of the thesis's study, of ur or other arms, of a recording to fit, of a table with that column
SENTENCE_END = re.compile(r"(?<=[.:]) (?=[A-Z@“])")


DraftedText = Callable[[Set[str]], Paragraph | None]
"""Returns a text, given the labels of the tables and figures that are shown."""


class StudyPages(NamedTuple):
    """The report of a study, and what it leaves to a page of its own."""

    report: Document
    details: Document


def compose_study(results: Results) -> StudyPages:
    """Compose the report of a study and its details, to which each section of the report leads."""
    report = compose(contents().report(), results)
    shown = _labels(report.blocks())
    details = compose(contents().details(), results, shown)
    further = {section.title: section for section in details.sections}
    places = {
        USES: (_replayed(report, details), say("linked.replayed")),
        NOTICED: (_by_contact(details), say("linked.by contact")),
    }
    linked = [
        replace(
            section,
            blocks=[
                *(_with_links(block, places) for block in section.blocks),
                *_link(further.get(section.title)),
            ],
        )
        for section in report.sections
    ]
    there, here = Mention(details.sections[0].label, "Supplement", DETAILS_FILE), report.sections[0]
    details = replace(details, title=f"Supplement: {details.title}")
    return StudyPages(
        replace(report, sections=linked, pages=[there]),
        replace(details, pages=[Mention(here.label, "Report", REPORT_FILE)]),
    )


def _replayed(report: Document, details: Document) -> dict[str, str]:
    """Return by recording the link to its figure that *Replay* opens at the worst second."""
    return {
        block.of: f"{page}#{block.label}"
        for figure in REPLAYED
        for page, document in ((DETAILS_FILE, details), ("", report))
        for block in document.blocks()
        if isinstance(block, Picture) and block.figure == figure
    }


def _by_contact(details: Document) -> dict[str, str]:
    """Return by recording the link to the table of its contacts."""
    labels = (block.label for block in details.blocks() if isinstance(block, TableBlock))
    tables = (label.partition("-") for label in labels)
    return {
        name: f"{DETAILS_FILE}#{table}-{name}" for table, _, name in tables if table == EACH_CONTACT
    }


def _with_links(block: Block, places: Mapping[str, tuple[dict[str, str], str]]) -> Block:
    """Return a table with links from the names of its recordings, and what these lead to in its
    caption, if there are any.
    """
    if not isinstance(block, TableBlock) or block.label not in places:
        return block
    links, meant = places[block.label]
    rows = [[replace(row[0], link=links.get(row[0].text, "")), *row[1:]] for row in block.rows]
    if not any(row[0].link for row in rows):
        return block
    return replace(block, rows=rows, caption=f"{block.caption} {meant}")


def _link(section: Section | None) -> Iterator[Paragraph]:
    """Yield a link to a section of the details, if there is one."""
    if section:
        text = f"{section.counted()} in the supplement"
        yield Paragraph(["More: ", Mention(section.label, text, DETAILS_FILE)])


def compose(
    parts: Sequence[DeclaredSection], results: Results, elsewhere: Set[str] = frozenset()
) -> Document:
    """Compose a page about a study; its first section gives the reasons of omitted ones.

    Tables and figures of the first section are not repeated in later ones, nor are those that
    another page shows (`elsewhere`, their labels).
    """
    with speaking_of(results.effort):
        return _composed(parts, results, elsewhere).numbered()


def _composed(parts: Sequence[DeclaredSection], results: Results, elsewhere: Set[str]) -> Document:
    known = results.tables.keys()
    first, *others = (part for part in parts if {*part.needs} <= known)
    above = _labels(_drafts(first, results)) - elsewhere
    sections = [
        Section(spoken(part.title), _blocks(part, results, above, elsewhere)) for part in others
    ]
    filled = [one for one, part in zip(sections, others, strict=True) if _is_filled(one, part)]
    left_out = [
        say("findings.left out", title=section.title, reason=spoken(part.absent))
        for part, section in zip(others, sections, strict=True)
        if section not in filled and part.absent
    ]
    opening = _blocks(first, replace(results, left_out=left_out), elsewhere=elsewhere)
    study = results.study
    notice = _notice(study["recordings"])
    return Document(
        title=f"{study['title']} (simulated)" if notice else study["title"],
        subtitle=_analysed(results),
        sections=[Section(spoken(first.title), opening)] * bool(opening) + filled,
        notice=notice,
    )


def view(name: str) -> Callable[..., Any]:
    """Return the view `module.function`. Raises KeyError or AttributeError where there is none."""
    module, _, function = name.partition(".")
    views_function: Callable[..., Any] = getattr((VIEWS | functions())[module], function)
    return views_function


def _analysed(results: Results) -> str:
    """Return the report's subtitle: study, arms, and counts of recordings by role."""
    roles = [*results.roles().values()]
    counts = ", ".join(f"{roles.count(role)} {role}" for role in dict.fromkeys(roles))
    minutes = results.tables["recordings"]["duration_s"].sum() / 60
    date = citing.analysed_on(results)
    return (
        f"Study “{results.study['study']}” of {', '.join(results.robots())}, recordings: "
        f"{len(roles)} ({counts}; {minutes:.1f} min)"
        + (f". Analysed on {day(date)} by ur5lib {__version__}" if date else "")
    )


def _labels(blocks: Iterable[Block | DraftedText]) -> set[str]:
    """Return the labels of the tables and figures among blocks."""
    return {block.label for block in blocks if isinstance(block, TableBlock | Picture)}


def _blocks(
    part: DeclaredSection,
    results: Results,
    above: Set[str] = frozenset(),
    elsewhere: Set[str] = frozenset(),
) -> list[Block]:
    """Return the blocks of a section, without sentences about missing tables and figures.

    above: labels of the tables and figures in an earlier section; elsewhere: on another page,
    beside which a table of one row is a sentence.
    """
    drafts, shown = list[Block | DraftedText](), {*above}
    for draft in _drafts(part, results):
        if elsewhere and isinstance(draft, TableBlock) and len(draft.rows) == 1:
            draft = _in_a_sentence(draft)
        if not (label := _labels([draft])) & (shown | elsewhere):
            drafts.append(draft)
            shown |= label
    blocks = [draft(shown) if callable(draft) else draft for draft in drafts]
    return [block for block in blocks if block]


def _paragraph(text: str, beside: str, name: str, shown: Set[str]) -> Paragraph | None:
    """Return the sentences of a text that mention only tables and figures that are shown.

    beside: what the text requires, if anything; name: recording or arm of what is mentioned.
    """
    spans: list[str | Mention] = []
    for sentence in SENTENCE_END.split(text.strip()):
        parts = [  # every second one is a mention
            Mention(_label(part, name)) if i % 2 else part
            for i, part in enumerate(MENTION.split(sentence))
        ]
        if all(part.label in shown for part in parts if isinstance(part, Mention)):
            spans += [" "] * bool(spans) + parts
    required = not beside or _label(beside, name) in shown
    return Paragraph(spans) if spans and required else None


def _drafts(part: DeclaredSection, results: Results) -> Iterator[Block | DraftedText]:
    """Yield blocks, and texts that depend on other blocks."""
    for declared in part.blocks:
        if not isinstance(declared, Repeated):
            yield from _single(declared, results)
            continue
        each, *arguments = declared.each.split()
        listed = partial(view(each), results) if "." in each else getattr(results, each)
        for name in [*listed(*arguments)][: declared.most]:
            drafts = [draft for block in declared.blocks for draft in _single(block, results, name)]
            if declared.heading and any(map(_is_evidence, drafts)):
                yield Heading(_filled(declared.heading, results, name))
            yield from drafts


def _single(
    declared: Block | DeclaredTable, results: Results, name: str = ""
) -> Iterator[Block | DraftedText]:
    """Yield a block of the contents, filled from results; name: recording, arm or study of it."""
    arguments = (results, name) if name else (results,)
    match declared:
        case Paragraph(sentences=sentences) if sentences:
            yield from (Paragraph([text]) for text in view(sentences)(*arguments))
        case Paragraph():
            yield partial(_paragraph, _filled(declared.text, results, name), declared.beside, name)
        case Items():
            items = [*view(declared.entries)(*arguments)]
            if items and declared.above:
                yield Paragraph([declared.above])
            if items:
                yield replace(declared, items=items)
        case DeclaredTable():
            left_out = results.many and not name and declared.by_recording
            body = Body([], []) if left_out else body_of(declared, results, name)
            if body.rows:
                yield _table(declared, body, results, name)
        case Picture():
            path = results.figures / name / f"{declared.figure}.svg"
            if _has_numbers(path):
                numbers = path.with_suffix(".csv")
                header, shown = _header(numbers), drawn_in_words(numbers)
                lines = [*header, *labels(header)]
                yield replace(
                    declared,
                    caption=_filled(declared.caption, results, name, lines, shown),
                    path=path,
                    alternative=_filled(declared.alternative, results, name, lines, shown),
                    label=_label(declared.figure, name),
                    source=str(path.with_suffix(".csv").relative_to(results.figures.parent)),
                    of=name,
                )
        case Cards():
            yield replace(declared, cards=view(declared.judged)(*arguments))
        case Code():
            yield from view(declared.listing)(*arguments)
        case _:
            yield declared


def _label(block: str, name: str) -> str:
    return f"{block}-{name}" if name else block


def _filled(
    text: str, results: Results, name: str, columns: Sequence[str] = (), drawn: str = ""
) -> str:
    """Return a text with the names of its recording or arm and of the leading estimate, and with
    the remarks that concern it; columns: of its table, or the labels of what its figure draws;
    drawn: the same in words.
    """
    kinds = {"thesis": results.of_thesis, "other": name in results.other_arms}
    kinds |= {"ur": not kinds["other"], "fit": results.roles().get(name) == "fit"}
    kinds["saturated"] = "quality" in results.tables and bool(forces.saturated(results, [name]))
    concerned = {*columns, *(kind for kind, holds in kinds.items() if holds)}
    text = CONDITIONAL_TEXT.sub(lambda remark: remark[2] * (remark[1] in concerned), text)
    known = {"{leading}": ESTIMATES[LEADING], "{of}": name, "{drawn}": drawn}
    return reduce(lambda said, key: said.replace(key, known[key]), known, spoken(text))


def shown_table(table: str, results: Results, name: str = "") -> Body:
    """Return header and rows of a table of the contents; name: recording, arm or study of it."""
    blocks = contents().blocks()
    declared = {block.table: block for block in blocks if isinstance(block, DeclaredTable)}
    return body_of(declared[table], results, name)


def body_of(declared: DeclaredTable, results: Results, name: str = "") -> Body:
    """Return header and rows of a declared table; name: recording, arm or study of it."""
    if declared.rows:
        rows = view(declared.rows)(*((results, name) if name else (results,)))
    else:
        rows = results.rows(declared.results)
    if declared.where:
        rows = rows.query(declared.where, local_dict={"of": name}, engine="python")
    return tabulate(declared, rows, {"results": results})


def _table(declared: DeclaredTable, body: Body, results: Results, name: str) -> TableBlock:
    titles, rows = [title.partition(" [")[0] for title in body.header], body.rows
    caption = _filled(declared.caption, results, name, titles)
    if len(rows) > MOST_ROWS:
        caption += f" The first {MOST_ROWS} of {len(rows)} rows."
    pages = {file: file for file in map("tables/{}.csv".format, results.tables)}
    linked = [
        [replace(cell, link=pages.get(cell.text, "")) for cell in row] for row in rows[:MOST_ROWS]
    ]
    source = f"tables/{declared.results}.csv" if declared.results in results.tables else ""
    return TableBlock(caption, body.header, linked, _label(declared.table, name), source)


def _in_a_sentence(table: TableBlock) -> Items:
    cells = zip(table.header, table.rows[0], strict=True)
    told = "; ".join(f"{title}: {cell.text}" for title, cell in cells)
    return Items([f"{table.caption} {told}."])


def _has_numbers(path: Path) -> bool:
    """Whether a figure was drawn and has numbers: its CSV has more than a header."""
    numbers = path.with_suffix(".csv")
    if not numbers.is_file():
        return False
    with numbers.open(encoding="utf-8") as lines:
        return sum(1 for _ in zip(range(2), lines, strict=False)) == 2


def _header(numbers: Path) -> list[str]:
    """Return the names of the columns of a figure's numbers."""
    with numbers.open(encoding="utf-8", newline="") as lines:
        return next(csv.reader(lines))


def labels(header: Sequence[str]) -> list[str]:
    """Return the labels of what a figure draws in panels, by the names of its numbers."""
    named = map(LINE_COLUMN.fullmatch, header)
    return [*dict.fromkeys(match[1] for match in named if match)]


def drawn_in_words(numbers: Path) -> str:
    """Return what a figure over time shows, by the names of its numbers; empty of other figures."""
    header = _header(numbers)
    drawn = labels(header)
    errors = [label.removeprefix(ERROR) for label in drawn if label.startswith(ERROR)]
    shown = [
        label for label in drawn if label not in (*BAND_EDGES, UNFILTERED) and ERROR not in label
    ]
    banded = [*errors, *shown][0] if BAND_EDGES[0] in drawn else None
    words = {"banded": banded, "pale": UNFILTERED in drawn, "hidden": HIDDEN in header}
    words["gaps"] = _has_gaps(numbers)
    return say("figure.drawn", lines=shown, errors=errors, **words) if shown else ""


def _has_gaps(numbers: Path) -> bool:
    """Whether the time, the first column of a figure's numbers, is empty between others."""
    with numbers.open(encoding="utf-8") as lines:
        return any(line.startswith(",") for line in lines)


def _is_evidence(block: DeclaredBlock | DraftedText) -> bool:
    """Whether a block comes from results, unlike the texts that are the same in every report."""
    return not (callable(block) or isinstance(block, Paragraph | Heading))


def _is_filled(section: Section, part: DeclaredSection) -> bool:
    """Whether results fill a section that is not of texts alone."""
    expected = any(map(_is_evidence, part.blocks))
    return any(map(_is_evidence, section.blocks)) if expected else bool(section.blocks)


def _notice(recordings: Sequence[Mapping[str, object]]) -> str:
    """Return a notice of simulated recordings, if any."""
    simulated = [str(r["name"]) for r in recordings if r.get("simulate") or r.get("truth")]
    if not simulated:
        return ""
    some = f"{len(simulated)} recordings" if simulated[MOST_SHOWN:] else ", ".join(simulated)
    some = "all recordings" if len(simulated) == len(recordings) else some
    return f"Simulated: {some} of this study are of the virtual test stand, not of a real arm."
