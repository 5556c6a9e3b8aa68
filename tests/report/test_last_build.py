"""What a card says of its numbers in the last build."""

from pathlib import Path

import pytest

from tests.made_study import judged_anew, predicted, study, touched
from ur5lib.report.page.document import Cards, Document, Heading, Section
from ur5lib.report.page.last_build import beside_last, last_summary
from ur5lib.report.page.summary import Summary, summary
from ur5lib.report.results import Results
from ur5lib.report.views.cards import cards
from ur5lib.tables import json_text


def built(mae: float, rmse: float = 0.2) -> Results:
    """A study whose force errs by so much."""
    made = study(force_mae=touched(mae), current_rmse=predicted(rmse))
    return judged_anew(made, study={**made.study, "study": "s", "title": "t"})


def report(results: Results) -> Document:
    return Document("", "", [Section("", [Heading(""), Cards(cards(results))])])


def summary_of(document: Document, results: Results) -> Summary:
    """What results.json holds of a report."""
    made = summary(document, results) | {"analysed": "2026-11-26"}
    return Summary.model_validate_json(json_text(made))


def told(document: Document) -> list[str]:
    (block,) = (one for one in document.blocks() if isinstance(one, Cards))
    return [one.before for card in block.cards for one in card.numbers if one.before]


def test_a_number_is_shown_with_that_of_the_last_build() -> None:
    before, now = built(2.9), built(2.2)
    last = summary_of(report(before), before)
    assert told(beside_last(report(now), last))[0] == "2.90 N, 26 November 2026"


def test_nothing_is_said_of_another_quantity() -> None:
    before, now = built(2.9), study(current_rmse=predicted(0.2))
    assert told(beside_last(report(now), summary_of(report(before), before))) == []
    elsewhere = study(force_mae=touched(2.2, "seen"))
    last = summary_of(report(before), before)
    assert "2.90 N, 26 November 2026" not in told(beside_last(report(elsewhere), last))


def test_a_report_that_is_written_again_stays_as_it_is() -> None:
    before, now = built(2.9), built(2.2)
    written = beside_last(report(now), summary_of(report(before), before))
    assert beside_last(report(now), summary_of(written, now)) == written
    other = built(2.2, 0.3)
    again = beside_last(report(other), summary_of(written, now))
    assert "2.90 N, 26 November 2026" not in told(again), "another build, in which this is the same"


@pytest.mark.parametrize("text", [None, "", "{}", '{"verdicts": 1', "\udcff"])
def test_without_a_last_build_nothing_is_said(tmp_path: Path, text: str | None) -> None:
    path = tmp_path / "results.json"
    if text is not None:
        path.write_text(text, errors="surrogateescape")
    now = report(built(2.9))
    assert beside_last(now, last_summary(path)) == now
