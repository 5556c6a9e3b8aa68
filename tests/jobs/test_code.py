"""The checksum of a step's code: of all modules that it uses, and of no other."""

import ast
import shutil
from pathlib import Path

import pytest

from tests.conftest import PROJECT
from ur5lib.jobs import code
from ur5lib.jobs.code import checksum_of_step, imported_modules, in_library, of_study, steps_with

MODULES = {
    "__init__": "",
    "force/__init__": "",
    "steps/__init__": "",
    "force/gate": "from ur5lib.force import noise\n",
    "force/noise": "import numpy\n",
    "force/prior": "from ur5lib.force.gate import (\n    Gate,\n    other,\n)\n",
    "force/types": "",
    "steps/estimate": "def estimate():\n    from ur5lib.force.prior import Prior  # slow\n",
    "steps/detect": "import ur5lib.force.gate\n",
    "steps/tabulate": "from typing import TYPE_CHECKING\n\nif TYPE_CHECKING:\n"
    "    from ur5lib.force.types import Type\n\n    from ur5lib.force.noise import Noise\n\n"
    "from ur5lib.force.types_of import Other\n",
}
USERS = {  # of each module, the steps that use it
    "force/noise": {"estimate", "detect"},
    "force/gate": {"estimate", "detect"},
    "force/prior": {"estimate"},
    "force/types": set(),
    "steps/detect": {"detect"},
    "steps/tabulate": {"tabulate"},
}
STEPS = ("estimate", "detect", "tabulate")


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A library of three steps."""
    folder = tmp_path / "ur5lib"
    for name, text in MODULES.items():
        path = folder / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(code, "PACKAGE", folder)
    forget()
    return folder


def forget() -> None:
    """A run reads each file of the library once."""
    code._content.cache_clear()
    imported_modules.cache_clear()


def checksums() -> dict[str, str]:
    forget()
    return {step: checksum_of_step(step) for step in STEPS}


@pytest.mark.parametrize("module", USERS)
def test_editing_a_module_changes_the_steps_that_use_it_and_no_other(
    package: Path, module: str
) -> None:
    """Directly, through others, or inside a function; not where it is imported for types alone."""
    before, path = checksums(), package / f"{module}.py"
    path.write_text(path.read_text() + "\nEDITED = True\n")
    after = checksums()
    assert {step for step in STEPS if after[step] != before[step]} == USERS[module]
    path.write_text(MODULES[module])
    assert checksums() == before


def test_a_file_that_a_step_reads_counts_too(package: Path) -> None:
    columns = package / "columns.yaml"
    columns.write_text("a: b")
    forget()
    before, without = checksum_of_step("detect", [columns]), checksum_of_step("detect")
    columns.write_text("a: c")
    forget()
    assert checksum_of_step("detect", [columns]) != before
    assert checksum_of_step("detect") == without


def test_it_is_the_same_wherever_the_library_is(
    package: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = checksums()
    elsewhere = shutil.copytree(package, tmp_path / "elsewhere" / "ur5lib")
    monkeypatch.setattr(code, "PACKAGE", elsewhere)
    assert checksums() == before


def test_files_are_the_library_s_or_the_study_s(package: Path) -> None:
    own, other = package / "robots" / "ur5.yaml", Path("raw/ur5.yaml")
    assert in_library([str(own), other]) == [own]
    assert of_study([str(own), other]) == ["raw/ur5.yaml"]


def of_ast(path: Path) -> set[str]:
    """The names that a module imports, but those that are for types alone."""
    names, nodes = set[str](), [*ast.parse(path.read_text()).body]
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.Import):
            names |= {own.name for own in node.names}
        if isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}{own}" for own in ("", *(f".{a.name}" for a in node.names))}
        nodes += ast.iter_child_nodes(node)
    return names


def test_no_import_of_the_library_is_missed() -> None:
    """A result would stay when its code changes. The text tells all that Python's grammar does."""
    files = {}
    for path in sorted((PROJECT / "ur5lib").rglob("*.py")):
        name = ".".join(path.relative_to(PROJECT).with_suffix("").parts)
        files[name.removesuffix(".__init__")] = path
    for path in files.values():
        assert {files[name] for name in of_ast(path) & files.keys()} <= imported_modules(path), path


def test_the_report_s_loops_over_folders_are_followed() -> None:
    """A view or a topic's finding that is edited makes the report anew."""
    report = (PROJECT / "ur5lib" / "report").rglob("*.py")
    looping = {path for path in report if "modules_of_topics(" in path.read_text()}
    assert looping == {PROJECT / "ur5lib" / path for path in code.LOOPS}
    for pattern in ("report/views/*.py", "topics/*/report.py", "topics/*/found.py"):
        for path in (PROJECT / "ur5lib").glob(pattern):
            assert {"write_report", "write_run"} <= {*steps_with(path)}, path


def test_the_steps_with_a_file_are_those_whose_checksum_it_changes() -> None:
    gate = steps_with(PROJECT / "ur5lib" / "force" / "gate.py")
    assert {"estimate_forces", "judge_contacts"} <= {*gate}
    assert "fit_friction" not in gate
