"""What a script reads is what its rule declares: then a result follows from what it depends on."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from ur5lib.tidy.making import declarations

from tests.conftest import PROJECT
from tests.synthetic import write_recording

SCRIPTS = {path.stem: path for path in (PROJECT / "workflow" / "scripts").glob("*.py")}
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
NOT_BY_NAME = {
    ("align_signals", "input"): ["force", "imu"],  # by the names that a table of clocks has
    ("simulate_recording", "input"): ["way_points"],  # its plan names the file
    ("simulate_recording", "output"): ["summary"],  # lies beside the truth
}
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


def declared_names(study: Path) -> dict[str, Names]:
    """What the rules of a study declare, all names but `code`, by the script."""
    listing = LIST_RULES.replace("KINDS", str(KINDS))
    program = [sys.executable, "-c", listing, str(study)]
    done = subprocess.run(program, cwd=PROJECT, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, Names] = {}
    for rule, kinds in map(json.loads, done.stdout.splitlines()):
        step = max((name for name in SCRIPTS if rule.startswith(name)), key=len)
        names = found.setdefault(step, {kind: set() for kind in KINDS})
        for kind in KINDS:
            names[kind] |= {*kinds[kind]} - {"code"}
    return found


def read_names(text: str, kind: str) -> set[str]:
    """The names of a kind that a script reads as such, as `input.arm` or `params.get("order")`."""
    written = rf'\b{kind}(?:\.get\("|\["|\.(?!get\(|items\())(\w+)|attr\({kind}, "(\w+)"'
    return {one or other for one, other in re.findall(written, text)}


def unread(text: str, kind: str, declared: set[str]) -> list[str]:
    """Declared names that a script does not spell, nor, where it computes the names that it reads,
    a module of the library that it imports.
    """
    spelt = {*re.findall(r"\w+", text)}
    if re.search(rf'\b{kind}(?:\[|\.get\()(?!")|attr\({kind}, (?!")', text):
        modules = (PROJECT / name.replace(".", "/") for name in re.findall(r"from (ur5\S+)", text))
        files = filter(Path.is_file, (path.with_suffix(".py") for path in modules))
        spelt |= {word for file in files for word in re.findall(r'"(\w+)"', file.read_text())}
    of_figures = "_data" if kind == "output" else ""  # their numbers beside them
    return sorted(name for name in declared if name.removesuffix(of_figures) not in spelt)


@pytest.fixture(scope="module")
def declared(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Names]:
    folder = tmp_path_factory.mktemp("everything")
    write_recording(folder / "real", seconds=2, seed=0)
    study = folder / "study.yaml"
    study.write_text(EVERYTHING.replace("FOLDER", str(folder)))
    (folder / "way_points.txt").write_text("movej([0, -1, 1, 0, 0, 0])\n" * 2)
    return declared_names(study)


def test_every_script_has_a_rule(declared: dict[str, Names]) -> None:
    assert set(declared) == set(SCRIPTS)


@pytest.mark.parametrize("step", sorted(SCRIPTS.keys() - {"make_tables", "tabulate_recording"}))
def test_a_script_reads_what_its_rule_declares(step: str, declared: dict[str, Names]) -> None:
    text = SCRIPTS[step].read_text()
    for kind, names in declared[step].items():
        assert read_names(text, kind) - names == set(), "not declared"
        assert unread(text, kind, names) == NOT_BY_NAME.get((step, kind), []), "not read"


def test_the_tables_read_what_their_rules_declare(declared: dict[str, Names]) -> None:
    """Both pass their inputs on, by kind, to the function of each table."""
    tables = declarations()
    kinds = {kind for table in tables.values() for kind in table.needs} - {"published", "every"}
    names = declared["make_tables"]
    parts = names["output"] - tables.keys()  # which a step writes as they are shown
    assert {"health", "observability"} <= parts
    of_each = declared["tabulate_recording"]["input"]
    assert of_each | names["input"] == {"reference", "rows"} | kinds | parts
    assert of_each & names["input"] == {"reference"}
    assert tables.keys() <= names["output"]
