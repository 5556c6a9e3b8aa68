"""`ur5 excite` with names that are nearly right, or that no file can have."""

import re
from pathlib import Path

import pytest

from tests.commands import Command
from tests.library.test_command_line import LONG, told


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("excite --robot UR-5ee --write x", "ur5e"),
        ("excite --robot ur5 --write x --question modle", "model"),
    ],
)
def test_a_name_that_is_nearly_right_is_named(words: str, meant: str) -> None:
    assert re.search(rf"[Dd]id you mean .?{re.escape(meant)}['`]", told(*words.split()))


def test_a_name_that_no_file_can_have_is_told_in_a_sentence(
    run_ur5: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = run_ur5("excite", "--robot", "ur5", "--write", LONG)
    assert answer.status == 1
    assert answer.err.startswith(f"ur5: {LONG}")
    assert answer.err.count("\n") == 1
