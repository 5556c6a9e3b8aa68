"""What a card says of its number in the last build."""

from dataclasses import replace
from pathlib import Path

import pytest

from ur5lib.report.page.document import Document, Number, Section, Verdict, Verdicts
from ur5lib.report.page.last_build import beside_last, last_summary
from ur5lib.report.page.summary import Summary
from ur5lib.tables import json_text

ERROR = Number("error", 6.9, "N", "along x", interval="95 %")
STOPS = Number("stop signs", 11, "")
SHARE = Number("share in the band", 93.0, "%")


def report(*cards: tuple[Number, ...]) -> Document:
    verdicts = [Verdict(f"card {k}", "good", "", numbers=own) for k, own in enumerate(cards)]
    return Document("", "", [Section("", [Verdicts(verdicts)])])


def summary(document: Document) -> Summary:
    """What results.json holds of a report."""
    (cards,) = document.blocks()
    empty = dict.fromkeys(("$schema", "study", "title", "commit"), "")
    known = {"simulated": [], "lists": [], "analysed": "2026-11-26"}
    made = Summary.model_validate(empty | known | {"verdicts": cards.verdicts})
    return Summary.model_validate_json(json_text(made.model_dump(by_alias=True)))


def told(document: Document) -> list[str]:
    (cards,) = document.blocks()
    return [number.before for card in cards.verdicts for number in card.numbers]


def test_the_first_number_is_beside_that_of_the_last_build() -> None:
    now = report((replace(ERROR, value=6.2), SHARE), (SHARE,), (SHARE,))
    last = summary(report((ERROR, replace(SHARE, value=80.0)), (SHARE,)))
    assert told(beside_last(now, last)) == ["6.90 N, 26 November 2026", "", "", ""]


@pytest.mark.parametrize("other", [{"place": "along y"}, {"unit": "Nm"}, {"interval": "range"}])
def test_nothing_is_said_of_another_quantity(other: dict[str, str]) -> None:
    now = report((replace(ERROR, value=6.2, **other),), (SHARE,))
    assert told(beside_last(now, summary(report((ERROR,), (SHARE,))))) == ["", ""]


def test_a_report_that_is_written_again_stays_as_it_is() -> None:
    now = report((replace(ERROR, value=6.2),), (STOPS,))
    written = beside_last(now, summary(report((ERROR,), (STOPS,))))
    assert beside_last(now, summary(written)) == written
    assert told(written) == ["6.90 N, 26 November 2026", ""]
    other = beside_last(report((replace(ERROR, value=6.2),), (SHARE,)), summary(written))
    assert told(other) == ["", ""], "another build, in which this number is the same"


@pytest.mark.parametrize("text", [None, "", "{}", '{"verdicts": 1', "\udcff"])
def test_without_a_last_build_nothing_is_said(tmp_path: Path, text: str | None) -> None:
    path = tmp_path / "results.json"
    if text is not None:
        path.write_text(text, errors="surrogateescape")
    now = report((ERROR,))
    assert beside_last(now, last_summary(path)) == now
