"""What the published numbers add to the findings."""

from dataclasses import replace

import pandas as pd
import pytest

from tests.made_study import study
from ur5lib.force.estimators import LEADING
from ur5lib.report.found import findings
from ur5lib.report.results import Results
from ur5lib.topics.thesis import found

PRINTED = {"table": "force_mae", "recording": "pushed"}


def compared(*statuses: str, **pushes: list[dict[str, object]]) -> Results:
    """A study with published numbers of these statuses."""
    rows = [PRINTED | {"status": status} for status in statuses]
    printed = pd.DataFrame(rows, columns=["table", "recording", "status"])
    made = study(**pushes)
    return replace(made, tables={**made.tables, "printed": printed})


def pushes(missed: int, above: float) -> list[dict[str, object]]:
    """Pushes of the recording with printed errors, and the time above on one without contact."""
    rows = []
    for name, lost in (("F*", missed), (LEADING, 0)):
        row = {"component": "Fz", "estimate": name, "time_above": above}
        rows.append(row | {"recording": "pushed", "pushes": 9, "found": 9 - lost})
        rows.append(row | {"recording": "seen"})
    return rows


def test_unexplained_numbers_are_findings_and_explained_ones_are_not() -> None:
    told = "1 of 3 published numbers are unexplained; 1 are rebuilt, errata explain 1."
    results = compared("equal", "unexplained", "erratum 2")
    assert [*found.findings(results)] == [told]
    assert told in findings(results)
    assert [*found.findings(compared("equal", "erratum 2"))] == []


@pytest.mark.parametrize(
    ("missed", "above", "said"),
    [
        (3, 0.0, "misses 3 of 9 along z (ours: 0)"),
        (0, 0.07, "exceeds 10 N in 7 % of a run"),
        (0, 0.0, ""),
    ],
)
def test_a_claim_is_a_finding_where_it_fails(missed: int, above: float, said: str) -> None:
    told = [*found.findings(compared("equal", fixed_threshold=pushes(missed, above)))]
    assert len(told) == bool(said)
    assert all(said in one for one in told)


def test_nothing_is_said_without_published_numbers() -> None:
    assert [*found.findings(compared())] == []
    tables = {name: own for name, own in study().tables.items() if name != "printed"}
    assert not any("published" in one for one in findings(replace(study(), tables=tables)))
