"""The thesis's section: what a study with published values shows, and a wrong file of these."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from tests.conftest import PROJECT, Workflow, copy_project
from tests.topics.pages import section, shown
from ur5lib.errors import InputError
from ur5lib.report.results import Results
from ur5lib.topics.thesis import current_based, gains
from ur5lib.topics.thesis.printed_numbers import PRINTED_COLUMNS
from ur5lib.topics.thesis.reference import read_reference

OF_THESIS = {"reference": "thesis_reference.yaml"}


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
    entries = [{"name": name, "robot": "ur5", "role": "fit"} for name in ("first", "second")]
    told = section("thesis", Results(OF_THESIS | {"recordings": entries}, tables), "published")
    assert told.tables["gains"] == [
        {"recording": "R1 first", "gain": "position", "joint 1": "9.0 (8.0 to 12.0)"}
        | {"joint 2": "< 30"},
        {"recording": "R2 second", "gain": "position", "joint 1": "> 20", "joint 2": "2 to 29"},
    ]
    assert (
        "No one gain fits all recordings of ur5: position on joint 1. There, the controller is "
        "not this closed loop."
    ) in told.text


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


def results(pushes: list[dict[str, Any]], printed: Sequence[dict[str, Any]] = ()) -> Results:
    """A study of the thesis, and what two estimates find."""
    rows = pd.DataFrame(printed, columns=PRINTED_COLUMNS)
    return Results(OF_THESIS, {"fixed_threshold": pd.DataFrame(pushes), "printed": rows})


@pytest.mark.parametrize(
    ("found", "above", "holds"), [(4, 0.0, True), (3, 0.0, False), (4, 0.01, False)]
)
def test_the_claim_of_the_thesis_is_judged_by_its_numbers(
    found: int, above: float, holds: bool
) -> None:
    """Of its own recording and of what nothing touches, next to ours."""
    axis = {"component": "Fz", "force_n": 10.0}
    rows = [
        axis | {"recording": "pushed", "estimate": "F*", "pushes": 4, "found": found},
        axis | {"recording": "pushed", "estimate": "Fmap", "pushes": 4, "found": 2},
        axis | {"recording": "seen", "estimate": "F*", "time_above": above},
        axis | {"recording": "seen", "estimate": "Fmap", "time_above": 0.5},
        axis | {"recording": "fitted", "estimate": "F*", "time_above": 0.9},
    ]
    printed = [{"recording": "pushed", "table": "force_mae", "source": "Table 6.1"}]
    told = section("thesis", results(rows, printed)).text
    assert ("This fails" in told, "This holds" in told) == (not holds, holds)
    share = f"{100 * above:.0f} % of a recording without contact"
    for part in (f"finds {found} of 4 such pushes on R3 pushed", share, "F̂ᵐᵃᵖ: 2 and 50 %"):
        assert part in told
    more = section("thesis", results(rows, printed), "details").tables["fixed-threshold"]
    assert [row["F̂*"] for row in more if row["recording"] == "R1 fitted"] == ["90 %"]
    assert shown("thesis", results(rows)) is None, "nothing is printed"


@pytest.mark.parametrize("page", ["report", "details", "run"])
def test_a_study_of_other_arms_shows_nothing_of_the_thesis(page: str) -> None:
    assert shown("thesis", Results({}, {}), page) is None


def test_a_study_without_printed_recordings_says_so_on_the_page_of_the_thesis() -> None:
    told = section("thesis", Results(OF_THESIS, {}), "published").text
    assert "No published number is of a recording of this study." in told
