"""What a script reads is what its rule declares: then a result follows from what it depends on."""

from pathlib import Path

import pytest

from tests.conftest import PROJECT
from tests.step_names import Declared, declared_names, differences, read_names
from tests.synthetic import write_recording
from ur5lib.report.tables.making import declarations

SCRIPTS = {path.stem: path for path in (PROJECT / "workflow" / "scripts").glob("*.py")}
DEVICES = ("force", "imu")
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
    # The files of the devices, by the names that a table of clocks has for them.
    "align_signals": [f"does not read input.{name}, which its rule declares" for name in DEVICES],
    # The document names its figures by their place in the folder.
    "write_paper": ["does not read input.columns, which its rule declares"],
    "simulate_recording": [
        "does not read input.way_points, which its rule declares",  # its plan names the file
        "does not read output.summary, which its rule declares",  # lies beside the truth
    ],
}
RULE = """\
rule weigh:
    input:
        table="table.csv",
        unread="unread.csv",
    output:
        mass="mass.json",
    params:
        code="0123",
        gravity=9.81,
        length=1,
        width=2,
    run:
        weigh(input, output, params)
"""
SCRIPT = """\
def weigh(input, output, params):
    table = input.table, getattr(input, "undeclared")
    settings = params
    write(helped(table, params), output["mass"])
    print(input)


def helped(table, params):
    return params.gravity, params.get("height"), [params[side] for side in ("length", "width")]
"""


@pytest.fixture(scope="module")
def declared(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Declared]:
    folder = tmp_path_factory.mktemp("everything")
    write_recording(folder / "real", seconds=2, seed=0)
    study = folder / "study.yaml"
    study.write_text(EVERYTHING.replace("FOLDER", str(folder)))
    (folder / "way_points.txt").write_text("movej([0, -1, 1, 0, 0, 0])\n" * 2)
    return declared_names(PROJECT, study)


def test_every_script_has_a_rule(declared: dict[str, Declared]) -> None:
    assert set(declared) == set(SCRIPTS)


@pytest.mark.parametrize("step", sorted(SCRIPTS.keys() - {"make_tables", "tabulate_recording"}))
def test_a_script_reads_what_its_rule_declares(step: str, declared: dict[str, Declared]) -> None:
    found = differences(read_names(SCRIPTS[step], PROJECT), declared[step])
    assert found == NOT_BY_NAME.get(step, [])


def test_the_tables_read_what_their_rules_declare(declared: dict[str, Declared]) -> None:
    """Both pass their inputs on, by kind, to the function of each table."""
    tables = declarations()
    kinds = {kind for table in tables.values() for kind in table.needs} - {"published", "every"}
    names = declared["make_tables"].names
    parts = names["output"] - tables.keys()  # which a step writes as they are shown
    assert {"health", "observability"} <= parts
    of_each = declared["tabulate_recording"].names["input"]
    assert of_each | names["input"] == {"reference", "rows"} | kinds | parts
    assert of_each & names["input"] == {"reference"}
    assert tables.keys() <= names["output"]


def test_a_script_that_reads_something_else_is_found(tmp_path: Path) -> None:
    for name, text in (
        ("Snakefile", RULE),
        ("workflow/scripts/weigh.py", SCRIPT),
        ("study.yaml", "{}"),
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    names = declared_names(tmp_path, tmp_path / "study.yaml")["weigh"]
    assert differences(read_names(tmp_path / "workflow/scripts/weigh.py", tmp_path), names) == [
        "passes all of input on in line 5; pass what is needed",
        "passes all of params on in line 3; pass what is needed",
        "reads input.undeclared, which its rule does not declare",
        "does not read input.unread, which its rule declares",
        "reads params.height, which its rule does not declare",
    ]
