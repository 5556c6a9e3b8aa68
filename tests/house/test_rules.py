"""What a step is given is what its rule declares: a result follows from what it depends on."""

import ast
import json
import re
import subprocess
import sys
from collections.abc import Callable
from inspect import Parameter, getsource, signature
from pathlib import Path
from textwrap import dedent
from types import FunctionType
from typing import Any, get_args, get_origin, get_type_hints

import pytest

from tests.conftest import PROJECT
from tests.synthetic import write_recording
from ur5lib.jobs.code import all_steps, imported_modules
from ur5lib.jobs.declared import every
from ur5lib.jobs.files import opened
from ur5lib.jobs.job import load_step
from ur5lib.records.opened import Opened
from ur5lib.report.figures.house_style import Drawing
from ur5lib.steps.make_tables import OF_ARMS, OF_MOTION, OF_RECORDINGS

EVERYTHING = """\
study: everything
title: A study whose rules declare all that they can
reference: workflow/studies/thesis_reference.yaml
hosts: {computer: [imu]}
recordings:
  - name: simulated
    robot: ur5
    format: thesis-csv
    role: fit
    simulate: {trajectory: {kind: movej, way_points: FOLDER/way_points.txt}, imu: {}}
  - {name: real, robot: ur5, format: thesis-csv, folder: FOLDER/real, role: contact}
"""
LIST_RULES = """\
import json, sys
from pathlib import Path
from snakemake.api import SnakemakeApi
from snakemake.settings.types import ConfigSettings, ResourceSettings

study = ConfigSettings(configfiles=[Path(sys.argv[1])])
with SnakemakeApi() as api:
    workflow = api.workflow(ResourceSettings(cores=1), study, snakefile=Path("Snakefile"))._workflow
    for rule in workflow.rules:
        if "code" in rule.params.keys():
            print(json.dumps([rule.name, {kind: [*getattr(rule, kind).keys()] for kind in KINDS}]))
"""
KINDS = ("input", "output", "params")
Names = dict[str, set[str]]
"""The names of each kind: input, output, params."""
STEPS = {*all_steps()} - {"sensor_reading"}  # no step's name
FILES = *PROJECT.glob("workflow/rules/*.smk"), *PROJECT.glob("ur5lib/topics/*/rules.smk")
TEXT = "".join(path.read_text() for path in FILES)
STATED = re.findall(r"^ *rule (\w+):", TEXT, re.MULTILINE)  # with a text of their own
PARTS = {Path(file).stem for step in every() for file in step.writes.values()}  # of tables
RULES = [rule for rule in STATED if f'code=code("{rule}' in TEXT]
RULES += ["calibrate_imu_without_each", "simulate_recording_simulated"]
RULES += [step.name for step in every()]


def step_of(rule: str) -> str:
    """The step that a rule runs: on other recordings, it has a name more."""
    return max((name for name in STEPS if rule.startswith(name)), key=len)


@pytest.fixture(scope="module")
def declared(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Names]:
    """What each rule of a study with everything declares, all names but `code`."""
    folder = tmp_path_factory.mktemp("everything")
    write_recording(folder / "real", seconds=2, seed=0)
    study = folder / "study.yaml"
    study.write_text(EVERYTHING.replace("FOLDER", str(folder)))
    (folder / "way_points.txt").write_text("movej([0, -1, 1, 0, 0, 0])\n" * 2)
    program = [sys.executable, "-c", LIST_RULES.replace("KINDS", str(KINDS)), str(study)]
    done = subprocess.run(program, cwd=PROJECT, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    return {
        rule: {kind: {*names} - {"code"} for kind, names in kinds.items()}
        for rule, kinds in map(json.loads, done.stdout.splitlines())
    }


def parameters(step: str) -> dict[str, bool]:
    """What a step takes, and whether it must be given.

    Of a record of files, what it uses. What could not be read is no file: whoever runs the step
    knows it.
    """
    function = load_step(step)
    needed = dict[str, bool]()
    for name, own in signature(function).parameters.items():
        if (record := opened(get_type_hints(function)[name])) is not None:
            needed |= {field: not hasattr(record, field) for field in used(function, name, record)}
        elif name != "unreadable":
            needed[name] = own.default is Parameter.empty
    return needed


def used(function: Callable[..., Any], taken: str, record: type[Opened]) -> set[str]:
    """The fields of a record that a function uses, which takes it, or a mapping of several, as a
    parameter; one of several is called `recording` or `arm`, and is the parameter's of a function
    that it is handed to.

    The name of one of several is that of its folder.
    """
    fields, found, each = get_type_hints(record), set[str](), {taken, taken.removesuffix("s")}
    for node in ast.walk(ast.parse(dedent(getsource(function)))):
        if isinstance(node, ast.Attribute) and root(node.value) in each:
            method = getattr(record, node.attr, None)
            found |= used(method, "self", record) if callable(method) else {node.attr}
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            callee = function.__globals__.get(node.func.id)
            handed = [k for k, own in enumerate(node.args) if root(own) in each]
            for place in handed if isinstance(callee, FunctionType) else ():
                found |= used(callee, [*signature(callee).parameters][place], record)
    return (found & fields.keys()) - ({"name"} if taken.endswith("s") else set())


def root(node: ast.expr) -> str:
    """The name of a record, or of the mapping that it is taken from."""
    node = node.value if isinstance(node, ast.Subscript) else node
    return node.id if isinstance(node, ast.Name) else ""


def test_every_rule_is_looked_at_and_every_step_has_one(declared: dict[str, Names]) -> None:
    assert declared.keys() == {*RULES}
    assert {*map(step_of, declared)} == STEPS


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_gives_what_its_step_takes(rule: str, declared: dict[str, Names]) -> None:
    """By its name: no more, and at least what has no default."""
    files, settings = declared[rule]["input"], declared[rule]["params"]
    taken = parameters(step_of(rule))
    assert files & settings == set()
    assert (files | settings) - taken.keys() == set(), "not taken"
    assert {name for name, need in taken.items() if need} - files - settings == set(), "not given"


@pytest.mark.parametrize("step", sorted(STEPS))
def test_what_a_step_may_be_given_some_rule_gives(step: str, declared: dict[str, Names]) -> None:
    given = [names["input"] | names["params"] for rule, names in declared.items()
             if step_of(rule) == step]  # fmt: skip
    assert set().union(*given) == parameters(step).keys()


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_names_what_its_step_returns(rule: str, declared: dict[str, Names]) -> None:
    """The fields of a tuple, or the keys of a dictionary; else it has one output."""
    function, names = load_step(step_of(rule)), declared[rule]["output"]
    kind = get_type_hints(function)["return"]
    if kind is type(None):  # it writes its files itself
        assert rule == "simulate_recording_simulated"
    elif hasattr(kind, "_fields"):
        assert names == {*kind._fields}
    elif get_origin(kind) is dict and get_args(kind)[1] is not float and len(names) > 1:
        assert names - keys_of(function, kind, rule) == set()
    else:
        assert len(names) == 1


def keys_of(function: Callable[..., Any], kind: Any, rule: str) -> set[str]:
    """The keys that a step may return, by the words in its module and in those that it uses.

    With the numbers of a figure, and the tables of arms, whose steps write their rows.
    """
    if rule == "make_tables":
        return {*OF_RECORDINGS, *OF_MOTION, *OF_ARMS, *PARTS}
    path = Path(function.__code__.co_filename)
    used = [path, *imported_modules(path)]
    words = {word for file in used for word in re.findall(r'"(\w+)"', file.read_text())}
    numbers = {f"{word}_data" for word in words}
    return (
        words | numbers if Drawing in [get_args(kind)[1], *get_args(get_args(kind)[1])] else words
    )
