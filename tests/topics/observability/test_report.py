"""What the report says of pushes that are noticed and of the speeds at which bands hold."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.conftest import Workflow
from tests.report.test_verdicts import predicted, said, study, touched
from tests.topics.pages import shown
from ur5lib.report.page import topics
from ur5lib.report.page.compose import shown_table
from ur5lib.report.results import Results
from ur5lib.report.views.contacts import judge_force
from ur5lib.report.views.currents import judge_currents
from ur5lib.report.views.first_screen import result
from ur5lib.tables import read_csv
from ur5lib.topics.observability.report import too_small
from ur5lib.topics.observability.rows import Observed

COLUMNS = ["robot", *(one.name for one in fields(Observed))]
CONTACT = {"recording": "pushed", "estimate": "Fmap", "kind": "contact"}
TRIED = {"robot": "ur5", "quantity": "largest_push", "value": 100.0}
force, currents = topics.with_answers(judge_force), topics.with_answers(judge_currents)


def observed(rows: list[dict[str, Any]], **tables: list[dict[str, Any]]) -> Results:
    """A study with these rows of observability.csv."""
    results = study(**tables)
    table = pd.DataFrame(rows, columns=COLUMNS)
    return replace(results, tables={**results.tables, "observability": table})


def push(force: float, axis: str, speed: float, std: float = 5.0) -> dict[str, Any]:
    """A row of observability.csv."""
    beyond = {"bound": ">", "value": 100.0, "std_error": np.nan}
    known = {"robot": "ur5", "quantity": f"smallest_push_95_{axis}", "speed_low": speed}
    found = {"bound": "", "value": force, "std_error": std}
    return known | (beyond if force > 100 else found)


REST = [push(force, axis, 0.0) for force, axis in ((40.0, "x"), (672.0, "y"), (80.0, "z"))]
SLOW = [push(force, axis, 0.01) for force, axis in ((14.0, "x"), (28.0, "y"), (12.0, "z"))]


def test_the_card_quotes_pushes_where_the_contacts_are_and_the_table_all() -> None:
    """The trials end at 100 N; at rest larger ones are needed, but no contact was found there."""
    rows = [*REST, *SLOW, push(1.0, "x", 0.25, std=260.0), TRIED]
    errors = {"force_mae": touched(2.0)}
    told = said(force(observed(rows, **errors, contacts=[CONTACT | {"flange_speed": 0.1}])))
    assert "in slow motion (95 %) from 14, 28, 12 N on along x, y, z" in told
    assert "; at rest, they are noticed from 40 N on along x, z only" in told
    told = said(force(observed(rows, **errors)))
    assert "from 40, 80 N on along x, z, but along y not reliably even at 100 N" in told
    assert "; in slow motion, they are noticed from 12 to 28 N on by axis" in told
    body = shown_table("observability.pushes", observed(rows, **errors))
    assert [[cell.text for cell in row] for row in body.rows] == [
        ["at rest", "40 (30 to 50)", "> 100", "80 (70 to 90)", "0"],
        ["slow", "14 (4 to 24)", "28 (18 to 38)", "12 (2 to 22)", "0"],
    ]
    nowhere = [CONTACT | {"flange_speed": 0.5}]
    told = said(force(observed(rows, **errors, contacts=nowhere)))
    assert "No recording without contact shows which pushes are noticed in fast motion" in told


def test_the_first_sentence_begins_with_the_pushes() -> None:
    (told,) = result(observed([*SLOW, TRIED], force_mae=touched(2.0)))
    assert told.startswith("Pushes from 28 N on (95 %: 18 to 38) are noticed in slow motion")
    pushes = [push(60.0, "x", 0.01), push(93.0, "y", 0.01, std=20.0), TRIED]
    (told,) = result(observed(pushes, force_mae=touched(2.0)))
    assert told.startswith("Pushes from 93 N on (95 %: 54 to > 100) are noticed")
    (told,) = result(observed([*REST, *SLOW, TRIED], force_mae=touched(2.0)))
    assert told.startswith(
        "Pushes of 100 N, the largest tried, may stay unnoticed at rest (along y); in slow"
    )
    (told,) = result(
        observed([*REST, *SLOW[:2], push(101.0, "z", 0.01), TRIED], force_mae=touched(2.0))
    )
    assert told.startswith(
        "Pushes of 100 N, the largest tried, may stay unnoticed at rest (along y) and in slow"
    )
    assert "(trials on the fit recordings alone)" in told
    tested = [{"recording": "seen", "estimate": "Fmap", "alarms_per_min": 0.0}]
    whole = observed([*SLOW, TRIED], force_mae=touched(2.0), detection=tested)
    assert not any("alone" in one for one in (*result(whole), said(force(whole))))


def test_without_its_table_cards_and_the_first_sentence_say_less() -> None:
    known = {"force_mae": touched(2.0), "current_rmse": predicted(0.2)}
    results = study(**known)
    assert shown("observability", results) == []
    assert force(results) == judge_force(results)
    assert currents(results) == judge_currents(results)
    (less,), (all_of_it,) = result(results), result(observed([*SLOW, TRIED], **known))
    assert all_of_it.casefold().endswith(less.casefold())
    empty = observed([], **known)
    assert shown("observability", empty) == []
    assert force(empty) == judge_force(empty)


def test_the_order_of_axes_is_that_of_their_names() -> None:
    """Where the first speed lacks x, it stood last."""
    rows = [push(30.0, axis, 0.0) for axis in "yz"] + [push(20.0, axis, 0.25) for axis in "xyz"]
    body = shown_table("observability.pushes", observed([*rows, TRIED]))
    assert [title[0] for title in body.header[1:4]] == [*"xyz"]


def test_forces_that_could_not_be_noticed_are_named() -> None:
    """An alarm of 5 N, below the 12 N that are noticed at that speed along z; a push of 7 N."""
    alarms = [
        CONTACT | {"flange_speed": speed, "peak_s": peak, "Fx": 3.0, "Fy": 4.0, "Fz": along_z}
        for speed, peak, along_z in ((0.1, 1.0, 0.0), (0.1, 2.0, 20.0), (0.5, 3.0, 0.0))
    ]
    alarms = [row | {"start_s": row["peak_s"], "end_s": row["peak_s"] + 0.5} for row in alarms]
    sensed = [
        CONTACT | {"component": "norm", "start_s": start, "end_s": start + 0.5, "peak": peak}
        for start, peak in ((5.0, 7.0), (7.0, 50.0))
    ]
    (found,) = too_small(observed([*SLOW, TRIED], contacts=alarms))
    (missed,) = too_small(observed([*SLOW, TRIED], contacts=alarms, contact_errors=sensed))
    assert "Of the contacts found on pushed, 1 is smaller" in found
    assert found.endswith("at 1.0 s.")
    assert "Of the contacts missed on pushed, 1 of 2 is smaller" in missed


@pytest.mark.parametrize(
    ("share", "high", "place"),
    [
        (0.95, 0.05, ""),
        (0.62, 0.05, "joint 2 between 0.02 and 0.05 rad/s"),
        (0.62, None, "joint 2 above 0.02 rad/s"),
    ],
)
def test_currents_say_at_which_speed_the_band_holds_least(
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
    answer, *by_speed = currents(observed(rows, current_rmse=predicted(0.2))).answers
    assert "3.8 to 7.2 times as wide as in motion" in answer
    assert "nothing tests the bands" in answer
    assert [f"least on {place}: 62" in told for told in by_speed] == [True] * bool(place)


def test_currents_say_what_the_bands_of_resting_joints_hold() -> None:
    """Of the readings, and of which width they would hold 95 %: the user's “can I trust it?”."""
    known = {"robot": "ur5", "speed_low": 0.0, "speed_high": 0.005}
    values = {"band_at_rest": (4.0, 5.0), "friction_in_band": (0.94, 1.0)}
    values["rest_band_factor"] = (1.04, 0.5)
    rows = [
        known | {"quantity": name, "joint": joint, "value": value}
        for name, pair in values.items()
        for joint, value in enumerate(pair, start=1)
    ]
    told = said(currents(observed(rows, current_rmse=predicted(0.2))))
    for number in (
        "94\u00a0to\u00a0100 %",
        "0.5\u00a0to\u00a01.0 of that width",
        "5 times as wide as in motion",
    ):
        assert number in told


def test_the_figure_draws_what_the_table_states(demo: Workflow) -> None:
    results, place = demo.folder / "results" / "demo", ["quantity", "joint", "speed_low"]
    table = read_csv(results / "tables" / "observability.csv").query("robot == 'ur5'")
    numbers = read_csv(results / "figures" / "ur5" / "observability.csv")
    drawn, known = (own.set_index(place)[["value", "samples"]].dropna() for own in (numbers, table))
    stated = known[known.index.get_level_values("quantity").isin({*numbers["quantity"]})]
    assert len(drawn)
    pd.testing.assert_frame_equal(
        drawn.sort_index(), stated.sort_index(), rtol=1e-4, check_dtype=False
    )
