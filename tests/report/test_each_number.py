"""Each number of a page is its row's: value, unit, label, sign, whole."""

import re
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import pytest
from lxml.html import HtmlElement, tostring

from tests.conftest import Workflow
from tests.made_study import study
from tests.numbers_of_a_page import checked
from tests.report.illustrated import EVERY
from tests.report.test_first_screen import STUDIES
from tests.typeset_page import built, page_of, sources
from ur5lib.errors import InputError
from ur5lib.report.page.handed import Tables, rows_of
from ur5lib.report.page.typeset import html_page
from ur5lib.report.results import Results

PEAKS = {"peak_error": -8.0, "impulse": 10.0, "impulse_error": -1.0, "onset_error_s": 0.1}
FELT = EVERY | {"contact_errors": [row | PEAKS for row in EVERY["contact_errors"]]}


@pytest.mark.parametrize("name", STUDIES)
def test_each_number_of_a_made_up_page_is_its_rows(name: str) -> None:
    results = study(**STUDIES[name])
    checked(page_of(results), results.tables["verdicts"])


def test_each_number_of_the_default_study_is_its_rows(demo: Workflow) -> None:
    results = built(demo.folder / "results" / "demo")
    assert checked(page_of(results), results.tables["verdicts"]) > 50


@pytest.fixture(scope="module")
def felt() -> tuple[HtmlElement, Results]:
    results = study(**FELT)
    page = page_of(results)
    assert checked(page, results.tables["verdicts"]) > 30
    return page, results


CHANGES: dict[str, tuple[str, str]] = {  # of texts: five words, five numbers
    "a label": ("contacts found", "contacts felt"),
    "a unit": (r"(\b4\.0) N", r"\1 Nm"),
    "a sign in words": ("too small", "too large"),
    "what is counted": (
        "joints whose constant may be used",
        "joints whose constant may be typed in",
    ),
    "a label of an error": ("mean absolute error", "largest absolute error"),
    "a count": (r"\b1 of 2", "2 of 2"),
    "a whole": (r"\b2 of 3", "2 of 4"),
    "a value": (r"\b4\.0 N", "3.9 N"),
    "a minus": ("−26.7", "26.7"),
    "a power of ten": (r"\b0\.200 A", "0.0200 A"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_changed_word_or_number_is_found(felt: tuple[HtmlElement, Results], change: str) -> None:
    page, results = felt
    before, after = CHANGES[change]
    text = tostring(page, encoding="unicode").replace("\u00a0", " ")
    changed = in_rows(page, lambda own: re.sub(before, after, own, flags=re.IGNORECASE))
    assert tostring(changed, encoding="unicode").replace("\u00a0", " ") != text
    with pytest.raises(AssertionError):
        checked(changed, results.tables["verdicts"])


def in_rows(page: HtmlElement, changed: Callable[[str], str]) -> HtmlElement:
    """A page whose sentences of rows are changed, one text after the other."""
    page = deepcopy(page)
    for element in page.xpath("//span[@data-line]"):
        text = " ".join(element.text_content().replace("\u00a0", " ").split())
        if changed(text) != text:
            for inner in [*element]:
                element.remove(inner)
            element.text = changed(text)
            break
    return page


def test_a_number_without_a_row_is_found(felt: tuple[HtmlElement, Results]) -> None:
    page, results = deepcopy(felt[0]), felt[1]
    page.xpath("//p[@class='headline']")[0].text = "7 contacts; "
    with pytest.raises(AssertionError):
        checked(page, results.tables["verdicts"])


def test_a_table_that_no_step_writes_is_an_error() -> None:
    made = study()
    known = replace(made, tables=Tables(made.tables))
    with pytest.raises(InputError, match=r"contact_erors.*contact_errors"):
        rows_of("contact_erors", known)


def test_a_column_that_rows_lack_is_an_error() -> None:
    with sources(study(**FELT)) as root:
        text = (root / "sections" / "force.typ").read_text()
        copied(root, "force.typ", text.replace('"peak", "peak_error"', '"peak", "peak_eror"'))
        with pytest.raises(InputError, match="peak_eror"):
            html_page(root)


def copied(root: Path, name: str, text: str) -> None:
    """Copy the sections, which are linked, and change one."""
    every = {path.name: path.read_text() for path in (root / "sections").glob("*.typ")}
    (root / "sections").unlink()
    (root / "sections").mkdir()
    for own, words in (every | {name: text}).items():
        (root / "sections" / own).write_text(words)
