"""The summary of a study, and what its numbers were in the last build."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from tests.made_study import finding, judged_anew, predicted, study, touched
from ur5lib.records.codes import Found
from ur5lib.report.found import findings, left_out
from ur5lib.report.next_steps import next_steps
from ur5lib.report.results import Results
from ur5lib.report.summary import (
    Summary,
    last_summary,
    page_data,
    summary,
    summary_schema,
    verdict_rows,
)
from ur5lib.tables import json_text

DAY = "2026-11-26"


def named(made: Results) -> Results:
    return judged_anew(made, study={**made.study, "study": "s", "title": "t"})


def built(mae: float, rmse: float = 0.2) -> Results:
    """A study whose force errs by so much."""
    return named(study(force_mae=touched(mae), current_rmse=predicted(rmse)))


def summary_of(results: Results, last: Summary | None = None, day: str = DAY) -> Summary:
    """What results.json holds."""
    return Summary.model_validate_json(
        json_text(summary(results, page_data(results, last)) | {"analysed": day})
    )


def before(results: Results, last: Summary | None) -> list[dict[str, Any]]:
    return [row["before"] for row in verdict_rows(results, last) if row["before"]]


def test_a_summary_has_the_rows_of_the_verdicts_next_steps_and_findings() -> None:
    made = named(study(quality=[finding("stop", Found.CONTRADICTION)], force_mae=touched(2.9)))
    told = json.loads(json_text(summary(made, page_data(made))))
    jsonschema.validate(told, summary_schema())
    assert told["$schema"] == "results.schema.json"
    assert told.keys() == {
        *("$schema", "study", "title", "simulated", "commit", "analysed"),
        *("verdicts", "next", "findings", "left_out"),
    }
    assert told["next"] == [{**vars(step)} for step in next_steps(made)]
    assert (told["findings"], told["left_out"]) == (findings(made), left_out(made))
    rows = made.tables["verdicts"]
    assert [row["question"] for row in told["verdicts"]] == [*rows["question"]]
    assert [row["value"] for row in told["verdicts"]] == [
        row["value"] for row in verdict_rows(made)
    ]


def test_rows_have_every_column_and_none_for_an_empty_cell() -> None:
    rows = verdict_rows(built(2.9))
    columns = {*built(2.9).tables["verdicts"], "before"}
    assert all(row.keys() == columns for row in rows)
    assert not any(
        isinstance(value, float) and value != value for row in rows for value in row.values()
    )
    assert {type(row["rank"]) for row in rows} == {int}
    json.dumps(rows, allow_nan=False)
    empty = {name: own for name, own in built(2.9).tables.items() if name != "verdicts"}
    assert verdict_rows(replace(built(2.9), tables=empty)) == []


def test_a_number_is_shown_with_that_of_the_last_build() -> None:
    first, *_ = before(built(2.2), summary_of(built(2.9)))
    assert first == {"value": 2.9, "count": None, "of": None, "date": DAY}
    (decides, *_) = [
        row for row in verdict_rows(built(2.2), summary_of(built(2.9))) if row["before"]
    ]
    assert (decides["question"], decides["value"]) == ("force", 2.2)


def test_three_digits_make_another_number() -> None:
    last = summary_of(built(2.9))
    assert before(built(2.9004), last) == []
    assert before(built(2.91), last)[0]["value"] == 2.9


def test_counts_are_compared_too() -> None:
    noted = [finding("note", code) for code in (Found.JITTER, Found.SPLIT, Found.CONTACT)]
    few, many = (named(study(quality=noted[:count])) for count in (2, 3))
    notes = next(row for row in verdict_rows(many, summary_of(few)) if row["quantity"] == "notes")
    assert notes["count"] == 3
    assert notes["before"] == {"value": None, "count": 2, "of": None, "date": DAY}


def test_nothing_is_said_of_another_quantity() -> None:
    last = summary_of(built(2.9))
    assert before(named(study(current_rmse=predicted(0.2))), last) == []
    elsewhere = before(named(study(force_mae=touched(2.2, "seen"))), last)
    assert [one["value"] for one in elsewhere].count(2.9) == 1, "the mean of all, not a worst axis"


def test_a_report_that_is_written_again_stays_as_it_is() -> None:
    now = built(2.2)
    written = summary_of(now, summary_of(built(2.9)), "2026-11-27")
    assert verdict_rows(now, written) == verdict_rows(now, summary_of(built(2.9)))
    assert summary_of(now, written, "2026-11-27") == written
    again = before(built(2.2, 0.3), written)
    assert 2.9 not in [one["value"] for one in again], "another build, in which this is the same"
    assert {one["date"] for one in again} == {"2026-11-27"}


OLD = {"$schema": "results.schema.json", "study": "s", "title": "t", "simulated": [], "commit": "c"}
OLD_VERDICT = {"question": "force", "value": 2.0, "before": "6.9 N, 26 November 2026"}


@pytest.mark.parametrize(
    "text",
    [
        *(None, "", "{}", '{"verdicts": 1', "\udcff"),
        json.dumps(OLD | {"verdicts": [OLD_VERDICT], "lists": []}),
    ],
)
def test_without_a_last_build_nothing_is_said(tmp_path: Path, text: str | None) -> None:
    """Nor of one by another version, whose summary has other keys."""
    path = tmp_path / "results.json"
    if text is not None:
        path.write_text(text, errors="surrogateescape")
    assert last_summary(path) is None
    assert before(built(2.9), last_summary(path)) == []


def test_a_summary_that_was_written_is_read_as_the_last_build(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    path.write_text(json_text(summary(built(2.9), page_data(built(2.9)))))
    assert before(built(2.2), last_summary(path))[0]["value"] == 2.9
