"""The ten scripts of docs/api.md are short, and pass the strictest check of types."""

import ast
import os
import re
import subprocess
import sys
from itertools import product
from pathlib import Path

import pytest

from benchmarks.choice import CHOICES, HEAD, terms_in_words
from benchmarks.harness.markdown import cells_of
from tests.conftest import PROJECT
from tests.examples import examples
from tests.scripts import SCRIPTS

LINES = 15


def scripts() -> list[str]:
    found = [one.text for one in examples(PROJECT / "docs" / "api.md") if one.kind == "python"]
    return [text for text in found if text.startswith(tuple(SCRIPTS))]


def test_ten_scripts_are_short() -> None:
    """tests/house/test_examples.py runs them."""
    assert len(scripts()) == len(SCRIPTS) == 10
    assert max(len(text.strip().splitlines()) for text in scripts()) <= LINES


def test_the_search_of_the_page_is_that_of_the_benchmark() -> None:
    page = (PROJECT / "docs" / "api.md").read_text()
    [choices] = re.findall(r"choices = (.*)", page)
    assert ast.literal_eval(choices) == CHOICES
    [table] = re.findall(rf"(?m)^\| {re.escape(HEAD[0])} \|.*\n(?:\|.*\n)+", page)
    shown = [row[:2] for row in cells_of(table)[1:]]
    each = [[f"{c:g}", terms_in_words(own)] for c, own in product(*CHOICES.values())]
    assert shown == each, "`python -m benchmarks.choice --page` writes it"


@pytest.mark.slow
def test_the_scripts_pass_the_strictest_check(tmp_path: Path) -> None:
    files = [tmp_path / f"script{k}.py" for k in range(10)]
    for file, text in zip(files, scripts(), strict=True):
        file.write_text(text)
    environment = os.environ | {"MYPYPATH": str(PROJECT), "MYPY_CACHE_DIR": str(tmp_path)}
    options = ["--strict", "--follow-imports=silent", "--ignore-missing-imports"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, *files],
        cwd=tmp_path, env=environment, text=True, capture_output=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
