"""Commands of packages beside the library: one that was deleted is not there, others are.

And the packages of an extra, in a clone as in a wheel.
"""

import sys
from pathlib import Path

import pytest

from ur5lib.workspace import beside
from ur5lib.workspace.beside import commands_beside, entry_points, extra

PROJECT = """\
[project.entry-points."ur5lib.commands"]
greet = "ur5greeting.commands:greet"
brew = "ur5brewing.commands:brew"
"""
COMMANDS = 'PANEL = "Lab"\n\ndef greet():\n    import ur5brewing\n'


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clone with one of two packages."""
    (tmp_path / "pyproject.toml").write_text(PROJECT)
    folder = tmp_path / "ur5greeting"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "commands.py").write_text(COMMANDS)
    monkeypatch.setattr(beside, "WORKFLOW", tmp_path)
    monkeypatch.setattr(beside, "PACKAGE", tmp_path / "ur5lib")
    monkeypatch.setattr(beside, "IN_CLONE", True)
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("ur5greeting", "ur5greeting.commands"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return folder


def test_a_package_that_is_there_has_its_commands_and_one_that_is_not_none(package: Path) -> None:
    assert {*entry_points()} == {"greet", "brew"}
    [command] = commands_beside()
    assert (command.name, command.panel) == ("greet", "Lab")
    with pytest.raises(ModuleNotFoundError, match="ur5brewing"):
        command.run()


def test_what_a_package_lacks_is_told(package: Path) -> None:
    """It is there, so that its command is missed."""
    (package / "commands.py").write_text("import no_such_package\n" + COMMANDS)
    with pytest.raises(ModuleNotFoundError, match="no_such_package"):
        list(commands_beside())


def test_byte_code_that_git_left_behind_is_no_package(package: Path) -> None:
    for file in ("__init__.py", "commands.py"):
        (package / file).unlink()
    assert list(commands_beside()) == []


def test_the_package_of_another_clone_is_none_of_this_one(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where an editable installation of that one can be imported."""
    monkeypatch.setattr(beside, "PACKAGE", package / "ur5lib")
    assert list(commands_beside()) == []


@pytest.mark.parametrize("name", ["record", "slurm"])
def test_a_wheel_names_the_packages_of_an_extra_as_the_clone_does(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stated = extra(name)
    assert stated
    monkeypatch.setattr(beside, "IN_CLONE", False)
    assert extra(name) == stated
