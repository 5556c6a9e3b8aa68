"""The page of several studies: a row for each arm, the latest first, and what changed."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from lxml.html import HtmlElement, fromstring

from tests.made_study import study
from tests.report.illustrated import EVERY
from tests.typeset_page import plain
from ur5lib.errors import InputError
from ur5lib.report.results import Results
from ur5lib.report.several import several_page
from ur5lib.report.summary import last_summary, page_data, summary
from ur5lib.tables import json_text, write_text


def built(folder: Path, results: Results) -> Path:
    """A folder with the summary of a study, as `write_report` writes it."""
    folder.mkdir(exist_ok=True)
    named = replace(results, study={**results.study, "study": folder.name})
    data = page_data(named, last_summary(folder / "results.json"))
    write_text(json_text(summary(named, data)), folder / "results.json")
    return folder


def dated(folder: Path, day: str) -> Path:
    write_text(f"recordings: [{{name: one, date: {day}}}]\n", folder / "configuration.yaml")
    return folder


def page_of(folders: list[Path]) -> HtmlElement:
    return fromstring(several_page(folders, folders[0].parent / "studies.html"))


def test_studies_stand_side_by_side_the_latest_first(tmp_path: Path) -> None:
    old = dated(built(tmp_path / "old", study(**EVERY)), "2026-01-02")
    new = dated(built(tmp_path / "new", study()), "2026-03-04")
    page = page_of([old, new])
    cells = [[plain(one.text_content()) for one in row] for row in page.xpath("//tbody/tr")]
    assert [row[:2] for row in cells] == [["new", "ur5"], ["old", "ur5"]]
    assert "1 of 2" in cells[1]
    assert "◐ 2 of 3" in cells[1]
    assert page.xpath("//tbody//a/@href") == ["new/report.html", "old/report.html"]


def test_what_changed_since_the_build_before_is_said_without_being_asked(tmp_path: Path) -> None:
    folder = built(tmp_path / "one", study(**EVERY))
    more: dict[str, Any] = EVERY | {"contact_errors": EVERY["contact_errors"][:1]}
    built(folder, study(**more))
    text = plain(page_of([folder, built(tmp_path / "two", study(**EVERY))]).text_content())
    assert "one: 1 of 1 contacts found (before: 1" in text
    assert "two:" not in text


def test_a_folder_of_another_version_is_named(tmp_path: Path) -> None:
    write_text("{}", tmp_path / "results.json")
    with pytest.raises(InputError, match="another version"):
        several_page([tmp_path], tmp_path / "studies.html")
