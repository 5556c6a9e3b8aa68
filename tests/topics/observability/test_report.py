"""What the report says of pushes that are noticed and of the speeds at which bands hold."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.made_study import judged_anew, sensed, study
from tests.topics.pages import section, shown
from ur5lib.records.pushes import PushDirection, PushesFound, SmallestPush
from ur5lib.report.results import Results
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


def directed(**tables: list[dict[str, Any]]) -> Results:
    """A study with pushes by direction and force; up, nothing is found where the arm is folded."""
    about = {"robot": "ur5", "recording": "seen", "time_s": 12.34, "motion": "slow"}
    directions = [
        about | {"posture": posture, "plane": plane, "angle_deg": angle, "value": value}
        for posture in ("stretched out", "folded")
        for plane, up in (("horizontal", 30.0), ("vertical", 20.0 + 1e9 * (posture == "folded")))
        for angle, value in ((0.0, 10.0), (90.0, up), (180.0, 10.0), (270.0, up))
    ]
    for row in directions:
        row["value"] = row["value"] if row["value"] < 100 else np.nan
    curve = [
        {"robot": "ur5", "motion": "slow", "force": force, "share": force / 100}
        for force in (1.0, 10.0, 95.0)
    ]
    results = pushed(SLOW, **tables)
    kinds = {"push_directions": (PushDirection, directions), "push_curve": (PushesFound, curve)}
    made = {
        name: pd.DataFrame(rows, columns=["robot", *(one.name for one in fields(kind))])
        for name, (kind, rows) in kinds.items()
    }
    return replace(results, tables={**results.tables, **made})


def test_each_posture_is_drawn_with_its_place_and_gaps() -> None:
    shown = section("observability", directed())
    assert shown.figures == ["directions-ur5"], "without a force sensor, no real contact"
    for posture, up in (("stretched out", 20), ("folded", 10)):
        place = f"{posture}, slow, R2 at 12.3 s: "
        assert f"{place}horizontal 10 to 30 N, vertical 10 to {up} N" in shown.drawn
    drawn = shown.section.xpath(".//figure[@id='directions-ur5']//path/@d")
    ends = [path.lstrip("M").split("L") for path in drawn]
    closed = [points for points in ends if len(points) > 1 and points[0] == points[-1]]
    assert len(closed) == 3, "of four curves, one has gaps"


def test_each_real_contact_is_a_tick_of_its_fate() -> None:
    """As many as there are, at the upper edge if found, at the lower one if missed."""
    fates = ((30.0, "found"), (20.0, "missed"), (12.0, "merged"), (40.0, "found"))
    shown = section("observability", directed(contact_errors=sensed(*fates)))
    assert shown.figures == ["directions-ur5", "found-by-force-ur5"]
    ticks = shown.section.xpath(".//figure[@id='found-by-force-ur5']//line[@stroke-width='1.4']")
    upper = [tick for tick in ticks if float(tick.get("y1")) < float(tick.get("y2"))]
    assert (len(ticks), len(upper)) == (4, 3)
    assert "real contacts found: 3 of 4" in shown.drawn


def sizes(results: Results) -> list[tuple[str, ...]]:
    """The table of pushes: motion, then the smallest one along each axis."""
    rows = section("observability", results).tables["pushes"]
    return [tuple(row[name] for name in ("flange", "x [N]", "y [N]", "z [N]")) for row in rows]


def test_the_table_has_the_pushes_that_are_known() -> None:
    """The trials end at 100 N; in fast motion, none is determined."""
    unknown = push(np.nan, "x", "fast", reason="undetermined")
    results = pushed([*REST, *SLOW, unknown])
    assert sizes(results) == [
        ("at rest", "40 (30 to 50)", "> 100", "80 (70 to 90)"),
        ("slow", "14 (4 to 24)", "28 (18 to 38)", "12 (2 to 22)"),
    ]
    drawn = section("observability", results, "details").drawn
    for told in ("at rest along x 40 (30 to 50) N", "at rest along y > 100 N", "slow", "along z"):
        assert told in drawn
    rows = section("observability", pushed([push(93.0, "z", "slow", std=20.0)])).tables["pushes"]
    assert rows == [{"flange": "slow", "z [N]": "93 (54 to > 100)"}]


def test_the_order_of_axes_is_that_of_their_names() -> None:
    """Where the first motion lacks x, it came last."""
    rows = [push(30.0, axis, "at rest") for axis in "yz"]
    results = pushed(rows + [push(20.0, axis, "fast") for axis in "zyx"])
    first, _ = section("observability", results).tables["pushes"]
    assert [*first][1:4] == ["x [N]", "y [N]", "z [N]"]


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (SLOW, "A force of zero with its band holds only if nothing touches the arm."),
        ([push(np.nan, "x", "slow", reason="one_path")] * 2, "no push is stated to be found"),
        ([push(20.0, "x", "slow", reason="fitted")] * 2, "only fit recordings were tried"),
        ([push(20.0, "x", "slow", reason="uncalibrated")] * 2, "without a fit"),
    ],
)
def test_the_section_says_what_the_trials_rest_on(rows: list[dict[str, Any]], told: str) -> None:
    """Where one path or fit recordings alone were tried."""
    assert told.lower() in section("observability", pushed(rows)).text.lower()


def test_the_section_says_how_long_a_push_lasts_and_where_it_is_found_best_and_worst() -> None:
    judged = judged_anew(pushed([*REST, *SLOW]))
    text = section("observability", judged).text
    assert "Smallest trial push found along an axis, best motion 12 N on, along z, slow." in text
    assert "Trial push of 1 s not found: > 100 N" in text


def test_without_rows_nothing_is_shown() -> None:
    for page in ("report", "details"):
        assert shown("observability", study(), page) is None
        assert shown("observability", observed([]), page) is None


def test_results_without_pushes_show_the_bands() -> None:
    """Of results that an earlier version built, observability.csv alone is read."""
    row = {"robot": "ur5", "quantity": "band_at_rest", "joint": 1, "speed_low": 0.0, "value": 3.0}
    assert shown("observability", observed([row])) is None
    told = section("observability", observed([row]), "details").text
    assert "3.0 times as wide as in motion; no reading tests them" in told


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
    """A recording as a whole hides a few seconds."""
    at_rest, slow = ({"speed_low": low, "speed_high": end} for low, end in ((0, 0), (0.02, high)))
    rows = [
        {"robot": "ur5", "quantity": name, "joint": joint, "value": value} | speeds
        for name, speeds, values in (
            ("band_at_rest", at_rest, (3.8, 7.2)),
            ("friction_in_band", slow, (0.97, share)),
        )
        for joint, value in enumerate(values, start=1)
    ]
    warned = section("observability", observed(rows)).text
    assert f"bands of the currents are too narrow on {place} (62 % of the readings" in warned
    more = section("observability", observed(rows), "details")
    assert "3.8 to 7.2 times as wide as in motion; no reading tests them" in more.text
    assert f"least on {place}: 62 %" in more.text
    assert more.figures == ["bands-by-speed-ur5"]
    assert f"Joint 2: {100 * share:.0f} % at" in more.drawn


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
    told = section("observability", observed(rows), "details").text
    for number in ("94 to 100 %", "0.5 to 1.0 of that width", "4.0 to 5.0 times as wide"):
        assert number in told
    assert shown("observability", observed(rows)) is None, "no band is too narrow"
