"""The tests that a change can reach are found by names, and by the files that tests name."""

import subprocess

import pytest

from tests.changed import reached
from tests.reach import Project

FILES = {
    "ur5lib/__init__.py": "",
    "ur5lib/gate.py": """\
LIMIT = 2


def opened():
    '''Whether.'''
    return LIMIT


class Gate:
    def width(self):
        return LIMIT

    def height(self):
        return 1
""",
    "ur5lib/table.py": """\
def register(f):
    return f


@register
def kind():
    return 1


def other():
    return 'sizes.yaml'
""",
    "ur5lib/sizes.yaml": "a: 1\n",
    "docs/page.md": "A page.\n",
    "tests/__init__.py": "",
    "tests/conftest.py": """\
import pytest


@pytest.fixture
def wall():
    from ur5lib.gate import Gate
    return Gate()
""",
    "tests/test_gate.py": """\
from ur5lib import gate


def test_opened():
    assert gate.opened()


def test_width(wall):
    assert wall.width()


def test_height(wall):
    assert wall.height()
""",
    "tests/test_table.py": """\
from ur5lib.table import other


def test_other():
    assert other()


def test_page():
    assert open('docs/page.md')


def test_alone():
    assert 1
""",
}
EVERY = {"opened", "width", "height", "other", "page", "alone"}
CHANGES = {
    "a constant": ("ur5lib/gate.py", "LIMIT = 2", "LIMIT = 3", {"opened", "width"}),
    "a function": ("ur5lib/gate.py", "return LIMIT", "return 0", {"opened"}),
    "a method": ("ur5lib/gate.py", "return 1", "return 4", {"height"}),
    "words": ("ur5lib/gate.py", "'''Whether.'''", "'''If.'''  # or not", set()),
    "a fixture": ("tests/conftest.py", "Gate()", "Gate() or 1", {"width", "height"}),
    "what is registered": ("ur5lib/table.py", "return 1", "return 2", {"other"}),
    "a file of a package": ("ur5lib/sizes.yaml", "1", "2", {"other"}),
    "a file that a test names": ("docs/page.md", "A", "The", {"page"}),
    "a test": ("tests/test_table.py", "assert 1", "assert 2", {"alone"}),
    "what tests are built of": ("pyproject.toml", "", "[tool]", EVERY),
}  # fmt: skip


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    folder = tmp_path_factory.mktemp("project")
    for name, text in FILES.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    subprocess.run(["git", "init", "--quiet"], cwd=folder, check=True)
    return Project(folder)


@pytest.mark.parametrize(("file", "old", "new", "expected"), CHANGES.values(), ids=CHANGES)
def test_a_change_reaches_the_tests_that_use_it(
    project: Project, file: str, old: str, new: str, expected: set[str]
) -> None:
    before = FILES.get(file, "")
    after = before.replace(old, new, 1) if old else new
    assert after != before
    found = reached(project, {file: (before, after)})
    assert {name.partition("::test_")[2] for name in found} == expected


def test_a_file_that_leaves_reaches_those_that_used_it(project: Project) -> None:
    found = reached(project, {"ur5lib/gate.py": (FILES["ur5lib/gate.py"], None)})
    assert len(found) == 3
