"""The checksum of a step's code: of all modules that it uses, and of no other."""

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import PROJECT
from ur5lib.jobs import code, syntax
from ur5lib.jobs.code import (
    all_steps,
    checksum_of_step,
    imported_modules,
    in_library,
    modules_of_step,
    steps_with,
)

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
    monkeypatch.chdir(tmp_path)  # where what is read is kept
    forget()
    return folder


def forget() -> None:
    """As another process, which reads each file of the library once."""
    syntax.FOUND.clear()
    for kept in (syntax.syntax, syntax._before, code._counted, imported_modules):
        kept.cache_clear()


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


def test_files_of_the_library_count_as_code(package: Path) -> None:
    own, other = package / "robots" / "ur5.yaml", Path("raw/ur5.yaml")
    assert in_library([str(own), other]) == [own]


BEFORE = '''\
"""Of noise."""

import numpy

@first(1)
class Noise:
    """Of a joint [N m]."""

    wide: float  # wider
    def of(self, count: int = 2, *, sign=None) -> float:
        """How much."""
        return count + self.wide
'''
SAME = {
    "a comment": ("# wider", "# narrower"),
    "a comment's line": ("import numpy", "# of arrays\nimport numpy"),
    "a method's docstring": ("How much.", "How much,\n\n        in N m."),
    "no docstring": ('"""How much."""', ""),
    "a module's docstring": ("Of noise.", "Of a joint's noise."),
    "blank lines": ("import numpy", "\n\nimport numpy"),
    "line breaks": ("count + self.wide", "(\n            count + self.wide\n        )"),
    "quotes": ('"""Of a joint [N m]."""', "'Of a joint [N m].'"),
}
OTHER = {
    "a class's docstring": ("Of a joint", "Of an arm"),
    "a default": ("= 2", "= 3"),
    "a kind of number": ("= 2", "= 2.0"),
    "no default": ("sign=None", "sign"),
    "a decorator": ("@first(1)", "@first(2)"),
    "an operator": ("count +", "count -"),
    "an annotation": ("wide: float", "wide: int"),
    "a text": ("import numpy", 'import numpy\nTEXT = "# none"'),
    "an indent": ("    wide: float", "wide: float"),
    "no syntax": ("return", "return return"),
}


def checksum_with(package: Path, old: str, new: str) -> str:
    """The checksum of a step with a module in which some text is another."""
    assert BEFORE.count(old) == 1
    (package / "force" / "noise.py").write_text(BEFORE.replace(old, new))
    return checksums()["detect"]


@pytest.mark.parametrize(("old", "new"), SAME.values(), ids=SAME)
def test_words_about_the_code_change_no_checksum(package: Path, old: str, new: str) -> None:
    assert checksum_with(package, old, new) == checksum_with(package, old, old)


def test_all_else_changes_it(package: Path) -> None:
    """What a class says is shown, and a file without syntax counts with all its text."""
    found = [checksum_with(package, old, new) for old, new in OTHER.values()]
    assert len({*found, checksum_with(package, "= 2", "= 2")}) == len(OTHER) + 1


def test_no_step_reads_words_that_do_not_count() -> None:
    """Those of functions and modules, comments and numbers of lines."""
    words = re.compile(r"__doc__|\bgetdoc|getsource|linecache|f_lineno")
    steps = {path for step in all_steps() for path in modules_of_step(step)}
    assert [path for path in steps if words.search(path.read_text())] == []


def test_a_file_is_parsed_once_for_all_processes(
    package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Until its content, or what counts of it, is another."""
    before, own = checksums(), package / "force" / "noise.py"
    syntax.keep_for_the_next_process()
    asked, parse = list[str](), ast.parse

    def noted(text: bytes) -> ast.Module:
        asked.append(text.decode())
        return parse(text)

    monkeypatch.setattr(syntax.ast, "parse", noted)
    assert checksums() == before
    assert asked == []
    own.write_text("import scipy\n")
    assert checksums()["detect"] != before["detect"]
    assert asked == [own.read_text()]
    monkeypatch.setattr(syntax, "OWN", b"a later version")
    checksums()
    assert len(asked) > len(before)


@pytest.mark.parametrize("damage", ["", "{", None])
def test_what_was_kept_may_be_lost(package: Path, damage: str | None) -> None:
    before = checksums()
    syntax.KEPT.parent.mkdir()
    if damage is None:
        syntax.KEPT.mkdir()  # it cannot be written, either
    else:
        syntax.KEPT.write_text(damage)
    assert checksums() == before
    syntax.keep_for_the_next_process()
    assert [*syntax.KEPT.parent.iterdir()] == [syntax.KEPT]


LOADED = """\
import sys
import ur5lib.steps.estimate_forces
print(*(m.__file__ for name, m in sys.modules.items() if name.split(".")[0] == "ur5lib"), sep="\\n")
"""


def test_what_python_loads_for_a_step_is_a_part_of_it() -> None:
    """A result would stay when its code changes. The first modules of folders hold nothing."""
    printed = subprocess.check_output([sys.executable, "-c", LOADED], cwd=PROJECT, text=True)
    loaded = {*map(Path, printed.split())}
    known = {*modules_of_step("estimate_forces")}
    assert len(loaded & known) > 40
    for path in loaded - known - {PROJECT / "ur5lib" / "__init__.py"}:
        assert [type(node) for node in ast.parse(path.read_text()).body] in ([], [ast.Expr]), path


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
