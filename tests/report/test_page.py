"""The page of a study: typeset whatever the study lacks, with an error's place, in few words."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import PROJECT, Workflow
from tests.made_study import finding, judged_anew, study
from tests.made_tables import COLUMNS
from tests.report.illustrated import EVERY
from tests.typeset_page import cards_of, page_of, plain, sources, text_of
from ur5lib.errors import InputError
from ur5lib.jobs.declared import every
from ur5lib.report.page.handed import ROWS, SOURCES, WORDS, rows_of, rows_read, views
from ur5lib.report.page.typeset import html_page, pdf_document
from ur5lib.report.results import Results

PAGES = ("report", "details", "run", "published")


def emptied(rows: Path) -> Iterator[set[str]]:
    """Empty one view after the other, then a column of each view at once; yield their names."""
    every = {path: json.loads(path.read_text()) for path in rows.glob("*.json")}
    whole = {path: own for path, own in every.items() if own}
    for path, own in whole.items():
        path.write_text("{}" if isinstance(own, dict) else "[]")
        yield {path.stem}
        path.write_text(json.dumps(own))
    tables = {path: own for path, own in whole.items() if is_table(own)}
    for number in range(max(len(own[0]) for own in tables.values())):
        wide = {path: own for path, own in tables.items() if number < len(own[0])}
        for path, own in wide.items():
            path.write_text(json.dumps([without(row, number) for row in own]))
        yield {path.stem for path in wide}
        for path, own in wide.items():
            path.write_text(json.dumps(own))


def is_table(rows: Any) -> bool:
    return isinstance(rows, list) and bool(rows) and isinstance(rows[0], dict)


def without(row: dict[str, Any], number: int) -> dict[str, Any]:
    """A row whose cell in one column is empty."""
    return {name: None if i == number else value for i, (name, value) in enumerate(row.items())}


def views_by_page() -> dict[str, set[str]]:
    """The views that each page reads: those of the sections with a function of its name; of the
    report those of the kit, too.
    """
    texts = [path.read_text() for path in WORDS]
    read = {
        page: {*ROWS.findall("".join(own for own in texts if f"#let {page}(" in own))}
        for page in PAGES
    }
    kit = "".join(path.read_text() for path in WORDS if path.parent.name == "kit")
    return read | {"report": read["report"] | {*ROWS.findall(kit)}}


def assert_typeset_when_empty(results: Results) -> None:
    read = views_by_page()
    with sources(results) as root:
        for names in emptied(root / "data" / "rows"):
            for page in PAGES:
                if names & read[page]:
                    html_page(root, page)


def test_a_page_of_made_up_results_is_typeset_whatever_is_empty() -> None:
    assert_typeset_when_empty(study(quality=[finding("warning")], **EVERY))


def test_results_without_anything_have_a_page() -> None:
    made = study()
    bare = Results(made.study, {name: table[:0] for name, table in made.tables.items()})
    assert "Made up" in text_of(judged_anew(bare))


def test_every_view_that_a_section_reads_exists() -> None:
    rules = [*PROJECT.glob("workflow/rules/*.smk"), *PROJECT.glob("ur5lib/topics/*/rules.smk")]
    made = {*re.findall(r"\w+", "".join(path.read_text() for path in rules)), *COLUMNS}
    made |= {Path(file).stem for step in every() for file in step.writes.values()}
    for name in rows_read():
        module, _, function = name.rpartition(".")
        if module:
            assert hasattr(views()[module], function), name
        else:
            assert name in made, name


def test_a_view_of_a_topic_without_its_table_is_empty_and_a_wrong_name_an_error() -> None:
    with sources(study()) as root:
        of_audit = [*(root / "data" / "rows").glob("audit.*.json")]
        assert {path.read_text() for path in of_audit} == {"[]"}
    with pytest.raises(AttributeError):
        rows_of("recordings.legends", study())


@pytest.mark.parametrize("wrong", ["#unkown-word", "#fixed(", "#rows.first().name"])
def test_a_typo_in_a_section_is_an_error_with_its_place(wrong: str) -> None:
    with sources(study()) as root:
        (root / "sections").unlink()
        (root / "sections").mkdir()
        for path in SOURCES.glob("sections/*.typ"):
            text = path.read_text()
            (root / "sections" / path.name).write_text(text)
        currents = root / "sections" / "currents.typ"
        lines = currents.read_text().count("\n")
        currents.write_text(f"{currents.read_text()}{wrong}\n")
        with pytest.raises(InputError) as error:
            html_page(root)
    told = str(error.value)
    assert f"ur5lib/report/page/sections/currents.typ:{lines + 1}:" in told
    assert "^" in told


def test_text_from_outside_is_text(tmp_path: Path) -> None:
    hostile = "<script>alert(1)</script> #panic() $x$ `y` </style> @ref"
    made = study(quality=[finding("stop", detail=hostile)])
    made = judged_anew(made, study={**made.study, "title": hostile})
    page = page_of(made)
    assert hostile.replace("`", "") in plain(page.text_content()).replace("`", "")
    assert all("alert" not in script.text_content() for script in page.iter("script"))
    with sources(made) as root:
        assert pdf_document(root).startswith(b"%PDF")


def test_two_builds_are_equal() -> None:
    def made() -> tuple[str, bytes]:
        with sources(study(quality=[finding("warning")])) as root:
            return html_page(root), pdf_document(root)

    assert made() == made()


def test_the_page_asks_for_nothing_and_runs_its_own_scripts_alone() -> None:
    page = page_of(study())
    (policy,) = page.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")
    assert policy.startswith("default-src 'none'")
    assert policy.count("'sha256-") == len(page.xpath("//script[not(@type)]"))
    assert page.xpath("//*[@onclick or @onload]") == []


def test_cards_have_the_numbers_and_states_of_their_verdicts() -> None:
    made = study(quality=[finding("warning"), finding("error")])
    rows = made.tables["verdicts"]
    for card in cards_of(made):
        own = rows[rows["question"] == card["question"]]
        assert card["state"] is None or card["state"] in {*own["state"]}
        if (digits := "".join(filter(str.isdigit, card["number"]))) and "." not in card["number"]:
            assert int(digits) in {*own["count"].dropna(), *own["value"].dropna().round()}


def test_no_source_of_the_page_is_forgotten() -> None:
    assert {path.suffix for path in WORDS} == {".typ"}


@pytest.mark.thorough
def test_the_default_study_is_typeset_whatever_is_empty(demo: Workflow) -> None:
    from tests.typeset_page import built

    assert_typeset_when_empty(built(demo.folder / "results" / "demo"))
