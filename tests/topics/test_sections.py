"""Topics' sections: each page is typeset without any one of them, and the others stay."""

import re

import pytest

from tests.made_study import finding, predicted, push, study, touched
from tests.typeset_page import page_of, plain
from ur5lib.report.page import handed
from ur5lib.report.results import Results

TOPICS = [path.parent.name for path in handed.TOPICS]


@pytest.fixture(scope="module")
def results() -> Results:
    one = {"study": "before", "name": "a", "before": "1", "after": "2", "topic": "force"}
    return study(
        quality=[finding("warning")],
        force_mae=touched(2.9),
        current_rmse=predicted(0.2),
        pushes=[push("slow", axis, 10.0) for axis in "xyz"],
        changes=[one | {"differs": "yes", "changed": "yes"}],
    )


def texts(results: Results, page: str) -> list[str]:
    """The text of each section without numbers of tables and figures, but for the first screen."""
    sections = page_of(results, page).xpath("//section[@id]")
    return [re.sub(r"(Table|Figure) \d+", r"\1", plain(own.text_content())) for own in sections]


@pytest.mark.parametrize("topic", TOPICS)
def test_the_page_is_typeset_without_a_topic(
    topic: str, results: Results, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whose folder was deleted."""
    whole = {page: texts(results, page) for page in ("report", "details")}
    left = [path for path in handed.TOPICS if path.parent.name != topic]
    words = [path for path in handed.WORDS if path.parent.name != topic]
    monkeypatch.setattr(handed, "TOPICS", left)
    monkeypatch.setattr(handed, "WORDS", words)
    for page, own in whole.items():
        kept = texts(results, page)
        assert len(own) - 1 <= len(kept) <= len(own)
        assert [text for text in kept if text not in own] == []
