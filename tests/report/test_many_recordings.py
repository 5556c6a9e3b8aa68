"""A report of many recordings, and the page of one of them on demand."""

from dataclasses import replace

import pandas as pd
import pytest

from tests.made_tables import empty
from ur5lib.errors import InputError
from ur5lib.judging.recordings import judge_recordings
from ur5lib.report.page.compose import compose
from ur5lib.report.page.document import (
    MOST_ROWS,
    DeclaredSection,
    Document,
    Picture,
    TableBlock,
    contents,
)
from ur5lib.report.results import Results
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
        "current_rmse": {"model": "fitted", "joint": 1, "rmse_lowpassed": 0.1, "r2": 0.0},
        "detection": {"estimate": "Fmap", "alarms_per_min": 2.0},
    }
    tables = {name: empty(name).astype(object) for name in columns()} | {
        name: used.assign(**row).reindex(columns=empty(name).columns)
        for name, row in filled.items()
    }
    lost = {"device": "robot", "finding": "lost frames", "severity": "warning", "detail": "lost"}
    tables["quality"] = pd.DataFrame([{"recording": LOST, "count": 50, "place": ""} | lost])
    tables["payload"].loc[used["recording"] == LOADED, "taken"] = "yes"
    study = {"study": "s", "title": "t", "recordings": entries}
    return Results(study, tables)


SHOWN = [
    DeclaredSection.model_validate(part)
    for part in (
        {"title": "First", "blocks": [{"sentences": "recordings.pages"}]},
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


def test_many_recordings_have_no_row_each(document: Document) -> None:
    assert [*shown_tables(document)] == ["current_rmse.b"]  # its rows are joints
    assert [*shown_tables(compose(SHOWN, made(MOST_ROWS)))] == ["recordings.a", "current_rmse.b"]


def test_no_cell_leads_to_a_page_that_was_not_made(document: Document) -> None:
    links = {
        cell.link for table in shown_tables(document).values() for row in table.rows for cell in row
    }
    assert links == {""}


def shown_tables(document: Document) -> dict[str, TableBlock]:
    return {block.label: block for block in document.blocks() if isinstance(block, TableBlock)}


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
    own = made().of_run(LOST)
    assert own.roles() == {LOST: "validate"}
    assert {name for table in own.tables.values() for name in table.get("recording", ())} == {LOST}
    page = compose(contents().run, own)
    assert page.title == f"{LOST}, t"
    shown = [block for block in page.blocks() if isinstance(block, TableBlock | Picture)]
    assert {"recordings", "quality.causes"} <= {block.label for block in shown}
