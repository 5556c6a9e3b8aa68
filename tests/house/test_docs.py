"""The documents: their links lead somewhere."""

import ast
import functools
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.harness.markdown import (
    folded,
    markdown,
    read_page,
    replaced,
    table_in,
    write_page,
)
from benchmarks.harness.rules import RULES, with_evidence, with_rules
from benchmarks.pictures import OF_PAGES, PICTURES, with_columns
from tests.conftest import PROJECT
from ur5lib.jobs.code import all_steps, module_of
from ur5lib.jobs.declared import every
from ur5lib.judging.errors import REASONS_BY_GRAVITY
from ur5lib.report.figures.house_style import save

OTHERS = (
    *("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "config/README.md"),
    *("docs/skill/SKILL.md", "docs/llms.txt"),
)
PAGES = [*(PROJECT / name for name in OTHERS), *sorted((PROJECT / "docs").glob("*.md"))]
LINK = re.compile(r"\]\((?!https?:)([^)#]*)(?:#([^)]*))?\)")


def anchors(page: Path) -> set[str]:
    """What a page's headings are called in a link."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in headings}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target, anchor in LINK.findall(page.read_text()):
        path = (page.parent / target) if target else page
        assert path.exists(), target
        assert not anchor or anchor in anchors(path), anchor


def test_the_readme_leads_to_every_document() -> None:
    linked = {target for target, _ in LINK.findall((PROJECT / "README.md").read_text())}
    pages = (page for page in (PROJECT / "docs").iterdir() if page.is_file())
    assert {f"docs/{page.name}" for page in pages} <= linked


def test_the_report_s_page_lists_the_columns_of_all_tables() -> None:
    """Besides, it may have those whose rows steps write: of a topic that is deleted."""
    page = read_page(PROJECT / "docs" / "report.md")
    listed, written = page.splitlines(), with_columns(page).splitlines()
    more = [line for line in listed if line not in written]
    assert [line for line in written if line not in listed] == [], "`make pictures` writes them"
    assert all("| …, " in line for line in more)


def test_the_report_s_page_has_the_rules_of_the_code() -> None:
    """Limits, reasons and their words, with the reasons that judges give."""
    page = read_page(PROJECT / "docs" / "report.md")
    assert with_rules(page) == page, "`make pictures` writes them"
    known = {reason for rule in RULES for reason in rule.reasons}
    assert {*REASONS_BY_GRAVITY} - {""} <= known


def test_the_page_on_recordings_has_the_sources_of_evidence() -> None:
    page = read_page(PROJECT / "docs" / "recordings.md")
    assert with_evidence(page) == page, "`make pictures` writes them"


@pytest.mark.parametrize("name", OF_PAGES)
def test_pictures_of_tables_show_what_their_pages_say(name: str, tmp_path: Path) -> None:
    page, drawing = OF_PAGES[name]
    save(drawing(PROJECT / "docs" / f"{page}.md"), tmp_path / "drawn.svg")
    shown = (PICTURES / f"{name}.svg").read_bytes()
    assert (tmp_path / "drawn.svg").read_bytes() == shown, "`make pictures` draws it anew"


def test_a_benchmark_writes_its_table_of_numbers_alone(tmp_path: Path) -> None:
    """What a section has besides stays: the KR300's has the fields of an entry form."""
    table = folded("own", "| a | b |\n| --- | --- |\n| old, 1 |  |")
    text = f"## One\n\n| field |\n| --- |\n\n{table}\n\nmore\n\n## Two\n"
    write_page(text, page := tmp_path / "page.md")
    assert "[The numbers](data/own.csv)\n\nmore" in page.read_text()
    assert (tmp_path / "data" / "own.csv").read_text() == 'a,b\n"old, 1",\n'
    assert read_page(page) == text
    new = table_in(text, "One", "a").replace("old, 1", "new")
    replacing = markdown([*new], new.to_numpy().tolist())
    assert replaced(text, "One", replacing) == text.replace("old, 1", "new")
    plain = "## One\n\nwords\n\n| old |\n\n"
    assert replaced(plain, "One", "| new |") == plain.replace("old", "new")


def test_numbers_are_linked_by_a_page() -> None:
    linked = {target for page in PAGES for target, _ in LINK.findall(page.read_text())}
    assert {f"data/{one.name}" for one in (PROJECT / "docs" / "data").iterdir()} <= linked


def test_every_picture_is_shown() -> None:
    shown = {Path(target).name for page in PAGES for target, _ in LINK.findall(page.read_text())}
    assert {picture.name for picture in PICTURES.glob("*.[sp][vn]g")} <= shown


def test_the_readme_is_short() -> None:
    assert len((PROJECT / "README.md").read_text().splitlines()) <= 80


def test_the_changes_are_what_a_user_must_do() -> None:
    """The rest is in the history: one reads them before an update."""
    assert len((PROJECT / "CHANGELOG.md").read_text().split()) <= 1000


FOREIGN = (  # messages of the shell, make and Snakemake
    "bad interpreter",
    "snakemake: command not found",
    "ur5",
    "No Snakefile found",
    "no makefile found",
)


@functools.cache
def everything() -> str:
    """All that the program can say."""
    return "\n".join(texts())


def texts() -> Iterator[str]:
    """The strings of the program, with a mark for each value that they insert."""
    for path in [*PROJECT.glob("ur5*/**/*.py"), *(PROJECT / "workflow").rglob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.JoinedStr):
                parts = (v.value if isinstance(v, ast.Constant) else "\0" for v in node.values)
                yield "".join(map(str, parts))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield node.value
    for path in [PROJECT / "Makefile", PROJECT / "Snakefile", *PROJECT.glob("workflow/*/*.smk")]:
        yield re.sub(r'"\s*f?"', "", path.read_text())


def messages() -> list[str]:
    """What stands in the first column of the tables of messages."""
    page = (PROJECT / "docs" / "questions.md").read_text()
    cells = re.findall(r"^\| (.*?) \| ", page, re.MULTILINE)
    quoted = [text for cell in cells for text in re.findall(r"``(.*?) ?``|`([^`]+)`", cell)]
    return [double or single for double, single in quoted]


@pytest.mark.parametrize("message", sorted({*messages()} - {*FOREIGN}))
def test_messages_of_the_document_are_those_of_the_program(message: str) -> None:
    """But for the values in them: numbers, and what … stands for."""
    parts = [part.strip() for part in re.split(r"…|\d[\d.]*", message)]
    whole = [part for part in parts if len(part.split()) > 1] or [max(parts, key=len)]
    assert all(part in everything() for part in whole)


def test_the_table_of_the_design_has_every_step_of_recordings_and_arms() -> None:
    """What it is of and its files as it declares them; topics' steps stand in their folders."""
    page = (PROJECT / "docs" / "design.md").read_text()
    rows = re.findall(r"^\| (.*?) \| (.*?) \| (.*?) \|", page.split("## ")[1], re.MULTILINE)
    told = {
        frozenset(steps): (of, {*re.findall(r"`(.*?)`", files)})
        for cell, of, files in rows
        if (steps := re.findall(r"`(\w+)`", cell))
    }
    assert {step for steps in told for step in steps} <= {*all_steps()}
    for step in every():
        if step.of in ("recording", "arm") and module_of(step.name).parent.name == "steps":
            if step.name.startswith("draw_"):
                continue
            assert told[frozenset([step.name])] == (step.of, {*step.writes.values()})
