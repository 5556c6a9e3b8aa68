"""The words of docstrings: plain ones, as often as other libraries use them."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import PROJECT

PACKAGES = ("ur5lib", "ur5lab", "ur5rivals")
# By forms of a word: how often it may occur in 10,000 words of docstrings, and by which plainer
# words it is replaced. Three times scipy's rate, or 0.04.
LIMITS = {
    "beside": (0.04, "next to, compared with, in addition to"),
    "tell tells told telling": (0.33, "show, determine, distinguish, say"),
    "hold holds held holding": (4.7, "contain, keep, carry, apply"),
    "hardly": (0.04, "almost not, little"),
    "stand stands standing": (0.25, "is, replaces"),
    "whose": (5.8, "with, of which, a sentence of its own"),
    "known": (7.3, "given, described, documented"),
}
CODE = re.compile(r"`[^`]+`|\btest\s+stands?\b")  # names are no prose, and a test stand is a thing


def docstrings(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield CODE.sub("", ast.get_docstring(node) or "")


@pytest.fixture(scope="module")
def words() -> list[str]:
    paths = [path for name in PACKAGES for path in (PROJECT / name).rglob("*.py")]
    text = " ".join(one for path in paths for one in docstrings(path))
    return re.findall(r"\w+", text.lower())


@pytest.mark.parametrize("forms", LIMITS)
def test_docstrings_use_plain_words(words: list[str], forms: str) -> None:
    """In the docstrings of scipy 1.17.1, 10,000 words have beside 0.01, tell 0.11, hold 1.6, hardly
    0.01, stand 0.08, whose 1.9 and known 2.4 times.
    """
    limit, instead = LIMITS[forms]
    found = sum(words.count(form) for form in forms.split())
    assert 1e4 * found / len(words) <= limit, f"write instead: {instead}"
