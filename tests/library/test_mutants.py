"""The mutation run itself, on a toy."""

import subprocess
import sys
from pathlib import Path

import yaml

from tests.conftest import PROJECT

TOY = """\
def larger(a: float, b: float) -> float:
    return a if a > b else b


def unseen(a: float) -> float:
    return a + 1.0
"""
TEST = """\
from toy import larger, unseen

def test_larger() -> None:
    assert larger(1, 2) == larger(2, 1) == larger(2, 2) == 2

def test_unseen() -> None:
    unseen(1)
"""


def mutated(folder: Path) -> str:
    command = [sys.executable, PROJECT / "tests" / "mutants.py", "--count", "0"]
    done = subprocess.run(
        [*command, "--module", "toy.py", "--tests", "test_toy.py"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_what_a_test_notices_is_killed_and_what_none_does_survives(tmp_path: Path) -> None:
    (tmp_path / "toy.py").write_text(TOY)
    (tmp_path / "test_toy.py").write_text(TEST)
    told = mutated(tmp_path)
    assert "killed     toy.py:2  a if a > b else b -> a if not a > b else b  [test_toy.py::" in told
    assert "survived   toy.py:2  a > b -> a >= b" in told
    assert "survived   toy.py:6  a + 1.0 -> a - 1.0  [2 tests]" in told
    assert "seed 0: 1 killed, 3 survived, 0 equivalent" in told
    assert "25% killed, 95 % interval 5% to 70%" in told
    assert (tmp_path / "toy.py").read_text() == TOY
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "equivalent_mutants.yaml").write_text(
        "- {line: return a if a > b else b, becomes: return a if (a >= b) else b, why: equals}\n"
    )
    assert "seed 0: 1 killed, 2 survived, 1 equivalent" in mutated(tmp_path)


def test_equivalent_mutants_are_of_lines_that_there_are() -> None:
    listed = yaml.safe_load((PROJECT / "tests" / "equivalent_mutants.yaml").read_text())
    lines = {
        line.strip()
        for path in (PROJECT / "ur5lib").rglob("*.py")
        for line in path.read_text().splitlines()
    }
    assert [one["line"] for one in listed if one["line"] not in lines] == []
