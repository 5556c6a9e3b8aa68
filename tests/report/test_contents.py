"""The contents of the pages: what is shown is mentioned, named and described for every arm."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from lxml.html import HtmlElement, fromstring

from tests.made_study import constant, judged_anew, predicted, study
from tests.report.illustrated import figures, illustrated
from tests.typeset_page import page_of, plain, sources, tables_of, text_of
from ur5lib.channels import TORQUE
from ur5lib.report.page.handed import WORDS
from ur5lib.report.page.typeset import html_page
from ur5lib.report.results import Results

PAGES = ("report", "details")
SOURCES = "".join(path.read_text() for path in WORDS)
SHOWN = re.compile(r'"/(\w+)"|(?:over-time|figure-of)\("(\w+)"|pictured\([\w.]+, "(\w+)"')


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return illustrated(tmp_path_factory.mktemp("figures"))


@pytest.fixture(scope="module")
def pages(results: Results) -> dict[str, HtmlElement]:
    """Report and details of one study."""
    with sources(results) as root:
        return {page: fromstring(html_page(root, page)) for page in PAGES}


def test_every_figure_that_a_rule_draws_is_on_a_page() -> None:
    """One that is named otherwise is left out without an error."""
    drawn = {name for names in figures().values() for name in names}
    assert len(drawn) > 20
    assert {name for name in drawn if not re.search(rf'[/"]{name}\b', SOURCES)} == set()
    shown = {name for pair in SHOWN.findall(SOURCES) for name in pair if name}
    assert len(shown) > 20
    assert shown - drawn == set()


def shown_on(page: HtmlElement) -> Iterator[str]:
    """The names of tables and figures."""
    yield from page.xpath("//div[@class='scroll']/@id | //figure/@id")


def test_every_table_and_figure_of_the_report_is_mentioned(pages: dict[str, HtmlElement]) -> None:
    """So that a reader knows what to look at it for."""
    links = {*pages["report"].xpath("//a/@href")}
    every = [*shown_on(pages["report"])]
    assert len(every) > 10
    assert [name for name in every if f"#{name}" not in links] == []


def test_no_link_leads_nowhere(pages: dict[str, HtmlElement], results: Results) -> None:
    places = {f"{name}.html": {*page.xpath("//@id")} for name, page in pages.items()}
    for name, page in pages.items():
        for link in page.xpath("//a/@href"):
            file, _, place = link.partition("@")[0].partition("#")
            if not file.startswith(("tables", "configuration", "docs", "figures", "published")):
                assert not place or place in places[file or f"{name}.html"], link
            elif file.startswith("figures"):
                assert results.figures.parent / file.replace("figures", results.figures.name)


def test_alternative_texts_say_more_than_captions(pages: dict[str, HtmlElement]) -> None:
    for page in pages.values():
        pictures = page.xpath("//figure[.//img]")
        assert pictures
        for figure in pictures:
            (alternative,) = figure.xpath(".//img/@alt")
            assert len(alternative) > 40, alternative
            assert plain(alternative) not in plain(figure.find("figcaption").text_content())
        for drawing in page.xpath("//*[local-name()='svg'][not(@aria-hidden)]"):
            assert len(drawing.get("aria-label")) > 20


def test_a_figure_of_the_first_screen_is_shown_once(pages: dict[str, HtmlElement]) -> None:
    report = pages["report"]
    (first,) = report.xpath("//section[@class='first']//figure")
    assert [*shown_on(report)].count(first.get("id")) == 1
    assert len({*shown_on(report)}) == len([*shown_on(report)])


# Arms


def test_arms_that_sense_torque_have_no_currents(tmp_path: Path) -> None:
    """Texts, headings and units say torque and Nm; what a user named keeps its currents."""
    made = illustrated(tmp_path, effort=TORQUE)
    titled = replace(made, study={**made.study, "title": "No current of A"})
    for page in PAGES:
        text = " ".join(text_of(titled, page).split("No current of A"))
        assert [*re.finditer(r"[Cc]urrents?\b(?!\.csv)|\[A\]|\d A\b|Nm/A", text)] == [], page
    assert page_of(titled).find(".//title").text == "No current of A"


def two_arms(**tables: Any) -> Results:
    """A study whose first recording is of another arm than the others."""
    made = study(**tables)
    entries = [
        one | {"robot": "ur10e" if one["name"] == "fitted" else "ur5", "role": "validate"}
        for one in made.study["recordings"]
    ]
    return judged_anew(made, study={**made.study, "recordings": entries})


def test_arms_in_one_study_are_told_apart() -> None:
    """And one alone is not named in every row."""
    rows = [constant(1, 10.0), constant(1, 17.0, robot="ur10e", use="no", reason="unlikely")]
    tables = {"friction": rows, "current_rmse": predicted(0.1) + predicted(0.8, recording="fitted")}
    both = two_arms(**tables)
    shown = tables_of(both)
    assert [row["arm"] for row in shown["constants-by-joint"]] == ["ur5", "ur10e"]
    assert {row["arm"] for row in shown["currents-by-joint"]} == {"ur5", "ur10e"}
    said = {
        card.get("data-question"): plain(card.text_content())
        for card in page_of(both).xpath("//article")
    }
    assert "On ur10e" in said["constants"]
    assert "ur10e, joint" in said["currents"]
    assert "arm" not in tables_of(study(**tables))["constants-by-joint"][0]


@pytest.mark.parametrize(("other", "said"), [(False, "the arm upright"), (True, "joints at zero")])
def test_captions_know_the_arm(results: Results, other: bool, said: str) -> None:
    arms = frozenset({"ur5"} if other else ())
    page = page_of(replace(results, other_arms=arms), "details")
    (caption,) = page.xpath("//figure[@id='ur5-models']/figcaption")
    assert said in plain(caption.text_content())


def test_remarks_of_the_thesis_are_on_its_pages_alone(pages: dict[str, HtmlElement]) -> None:
    for name, page in pages.items():
        assert not re.search("thesis|erratum|after Fig", plain(page.text_content())), name
