"""The thesis's section: what a study with published values shows, and a wrong file of these."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from tests.conftest import PROJECT, Workflow, copy_project
from ur5lib.errors import InputError
from ur5lib.report.page.compose import shown_table
from ur5lib.report.results import Results
from ur5lib.topics.thesis import current_based, gains
from ur5lib.topics.thesis.reference import read_reference
from ur5lib.topics.thesis.report import claim, contradictions, scores


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ("root:x:0:0\nbin: x: 1:\n", "mapping values are not allowed"),
        ("", "it is no mapping"),
        ("text\n", "it is no mapping"),
        ("printed: {force_me: 1}\nerrata: [{place: a}]\n", "`errata[0].error` is missing; give"),
    ],
)
def test_a_file_that_holds_no_published_values_is_told(
    tmp_path: Path, content: str, fault: str
) -> None:
    path = tmp_path / "reference.yaml"
    path.write_text(content)
    with pytest.raises(InputError, match=f"^{path} does not hold published values") as told:
        read_reference(path)
    assert fault in str(told.value)


def test_no_job_begins_where_the_key_of_a_study_names_such_a_file(tmp_path: Path) -> None:
    workflow = Workflow(copy_project(tmp_path / "project"))
    config = workflow.folder / "config.yaml"
    config.write_text(f"reference: Snakefile\n{config.read_text()}")
    done = workflow.run("--dry-run")
    assert done.returncode == 1
    assert "`reference`: Snakefile does not hold published values" in done.stdout


def test_gains_stand_with_their_range_and_contradictions_are_told() -> None:
    nan = float("nan")
    ranges = [  # of joint 1, then of joint 2
        [("first", 9.0, 8.0, 12.0, "yes"), ("second", nan, 20.0, nan, "no")],
        [("first", nan, nan, 30.0, "no"), ("second", nan, 2.0, 29.0, "no")],
    ]
    columns = ["recording", "value", "low", "high", "determined"]
    rows = [
        pd.DataFrame(part, columns=columns).assign(joint=i + 1) for i, part in enumerate(ranges)
    ]
    tables = {"gains": pd.concat(rows).assign(gain="position")}
    study = {"recordings": [{"name": name, "robot": "ur5"} for name in ("first", "second")]}
    results = Results(study, tables, Path())
    lines = [[cell.text for cell in row][2:] for row in shown_table("gains", results).rows]
    assert lines == [["9.0 (8.0–12.0)", "< 30"], ["> 20", "2–29"]]
    assert [*contradictions(results)] == [
        "No single position gain fits all recordings of ur5 on joint 1: there, the controller "
        "is not this closed loop."
    ]


@pytest.mark.parametrize(
    "statement",
    [
        f"within the {100 * gains.CONFIDENCE_LEVEL:g} % point of F(2, n − 2)",
        f"narrower than a factor of {gains.MAX_RANGE_FACTOR:g}.",
        f"{1e3 * current_based.PUBLISHED_JACOBIAN_LAG:g} ms earlier, as in the published script",
    ],
)
def test_the_page_of_methods_states_the_numbers_of_the_program(statement: str) -> None:
    page = re.sub(r"\s+", " ", (PROJECT / "docs" / "methods.md").read_text())
    assert statement in page


def study(pushes: list[dict[str, Any]], printed: Sequence[dict[str, Any]] = ()) -> Results:
    """A recording of each role, and what two estimates find on it."""
    roles = {"fitted": "fit", "seen": "validate", "pushed": "contact"}
    entries = [{"name": name, "robot": "ur5", "role": role} for name, role in roles.items()]
    tables = {"fixed_threshold": pd.DataFrame(pushes)}
    tables["printed"] = pd.DataFrame(printed, columns=["recording", "table", "status"])
    return Results({"recordings": entries}, tables, Path())


@pytest.mark.parametrize(
    ("found", "above", "holds"), [(4, 0.0, True), (3, 0.0, False), (4, 0.01, False)]
)
def test_the_claim_of_the_thesis_is_judged_by_its_numbers(
    found: int, above: float, holds: bool
) -> None:
    """Of its own recording and of what nothing touches; ours stands beside it."""
    axis = {"component": "Fz", "force_n": 10.0}
    rows = [
        axis | {"recording": "pushed", "estimate": "F*", "pushes": 4, "found": found},
        axis | {"recording": "pushed", "estimate": "Fmap", "pushes": 4, "found": 2},
        axis | {"recording": "seen", "estimate": "F*", "time_above": above},
        axis | {"recording": "seen", "estimate": "Fmap", "time_above": 0.5},
        axis | {"recording": "fitted", "estimate": "F*", "time_above": 0.9},
    ]
    printed = [{"recording": "pushed", "table": "force_mae"}]
    results = study(rows, printed)
    (finding,), (beside,) = claim(results), scores(results)
    assert ("fails" not in finding) == holds
    assert f"{4 - found} of 4" in finding or f"{100 * above:.0f} %" in finding
    numbers = [f"F̂* finds {found} of these 4", f"{100 * above:.0f} %", "F̂ᵐᵃᵖ finds 2 of", "50 %"]
    assert [number for number in numbers if number not in beside] == []
    unprinted = study(rows)
    assert [*claim(unprinted)] == scores(unprinted) == []
