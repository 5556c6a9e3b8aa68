"""A report of many recordings, and the page of one of them on demand."""

from dataclasses import replace

import pandas as pd
import pytest

from tests.made_study import judged_anew, predicted
from tests.made_tables import COLUMNS, empty
from tests.typeset_page import page_of, tables_of
from ur5lib.errors import InputError
from ur5lib.judging.recordings import judge_recordings
from ur5lib.records.codes import Found
from ur5lib.report.results import MOST_ROWS, Results
from ur5lib.study.model import Settings

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
        "current_rmse": predicted(0.1)[0] | {"recording": None},
        "detection": {"estimate": "Fmap", "alarms_per_min": 2.0},
    }
    tables = {name: empty(name).astype(object) for name in COLUMNS} | {
        name: pd.DataFrame(row, used.index).assign(**used).reindex(columns=empty(name).columns)
        for name, row in filled.items()
    }
    lost = {
        "device": "robot",
        "code": Found.LOST_FRAMES,
        "finding": Found.LOST_FRAMES.words,
        "severity": "warning",
        "detail": "lost",
    }
    tables["quality"] = pd.DataFrame([{"recording": LOST, "count": 50, "place": ""} | lost])
    tables["payload"].loc[used["recording"] == LOADED, "taken"] = "yes"
    settings = Settings().model_dump()
    study = {"study": "s", "title": "t", "recordings": entries, "settings": settings}
    return judged_anew(Results(study, tables))


def test_many_recordings_have_no_row_each() -> None:
    """The gravest are named, with the command that makes the page of one."""
    results = made()
    shown = tables_of(results)
    assert max(map(len, shown.values())) < MOST_ROWS
    named = [row["recording"].split()[-1] for row in shown["legend"]]
    assert LOST in named[:2]
    section = page_of(results).get_element_by_id("recordings")
    assert "runs/run_0.html" in section.text_content()


def test_the_details_say_how_many_rows_a_table_leaves_out() -> None:
    page = page_of(made(), "details")
    (table,) = page.xpath("//div[@id='legend']")
    assert len(table.xpath(".//tbody/tr")) == MOST_ROWS
    assert f"The first {MOST_ROWS} of {MANY} rows." in table.text_content()
    assert not page.xpath("//div[@id='files-read']")


def test_few_recordings_have_a_row_each() -> None:
    assert len(tables_of(made(MOST_ROWS))["legend"]) == MOST_ROWS


def test_no_cell_leads_to_a_page_that_was_not_made() -> None:
    links = page_of(made()).xpath(
        "//table//a/@href[not(starts-with(., 'tables/') or starts-with(., '#'))]"
    )
    assert links == []


def test_a_file_that_cannot_be_used_is_no_good_data() -> None:
    whole = made()
    (first, *_) = judge_recordings(whole)
    assert (first.state, first.reason) == ("usable", "unread")
    assert (first.recording, first.count, first.of) == (ABSENT, 1, MANY)
    without = replace(whole, tables=whole.tables | {"quality": whole.tables["quality"][:0]})
    assert next(judge_recordings(without)) == first


def test_what_was_left_out_has_no_page() -> None:
    with pytest.raises(InputError, match=ABSENT):
        made().of_run(ABSENT)


def test_a_page_shows_one_recording_alone() -> None:
    """Under the number that it has in the report."""
    own = made().of_run(LOST)
    assert own.roles() == {LOST: "validate"}
    assert {name for table in own.tables.values() for name in table.get("recording", ())} == {LOST}
    page = page_of(own, "run")
    assert page.find(".//h1").text_content() == f"{LOST}, t"
    shown = tables_of(own, "run")
    (read,) = shown["files-read"]
    assert read["recording"] == f"R8 {LOST}"
    (cause,) = shown["causes"]
    assert (cause["finding"], cause["severity"]) == (Found.LOST_FRAMES.words, "warning")
    assert {f"run_{k}" for k in range(MANY)} & {*page.text_content().split()} <= {LOST}
