"""The methods as a paper cites them."""

import re
from pathlib import Path

import pandas as pd

from ur5lib.report.page.sentences import names
from ur5lib.report.results import Results
from ur5lib.report.views.citing import methods, references, to_copy


def results() -> Results:
    times = pd.DataFrame({"last_end": ["2026-01-02T10:00:00", "2027-01-03T09:00:00"]})
    return Results({"study": "a_b"}, {"run_times": times}, Path(), commit="abc")


def test_each_reference_is_cited_and_each_citation_listed() -> None:
    markdown, latex, bibtex = (block.text for block in to_copy(results()))
    known = {*names("reference")}
    assert {*re.findall(r"@\w+{(\w+),", bibtex)} == known | {"ur5lib"}
    assert {*re.findall(r"\[@(\w+)\]", markdown)} == known
    assert {*re.findall(r"\\cite{(\w+)}", latex)} == known
    assert bibtex.count("{") == bibtex.count("}")
    assert bibtex.count("author = {") == bibtex.count("title = {") == len(known) + 1
    assert "author = {H. E. Rauch and F. Tung and C. T. Striebel}" in bibtex


def test_what_is_read_names_authors_and_what_analysed_the_study() -> None:
    read, listed = " ".join(methods(results())), references(results())
    for reference in names("reference").values():
        assert reference.partition(":")[0].split(", ")[0].split()[-1] in read
        assert f"{reference}." in listed
    assert "“a_b”, analysed on 2027-01-03" in listed[0]
    assert listed[0].endswith("commit abc, 2027.")
