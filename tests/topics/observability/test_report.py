"""What the report says of pushes that are noticed and of the speeds at which bands hold."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.conftest import Workflow
from tests.made_study import study
from tests.topics.pages import shown
from ur5lib.records.pushes import SmallestPush
from ur5lib.report.page.compose import shown_table
from ur5lib.report.results import Results
from ur5lib.tables import read_csv
from ur5lib.topics.observability.report import bands, tried
from ur5lib.topics.observability.rows import Observed

COLUMNS = ["robot", *(one.name for one in fields(Observed))]


def observed(rows: list[dict[str, Any]], **tables: list[dict[str, Any]]) -> Results:
    """A study with these rows of observability.csv."""
    results = study(**tables)
    table = pd.DataFrame(rows, columns=COLUMNS)
    return replace(results, tables={**results.tables, "observability": table})


def pushed(rows: list[dict[str, Any]], **tables: list[dict[str, Any]]) -> Results:
    """A study with these rows of pushes.csv."""
    results = observed([], **tables)
    table = pd.DataFrame(rows, columns=["robot", *(one.name for one in fields(SmallestPush))])
    return replace(results, tables={**results.tables, "pushes": table})


def push(
    force: float, axis: str, motion: str, std: float = 5.0, reason: str = ""
) -> dict[str, Any]:
    """A row of pushes.csv."""
    known = {"robot": "ur5", "motion": motion, "axis": axis, "largest_tried": 100.0, "seconds": 1.0}
    value = {
        "value": force,
        "std_error": std,
        "low": force - 1.96 * std,
        "high": force + 1.96 * std,
    }
    if force > 100:
        value = {"value": 100.0, "std_error": np.nan, "low": np.nan, "high": np.nan}
    bound = {"bound": ">" if force > 100 else np.nan, "reason": reason or np.nan}
    return known | value | bound


REST = [push(force, axis, "at rest") for force, axis in ((40.0, "x"), (672.0, "y"), (80.0, "z"))]
SLOW = [push(force, axis, "slow") for force, axis in ((14.0, "x"), (28.0, "y"), (12.0, "z"))]


def test_the_table_has_the_pushes_that_are_known() -> None:
    """The trials end at 100 N; in fast motion, none is determined."""
    unknown = push(np.nan, "x", "fast", reason="undetermined")
    body = shown_table("pushes", pushed([*REST, *SLOW, unknown]))
    assert [[cell.text for cell in row] for row in body.rows] == [
        ["at rest", "40 (30 to 50)", "> 100", "80 (70 to 90)"],
        ["slow", "14 (4 to 24)", "28 (18 to 38)", "12 (2 to 22)"],
    ]
    wide = shown_table("pushes", pushed([push(93.0, "z", "slow", std=20.0)]))
    assert "93 (54 to > 100)" in [cell.text for cell in wide.rows[0]]


def test_the_section_says_what_the_trials_rest_on() -> None:
    """How long a push lasts, and where one path or fit recordings alone were tried."""
    assert [*tried(pushed([]))] == []
    (duration,) = tried(pushed(SLOW))
    assert "lasts 1 s" in duration
    (alone,) = tried(pushed([push(np.nan, "x", "slow", reason="one_path")] * 2))
    assert "no push is stated" in alone
    _, told = tried(pushed([push(20.0, "x", "slow", reason="fitted")] * 2))
    assert "fit recordings alone" in told


def test_without_rows_nothing_is_shown() -> None:
    assert shown("observability", study()) == []
    assert shown("observability", observed([])) == []


def test_results_without_pushes_show_the_bands() -> None:
    """Of results that an earlier version built, observability.csv alone is read."""
    row = {"robot": "ur5", "quantity": "band_at_rest", "joint": 1, "speed_low": 0.0, "value": 3.0}
    assert shown("observability", observed([row])) == ["Items"]


def test_the_order_of_axes_is_that_of_their_names() -> None:
    """Where the first motion lacks x, it stood last."""
    rows = [push(30.0, axis, "at rest") for axis in "yz"]
    body = shown_table("pushes", pushed(rows + [push(20.0, axis, "fast") for axis in "xyz"]))
    assert [title[0] for title in body.header[1:4]] == [*"xyz"]


@pytest.mark.parametrize(
    ("share", "high", "place"),
    [
        (0.62, 0.05, "joint 2 between 0.02 and 0.05 rad/s"),
        (0.62, None, "joint 2 above 0.02 rad/s"),
    ],
)
def test_the_section_says_at_which_speed_the_band_holds_least(
    share: float, high: float | None, place: str
) -> None:
    """And how much wider it is at rest; a recording as a whole hides a few seconds."""
    at_rest, slow = ({"speed_low": low, "speed_high": end} for low, end in ((0, 0), (0.02, high)))
    rows = [
        {"robot": "ur5", "quantity": name, "joint": joint, "value": value} | speeds
        for name, speeds, values in (
            ("band_at_rest", at_rest, (3.8, 7.25)),
            ("friction_in_band", slow, (0.97, share)),
        )
        for joint, value in enumerate(values, start=1)
    ]
    answer, *by_speed = bands(observed(rows), "ur5")
    assert "3.8 to 7.2 times as wide as in motion" in answer
    assert "nothing tests the bands" in answer
    assert [f"least on {place}: 62" in told for told in by_speed] == [True]


def test_the_section_says_what_the_bands_of_resting_joints_hold() -> None:
    """Of the readings, and of which width they would hold 95 %: the user's “can I trust it?”."""
    known = {"robot": "ur5", "speed_low": 0.0, "speed_high": 0.005}
    values = {"band_at_rest": (4.0, 5.0), "friction_in_band": (0.94, 1.0)}
    values["rest_band_factor"] = (1.04, 0.5)
    rows = [
        known | {"quantity": name, "joint": joint, "value": value}
        for name, pair in values.items()
        for joint, value in enumerate(pair, start=1)
    ]
    told, _ = bands(observed(rows), "ur5")
    for number in (
        "94\u00a0to\u00a0100 %",
        "0.5\u00a0to\u00a01.0 of that width",
        "5 times as wide as in motion",
    ):
        assert number in told
    assert [*bands(observed(rows), "ur3")] == []


def test_the_figure_draws_what_the_tables_state(demo: Workflow) -> None:
    results = demo.folder / "results" / "demo"
    numbers = read_csv(results / "figures" / "ur5" / "observability.csv")
    for name, place in (
        ("observability", ["quantity", "joint", "speed_low"]),
        ("pushes", ["motion", "axis"]),
    ):
        table = read_csv(results / "tables" / f"{name}.csv").query("robot == 'ur5'")
        own = numbers.dropna(subset=place[0]).set_index(place)["value"].dropna()
        known = table.set_index(place)["value"].dropna()
        if name == "observability":
            known = known[known.index.get_level_values("quantity").isin({*numbers["quantity"]})]
        assert len(own)
        pd.testing.assert_series_equal(
            own.sort_index(), known.sort_index(), rtol=1e-4, check_index_type=False
        )
