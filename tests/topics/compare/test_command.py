"""The command `ur5 compare`, called wrongly."""

from pathlib import Path

import pytest

from tests.command import Command

LONG = "a" * 300
WRONG_CALLS = [  # words, exit status, and what the answer names
    ("compare a b --junit c.xml", 2, "ur5 compare a b --output c.xml"),
    ("compare results/a", 2, "as in: ur5 compare monday tuesday"),
    ("compare . . --fail-on forse", 1, "did you mean `force`"),
    (f"compare {LONG} .", 1, f"ur5: {LONG}"),
    ("compare . .", 1, "tables/quality.csv is damaged"),
]


@pytest.mark.parametrize(("words", "status", "answer"), WRONG_CALLS)
def test_a_wrong_call_is_answered_in_a_sentence(
    words: str,
    status: int,
    answer: str,
    run_ur5: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "quality.csv").write_text("PAR1")
    told = run_ur5(*words.split())
    assert told.status == status
    assert answer in told.err
    assert told.err.count("\n") == 1
