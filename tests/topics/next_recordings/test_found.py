"""What to record next, as a step."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from tests.made_study import study
from ur5lib import load
from ur5lib.report.next_steps import next_steps
from ur5lib.report.results import Results
from ur5lib.report.stated import Step
from ur5lib.tables import write_csv
from ur5lib.topics.next_recordings import found

TABLE = "next_recordings"
RANKED = [(found.NOW, 10.0), ("20 s, slowly", 9.7), ("20 s with 2 kg", 9.0)]


def ranked(worth: str, **changed: Any) -> Results:
    """A study in which the last one of `RANKED` narrows forces most."""
    known = {"robot": "ur5", "current": 0.1, "mass": 0.1, "worthwhile": worth}
    made = study(next_recordings=[known | {"after": a, "force": f} for a, f in RANKED])
    entries = [one | changed for one in made.study["recordings"]]
    known = {"study": "mine", "recordings": entries}
    return replace(made, study={**made.study, **known}, loads={"ur5": 2.0})


def test_the_recording_that_narrows_forces_most_is_a_step_with_its_command() -> None:
    assert Step(
        "Record 20 s with 2 kg, with ur5: this narrows the 95 % band of forces from ± 10 to ± 9 N.",
        "ur5 excite --robot ur5 --results results/mine --payload 2 0.06 0 0.05 "
        "--output raw/mine/loaded",
    ) in next_steps(ranked("yes"))


@pytest.mark.parametrize(("span", "asked"), [(None, True), ([0, 1], False)])
def test_without_one_a_span_at_rest_is_asked_for_unless_it_is_known(span: Any, asked: bool) -> None:
    steps = {one.command: one.sentence for one in next_steps(ranked("no", untouched=span))}
    assert ("untouched: [0, 1]" in steps) == asked
    assert not asked or "± 10 N of its forces" in steps["untouched: [0, 1]"]


def test_no_load_is_asked_for_that_narrows_nothing() -> None:
    rows = [("now", 10.0), ("20 s with 2 kg", 5.0), ("20 s", 5.02), ("20 s, slowly", 6.0)]
    known = {"robot": "ur5", "current": 0.1, "mass": 0.1, "worthwhile": "yes"}
    made = study(next_recordings=[known | {"after": after, "force": f} for after, f in rows])
    ((_, _, best),) = found.outlooks(made)
    assert best["after"] == "20 s"


def test_without_its_table_nothing_is_asked_for() -> None:
    made = ranked("yes")
    tables = {name: own for name, own in made.tables.items() if name != "next_recordings"}
    assert next_steps(replace(made, tables=tables)) == next_steps(study())


def test_its_table_has_units(tmp_path: Path) -> None:
    write_csv(pd.DataFrame({"force": [8.1], "mass": [0.1]}), tmp_path / "tables" / f"{TABLE}.csv")
    assert load(tmp_path).table(TABLE).attrs["units"] == {"force": "N", "mass": "kg"}
