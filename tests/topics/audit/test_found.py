"""What the audit of wrist sensors adds to findings and steps."""

from dataclasses import replace

import pandas as pd

from tests.made_study import study
from ur5lib.report.found import findings
from ur5lib.report.next_steps import next_steps
from ur5lib.report.results import Results
from ur5lib.report.stated import Step

ROW = {"recording": "pushed", "quantity": "turn", "component": "x", "verdict": "wrong"}


def audited(*rows: dict[str, str]) -> Results:
    made = study()
    tables = {**made.tables, "audit": pd.DataFrame([*rows])}
    return replace(made, study={**made.study, "study": "mine"}, tables=tables)


def test_each_fault_of_a_wrist_sensor_is_a_finding_and_one_step() -> None:
    scale = ROW | {"quantity": "scale", "recording": "seen"}
    results = audited(ROW, ROW | {"component": "y"}, scale)
    assert [one for one in findings(results) if "wrist" in one] == [
        "The wrist sensor on “pushed” has a wrong turn of its axes.",
        "The wrist sensor on “seen” has a wrong scale.",
    ]
    assert Step(
        "Correct the wrist sensor on “pushed” and “seen”: wrong turn of its axes and scale.",
        "ur5 audit mine",
    ) in next_steps(results)


def test_a_right_sensor_is_none() -> None:
    right = audited(ROW | {"verdict": "right"})
    assert not any("wrist" in one for one in findings(right))
    assert not any("wrist" in one.sentence for one in next_steps(right))
