"""What the health of joints adds to the steps."""

from dataclasses import replace

import pandas as pd
import pytest

from tests.made_study import study
from ur5lib.report.next_steps import next_steps
from ur5lib.report.stated import Step

CHANGE = {"robot": "ur5", "joint": 4, "quantity": "coulomb", "kind": "jump", "before": 8.0}
CHANGE |= {"size": 2.0, "first": "2026-03-18", "last": "2026-03-21"}
FIRST = "Fit ur5 only to recordings since 21 March 2026: Coulomb friction of joint 4 changed."


def fits(*changes: dict[str, object]) -> list[Step]:
    made, rows = study(), pd.DataFrame([*changes], columns=[*CHANGE])
    results = replace(made, tables={**made.tables, "health_changes": rows})
    return [one for one in next_steps(results) if one.sentence.startswith("Fit ")]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({}, FIRST),
        (
            {"kind": "drift", "quantity": "torque_constant"},
            "Fit ur5 only to the latest recordings: torque constant of joint 4 drifts.",
        ),
        (
            {"kind": "drift", "quantity": "noise"},
            "Fit ur5 only to the latest recordings: noise of the current of joint 4 drifts.",
        ),
    ],
)
def test_the_largest_change_asks_for_a_fit_to_later_recordings(
    change: dict[str, object], told: str
) -> None:
    small = CHANGE | {"joint": 2, "size": -0.5}
    assert fits(small, CHANGE | change) == [Step(told, "role: validate")]


def test_an_offset_alone_asks_for_none() -> None:
    assert fits(CHANGE | {"quantity": "offset"}) == fits() == []
