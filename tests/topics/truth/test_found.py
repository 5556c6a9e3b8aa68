"""What a simulation's truth adds to the findings."""

from dataclasses import replace

import pandas as pd
import pytest

from tests.made_study import study
from ur5lib.report.found import findings


@pytest.mark.parametrize(("held", "told"), [(95, "wide"), (93, ""), (87, ""), (80, "narrow")])
def test_intervals_that_contain_the_truth_too_often_or_too_seldom_are_a_finding(
    held: int, told: str
) -> None:
    """0.95 to the power of 95 is 0.77 %."""
    inside = ["yes"] * held + ["no"] * (95 - held) + [None]
    made = study()
    results = replace(made, tables={**made.tables, "truth": pd.DataFrame({"within95": inside})})
    found = [one for one in findings(results) if one.startswith("Intervals")]
    assert found == [
        f"Intervals are too {told}: {held} of 95 contain the truth of the simulation, where 90 "
        "would be right."
    ] * bool(told)
