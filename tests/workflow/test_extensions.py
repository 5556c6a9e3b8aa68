"""Friction terms, force estimators and formats of a lab's own, in its folder and in a package.

The files are those of docs/extensions.md.
"""

import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import PROJECT, Workflow, copy_project
from tests.examples import examples
from tests.stored_files import made_up_channels
from tests.warm_snakemake import run_ur5
from ur5lib.tables import read_table
from ur5lib.workspace.extensions import KINDS

CODES = [example.text for example in examples(PROJECT / "docs/extensions.md")]
EXTENSIONS = {
    kind: code for kind, own in KINDS.items() for code in CODES if f"{own.name} = {{" in code
}
CHANNELS = "{time: t, actual_q: q, actual_qd: qd, actual_current: i}"
ENTRY = (
    "  - {{name: {0}, robot: ur5, format: own, folder: raw, file: {0}.mylog, role: {1}, channels: "
)
HEAD = "study: own\ntitle: Own\nrecordings:\n"
STUDY = HEAD + "".join(
    f"{ENTRY.format(name, role)}{CHANNELS}}}\n"
    for name, role in {"free": "fit", "other": "fit", "pushed": "contact"}.items()
)
FRICTION = "results/own/parameters/ur5/friction.json"

FORCES = "results/own/recordings/pushed/forces.parquet"


def add_extensions(folder: Path) -> None:
    (folder / "extensions").mkdir()
    for kind, code in EXTENSIONS.items():
        (folder / "extensions" / f"{kind}.py").write_text(code)


def write_log(path: Path, seed: int) -> None:
    """A made-up UR5 that swings with the page's friction, in the page's format."""
    time, channels = made_up_channels(path.parent / path.stem, seed=seed)
    q, qd, current = (channels[name] for name in ("actual_q", "actual_qd", "actual_current"))
    rubbing = current + 0.3 * np.sign(qd) * np.exp(-np.abs(qd) / 0.1)
    np.savetxt(path, np.column_stack([time, q, qd, rubbing]), header="a log\nof numbers")


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    """A study of files in the lab's own format, built as far as the forces."""
    folder = copy_project(tmp_path_factory.mktemp("own") / "project")
    add_extensions(folder)
    (folder / "config.yaml").write_text(STUDY)
    for seed, name in enumerate(("free", "other", "pushed")):
        write_log(folder / "raw" / f"{name}.mylog", seed)
    workflow = Workflow(folder)
    workflow.build("--", FORCES)
    return workflow


def test_a_study_uses_them(lab: Workflow) -> None:
    assert "next: ur5 run" in lab.ur5("check", "config.yaml")
    forces = read_table(lab.folder / FORCES)
    assert forces.filter(regex="damped").notna().to_numpy().mean() > 0.5
    assert '"stribeck"' in (lab.folder / FRICTION).read_text()
    assert "format: own" in ur5(lab.folder, "import", "raw/free.mylog", "--robot", "ur5").stdout


@pytest.mark.parametrize(
    ("kind", "repeated", "kept"),
    [
        ("estimators", "estimate_forces", "fit_friction"),
        ("friction", "fit_friction", "read_recording"),
        ("formats", "read_recording", "describe_arm"),
    ],
)
def test_a_change_repeats_what_uses_it(
    lab: Workflow, tmp_path: Path, kind: str, repeated: str, kept: str
) -> None:
    own = lab.copied(tmp_path / "project")
    file = own.folder / "extensions" / f"{kind}.py"
    file.write_text(file.read_text() + "\nADDED = True\n")
    planned = own.plan("--", FORCES)
    assert repeated in planned
    assert kept not in planned


def ur5(folder: Path, *arguments: str, packages: str = "") -> subprocess.CompletedProcess[str]:
    """A command of `ur5` in a folder, beside packages in another."""
    environment = {"PYTHONPATH": os.pathsep.join([str(PROJECT), packages])}
    return run_ur5(folder, environment, arguments)


def test_a_package_adds_them_too(lab: Workflow, tmp_path: Path) -> None:
    """By entry points, for every folder; in a folder that states the same, one is refused."""
    folder, packages = tmp_path / "lab", tmp_path / "packages"
    (packages / "mylab").mkdir(parents=True)
    points = ""
    for kind, code in EXTENSIONS.items():
        (packages / "mylab" / f"{kind}.py").write_text(code)
        points += f"[ur5lib.{kind}]\nmine = mylab.{kind}\n"
    information = packages / "mylab-1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Metadata-Version: 2.1\nName: mylab\nVersion: 1.0\n")
    (information / "entry_points.txt").write_text(points)
    folder.mkdir()
    (folder / "raw").symlink_to(lab.folder / "raw")
    (folder / "config.yaml").write_text(STUDY)
    assert ur5(folder, "check", "config.yaml").returncode == 1
    done = ur5(folder, "check", "config.yaml", packages=str(packages))
    assert "next: " in done.stdout
    add_extensions(folder)
    done = ur5(folder, "check", "config.yaml", packages=str(packages))
    assert re.search(  # whichever of the kinds is loaded first
        r"mylab\.(\w+): '\S+' is stated in extensions/\1\.py, too; rename one", done.stderr
    )


def test_no_study_brings_any_along(lab: Workflow, tmp_path: Path) -> None:
    """What lies beside a study elsewhere is not run, and no key of a study names a file."""
    study = lab.folder / "config.yaml"
    (tmp_path / "raw").symlink_to(lab.folder / "raw")
    assert "no extension reads `.mylog`" in ur5(tmp_path, "check", str(study)).stdout


COMMANDS = [
    ("check", "config.yaml"),
    ("import", "raw/free.mylog", "--robot", "ur5"),
    ("payload", "config.yaml"),
]


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_names_the_files_that_it_runs_and_can_do_without(
    lab: Workflow, tmp_path: Path, command: tuple[str, ...]
) -> None:
    own = lab.copied(tmp_path / "project").folder
    trace = own / "ran"
    for kind, code in EXTENSIONS.items():
        line = f"open('ran', 'a').write('{kind} ')"
        (own / "extensions" / f"{kind}.py").write_text(f"{code}\n{line}\n")
    told = ur5(own, *command).stderr
    ran = trace.read_text().split()
    assert {kind for kind in KINDS if f"ur5: runs extensions/{kind}.py;" in told} == {*ran}
    assert told.count("ur5: runs") == len(ran)
    trace.unlink()
    told = ur5(own, "--no-extensions", *command).stderr
    assert "ur5: runs" not in told
    assert "Traceback" not in told
    assert not trace.exists()


TERM = """from ur5lib.robots.friction import Term

TERMS = {"root": Term(lambda motion: COLUMNS)}
"""
WRONG = [  # a file, and what is said about it
    ("friction", "TERMS = {", "friction.py, line 1 fails (SyntaxError: '{' was never closed)"),
    ("friction", "import tea", "friction.py, line 1 fails (ModuleNotFoundError: No module"),
    ("friction", "TERM = 1", "extensions/friction.py needs a dict TERMS by name; docs/"),
    ("friction", "TERMS = {'root': 1}", "'root' is no Term; docs/extensions.md shows one"),
    ("friction", TERM.replace("COLUMNS", "motion.qd"), "columns of shapes [(), (), ()]"),
    ("friction", TERM.replace("COLUMNS", "[motion.x]"), "line 3 fails (AttributeError: "),
    ("friction", "TERMS = {'viscous': 1}", "'viscous' is a term of ur5lib, or no lower-case word"),
    ("formats", "FORMATS = {'.h5': print}", "'.h5' is read by ur5lib, is no ending such as"),
    ("formats", "FORMATS = {'.mylog': 3}", "'.mylog' is read by ur5lib, is no ending such as"),
    ("formats", "FORMATS = {'.mylog': float}", "the reader of `.mylog` fails (TypeError: "),
    (
        "formats",
        "FORMATS = {'.log': print}",
        "no extension reads `.mylog` (but .log); add",
    ),
]


@pytest.mark.thorough
@pytest.mark.parametrize(("kind", "code", "fault"), WRONG)
def test_what_is_wrong_in_a_file_is_told(
    lab: Workflow, tmp_path: Path, kind: str, code: str, fault: str
) -> None:
    add_extensions(tmp_path)
    (tmp_path / "raw").symlink_to(lab.folder / "raw")
    (tmp_path / "config.yaml").write_text(STUDY)
    (tmp_path / "extensions" / f"{kind}.py").write_text(code)
    done = ur5(tmp_path, "check", "config.yaml")
    assert fault in " ".join((done.stdout + done.stderr).split())
    assert "Traceback" not in done.stderr
    assert done.returncode == 1


def test_snakemake_tells_it_in_a_sentence(lab: Workflow, tmp_path: Path) -> None:
    """Of an estimator, too, when it runs."""
    own = lab.copied(tmp_path / "project")
    file = own.folder / "extensions" / "estimators.py"
    file.write_text(file.read_text().replace("wrench[:, :, 0]", "wrench"))
    done = own.run("--cores", "1", "--", FORCES)
    fault = "extensions/estimators.py: 'damped' states a (750, 6, 1) `wrench`, where (750, 6) is"
    assert fault in done.stdout
    for kind, declared in reversed(KINDS.items()):  # the first that fails is told
        (own.folder / "extensions" / f"{kind}.py").write_text(f"{declared.name} = 3")
        told = own.run("--dry-run", "--configfile", "config.yaml").stdout
        assert told.count("\n") < 6
        assert f"extensions/{kind}.py needs a dict {declared.name} by name; docs/" in told
        assert 'extensions.py", line' not in told  # no traceback
