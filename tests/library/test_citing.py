"""The methods as a paper cites them."""

import re
from pathlib import Path

import pandas as pd

from ur5lib.report.results import Results
from ur5lib.report.views.citing import REFERENCES, methods, references, to_copy


def results() -> Results:
    times = pd.DataFrame({"last_end": ["2026-01-02T10:00:00", "2026-01-03T09:00:00"]})
    return Results({"study": "a_b"}, {"run_times": times}, Path(), commit="abc")


def test_each_reference_is_cited_and_each_citation_listed() -> None:
    markdown, latex, bibtex = (block.text for block in to_copy(results()))
    entries = {*re.findall(r"@\w+{(\w+),", bibtex)}
    assert entries == {*REFERENCES, "ur5lib"}
    assert {*re.findall(r"\[@(\w+)\]", markdown)} == {*REFERENCES}
    assert {*re.findall(r"\\cite{(\w+)}", latex)} == {*REFERENCES}
    assert bibtex.count("{") == bibtex.count("}")


def test_what_is_read_names_authors_and_what_analysed_the_study() -> None:
    read = " ".join(methods(results()))
    listed = [*references(results())]
    for work in REFERENCES.values():
        assert f"{work.authors[0].split()[-1]}" in read
        assert any(work.title in line and str(work.year) in line for line in listed)
    assert "commit abc, study “a_b”, analysed on 3 January 2026" in listed[-1]
