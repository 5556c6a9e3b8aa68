"""A report of many recordings: an overview by month, and a page of each recording on demand."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from tests.made_tables import empty
from ur5lib.errors import InputError
from ur5lib.report.page.compose import compose
from ur5lib.report.page.document import (
    MOST_ROWS,
    DeclaredSection,
    Document,
    Picture,
    TableBlock,
    contents,
)
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.overview import estimates, friction, quality
from ur5lib.report.views.recordings import judge_files
from ur5lib.tidy import columns

MANY = 2 * (MOST_ROWS + 1)
DAYS = pd.date_range("2026-01-30", periods=MANY, freq="D")
LOST, LOADED, ABSENT = "run_7", "run_40", "run_9"


def made(count: int = MANY) -> Results:
    """A study of two arms: one run a day, in turn; of one, no file can be used."""
    names = [f"run_{k}" for k in range(count)]
    entries = [
        {"name": name, "robot": f"arm_{k % 2}", "role": "validate", "date": DAYS[k].date()}
        for k, name in enumerate(names)
    ]
    used = pd.DataFrame({"recording": [name for name in names if name != ABSENT]})
    filled = {
        "recordings": {"frames": 1000, "duration_s": 10.0, "moving_joints": "1 2", "devices": ""},
        "payload": {"mass": 0.5, "taken": "no"},
        "current_rmse": {"model": "fitted", "joint": 1, "rmse_2hz": 0.1, "r2": 0.0},
        "detection": {"estimate": "Fmap", "alarms_per_min": 2.0},
    }
    tables = {name: empty(name).astype(object) for name in columns()} | {
        name: used.assign(**row).reindex(columns=empty(name).columns)
        for name, row in filled.items()
    }
    tables["health"] = pd.DataFrame(
        columns=["robot", "date", "joint", "quantity", "value", "temperature_c"]
    )
    lost = {"device": "robot", "finding": "lost frames", "severity": "warning", "detail": "lost"}
    tables["quality"] = pd.DataFrame([{"recording": LOST, "count": 50, "place": ""} | lost])
    tables["payload"].loc[used["recording"] == LOADED, "taken"] = "yes"
    study = {"study": "s", "title": "t", "recordings": entries}
    return Results(study, tables, Path())


def test_each_month_counts_its_recordings_and_names_the_worst() -> None:
    months = pd.concat([quality(made(), arm) for arm in ("arm_0", "arm_1")])
    assert months["recordings"].sum() == MANY
    assert (months["recordings"] - months["used"]).sum() == 1
    assert set(months["month"]) == {day.strftime("%Y-%m") for day in DAYS}
    (worst,) = months[months["warning"] > 0].itertuples()
    assert (worst.month, worst.lost_of, worst.lost_most) == ("2026-02", LOST, 0.05)


def test_estimates_of_a_month_are_those_of_its_recordings() -> None:
    rows = estimates(made(), "arm_0")
    assert (rows["current_median"] == 1).all()
    assert (rows["alarm_most"] == 2).all()
    (loaded,) = rows.dropna(subset="load_of").itertuples()
    assert (loaded.load_count, loaded.load_most, loaded.load_of) == (1, 0.5, LOADED)


def test_friction_is_the_median_of_a_months_dates() -> None:
    days = ["2026-01-01", "2026-01-02", "2026-01-30", "2026-02-01"]
    rows = pd.DataFrame({"date": days, "value": [1.0, 2.0, 9.0, 3.0], "temperature_c": 30.0})
    rows = rows.assign(robot="ur5", quantity="coulomb", joint=1)
    found = friction(Results({}, {"health": rows}, Path()), "ur5")
    assert [*found["value"]] == [2.0, 3.0]


SHOWN = [
    DeclaredSection.model_validate(part)
    for part in (
        {"title": "First", "blocks": [{"sentences": "overview.pages"}]},
        next(one for one in contents().report(False) if one.title == "Overview by month"),
        {"title": "Runs", "blocks": [{"table": "recordings.a",
         "caption": "", "columns": {"run": "recording"}},
         {"table": "current_rmse.b",
          "caption": "", "columns": {"joint": "joint", "on": "recording"}},
        ]},
    )
]  # fmt: skip


@pytest.fixture
def document() -> Document:
    return compose(SHOWN, made())


def test_many_recordings_have_an_overview_in_place_of_a_row_each(document: Document) -> None:
    tables = {block.label: block for block in document.blocks() if isinstance(block, TableBlock)}
    assert "recordings.a" not in tables
    assert "current_rmse.b" in tables  # its rows are joints
    cells = [cell for row in tables["quality.by_month-arm_1"].rows for cell in row]
    assert {cell.link for cell in cells} == {"", f"runs/{LOST}.html"}
    few = compose(SHOWN, made(MOST_ROWS))
    assert [block.label for block in few.blocks() if isinstance(block, TableBlock)] == [
        "recordings.a",
        "current_rmse.b",
    ]


def test_a_file_that_cannot_be_used_is_no_good_data() -> None:
    whole = made()
    months = DAYS.strftime("%Y-%m").nunique()
    assert judge_files(whole).drawing.count("<rect") == 2 * months  # a bar of each month
    without = replace(whole, tables=whole.tables | {"quality": whole.tables["quality"][:0]})
    assert judge_files(without).state == "usable"
    assert judge_files(without).sentence == say("quality.left out", count=1, of=MANY)


def test_what_was_left_out_has_no_page() -> None:
    with pytest.raises(InputError, match=ABSENT):
        made().of_run(ABSENT)


def test_a_page_shows_one_recording_alone() -> None:
    own = made().of_run(LOST)
    assert own.roles() == {LOST: "validate"}
    assert {name for table in own.tables.values() for name in table.get("recording", ())} == {LOST}
    page = compose(contents().run, own)
    assert page.title == f"{LOST}, t"
    shown = [block for block in page.blocks() if isinstance(block, TableBlock | Picture)]
    assert {"recordings", "quality.findings"} <= {block.label for block in shown}
