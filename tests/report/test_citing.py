"""The methods as a paper cites them."""

import re
from dataclasses import replace

import pandas as pd
import pytest
from lxml.html import HtmlElement

from tests.made_study import study
from tests.typeset_page import page_of, plain
from ur5lib.datasets.catalogue import catalogue
from ur5lib.report.views.citing import CITED, published

COSTS = ("jobs", "wall_s", "cpu_s", "start_up_s", "max_rss_mb")
KNOWN = {reference.key for reference in CITED}


def files() -> pd.DataFrame:
    """What a study read: two files of a published data set and one of its user."""
    known = [*catalogue()["ur10e"].checksums.values()][:2]
    return pd.DataFrame({"file": [*"abc"], "sha256": [*known, "0" * 64]})


@pytest.fixture(scope="module")
def methods() -> HtmlElement:
    ends = ["2026-01-02T10:00:00", "2027-01-03T09:00:00"]
    made = study()
    times = pd.DataFrame({name: [1.0] * 2 for name in COSTS} | {"step": [*"ab"], "last_end": ends})
    tables = {**made.tables, "run_times": times.assign(first_end=ends), "files": files()}
    named = {**made.study, "study": "a_b"}
    page = page_of(replace(made, tables=tables, study=named, commit="abc"))
    section: HtmlElement = page.get_element_by_id("methods")
    return section


def to_copy(methods: HtmlElement) -> list[str]:
    """Markdown, LaTeX and BibTeX, as typed."""
    return [one.text_content() for one in methods.iter("pre")]


def test_each_reference_is_cited_and_each_citation_listed(methods: HtmlElement) -> None:
    markdown, latex, bibtex = to_copy(methods)
    assert {*re.findall(r"@\w+{(\w+),", bibtex)} == KNOWN | {"ur5lib"}
    assert {*re.findall(r"\[@(\w+)\]", markdown)} == KNOWN
    assert {*re.findall(r"\\cite{(\w+)}", latex)} == KNOWN
    assert bibtex.count("{") == bibtex.count("}")
    assert bibtex.count("author = {") == bibtex.count("title = {") == len(KNOWN) + 1
    assert "author = {H. E. Rauch and F. Tung and C. T. Striebel}" in bibtex


def test_what_latex_reads_as_commands_is_escaped(methods: HtmlElement) -> None:
    _, latex, bibtex = to_copy(methods)
    assert "“a\\_b”" in bibtex
    assert not re.search(r"(?<!\\)[%&#_]", re.sub(r"\\cite{\w+}", "", latex) + bibtex)


def test_what_is_read_names_authors_and_what_analysed_the_study(methods: HtmlElement) -> None:
    read = plain(methods.text_content())
    for reference in CITED:
        name = reference.author[0].split()[-1]
        assert re.search(rf"\({name}( et al\.)? {reference.year}\)", read)
        assert f"{', '.join(reference.author)}: {reference.title}" in read
    assert "“a_b”, analysed on 2027-01-03" in read
    assert "commit abc, 2027." in read


def test_where_recordings_come_from_is_known_by_their_content(methods: HtmlElement) -> None:
    made = study()
    address = catalogue()["ur10e"].address
    (found,) = published(replace(made, tables={**made.tables, "files": files()}))
    assert found == {"name": "ur10e", "address": address, "count": 2, "of": 3}
    assert f"Recordings of ur10e: {address}." in plain(methods.text_content())
