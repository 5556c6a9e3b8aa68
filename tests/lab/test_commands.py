"""`ur5 excite` with names that are nearly right, or that no file can have."""

import re
from pathlib import Path

import pytest

from tests.command import Command
from tests.commands.test_command_line import LONG, literals, told
from ur5lab.excitation.objective import QUESTIONS


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("excite --robot UR-5ee --output x", "ur5e"),
        ("excite --robot ur5 --output x --question modle", "model"),
    ],
)
def test_a_name_that_is_nearly_right_is_named(words: str, meant: str) -> None:
    assert re.search(rf"[Dd]id you mean .?{re.escape(meant)}['`]", told(*words.split()))


def test_questions_are_those_that_there_are() -> None:
    """Help and completion list them."""
    assert literals("excite", "question") == {*QUESTIONS}


@pytest.mark.parametrize(
    ("words", "status", "answer"),
    [
        ("excite --robot ur5 --write out", 2, "ur5 excite --robot ur5 --output out"),
        ("excite --robot ur5 -o x --question modle", 1, "did you mean `model`"),
        ("record mine.yaml a --role contcat", 1, "did you mean `contact`"),
    ],
)
def test_a_wrong_call_is_answered_with_the_right_one(
    words: str, status: int, answer: str, run_ur5: Command
) -> None:
    told = run_ur5(*words.split())
    assert told.status == status
    assert answer in told.err


def test_a_name_that_no_file_can_have_is_told_in_a_sentence(
    run_ur5: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = run_ur5("excite", "--robot", "ur5", "--output", LONG)
    assert answer.status == 1
    assert answer.err.startswith(f"ur5: {LONG}")
    assert answer.err.count("\n") == 1
