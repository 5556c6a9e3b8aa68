"""Every example in a document holds: commands exist, studies are valid, code runs."""

import contextlib
import io
import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock

import numpy as np
import pandas as pd
import pytest
import yaml
from pypdf import PdfReader
from typer.testing import CliRunner

from tests.conftest import PROJECT
from tests.examples import Example, check_command, examples, kind_of, words_of, yaml_faults
from tests.house.test_docs import PAGES
from tests.house.test_seven_joints import arm as seven_joints
from tests.in_memory import put_recordings
from tests.scripts import SCRIPTS, run_script
from ur5lib.cli import app
from ur5lib.commands.contract import Contract
from ur5lib.commands.exported import exported
from ur5lib.finished import FinishedStudy
from ur5lib.records.verdicts import RecordingUse, Verdict, reason_in_words
from ur5lib.robots.description import robot_path, robot_yaml
from ur5lib.tables import write_rows, write_table
from ur5lib.workspace.extensions import ENTRY_POINT_GROUP, KINDS

DOCUMENTS = [*PAGES, *sorted((PROJECT / "benchmarks").glob("*.py"))]
EXAMPLES = [example for page in DOCUMENTS for example in examples(page)]
COMMANDS = sorted({line for e in EXAMPLES if e.kind == "shell" for line in e.text.splitlines()})
NEEDS_NO_FILES = re.compile(r"ur5 (export|settings|schema) (?!.*results/).*--")


def of_kind(kind: str) -> pytest.MarkDecorator:
    """With each example of a kind; the code of docs/outside.md is run by tests/rivals."""
    known = [e for e in EXAMPLES if e.kind == kind]
    if kind in ("toml", "python"):
        known = [e for e in known if e.page != "docs/outside.md"]
    return pytest.mark.parametrize("example", known, ids=str)


def test_every_example_is_of_a_known_kind() -> None:
    assert {e.kind for e in EXAMPLES} >= {"shell", "yaml", "python", "listing", "moves"}
    assert [str(example) for example in EXAMPLES if example.kind == "unknown"] == []
    assert kind_of("brew --tea") == kind_of("SELECT * FROM tea") == "unknown"


@pytest.mark.parametrize("line", COMMANDS)
def test_commands_are_known_with_their_options(line: str) -> None:
    check_command(line)


@pytest.mark.parametrize(
    "line", ["make tea", "ur5 brew", "snakemake --tea", "ur5 check --tea a", "ros2 launch tea.py"]
)
def test_a_command_that_does_not_exist_is_found(line: str) -> None:
    with pytest.raises((Exception, SystemExit)):
        check_command(line)


@pytest.mark.parametrize("line", [*filter(NEEDS_NO_FILES.match, COMMANDS)])
def test_commands_run_that_need_no_files(line: str) -> None:
    done = CliRunner().invoke(app, words_of(line)[1:])
    assert done.exit_code == 0, done.output


@of_kind("yaml")
def test_studies_are_valid(
    example: Example, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With arms of one's own, `my-arm` and one of seven joints."""
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    Path("robots/my-arm.yaml").write_bytes(robot_path("ur5").read_bytes())
    Path("robots/seven.yaml").write_text(robot_yaml(seven_joints()))
    if example.text.startswith("contract: "):
        Contract.model_validate(yaml.safe_load(example.text))
    else:
        assert yaml_faults(example.text, tmp_path) == []


@pytest.mark.parametrize("text", ["tea: 1", "force_sensor:\n  columns: [time, ft]"])
def test_a_study_that_is_wrong_is_found(text: str, tmp_path: Path) -> None:
    assert yaml_faults(text, tmp_path) != []


@of_kind("toml")
def test_entry_points_are_of_groups_that_are_taken_up(example: Example) -> None:
    [group] = tomllib.loads(example.text)["project"]["entry-points"]
    assert group.removeprefix(ENTRY_POINT_GROUP) in KINDS


@of_kind("listing")
def test_listed_files_exist(example: Example) -> None:
    """A line may name two, or go on with a text."""
    lines = [line for line in example.text.splitlines() if line.strip() and line[0] != " "]
    paths = [path for line in lines for path in re.split(r" {2,}", line)[0].split(", ")]
    assert [path for path in paths if not (PROJECT / path).exists()] == []


# Code, each as its page says that it is used


def record(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a stand-in for ur_rtde's interface, which is not installed here."""
    module = MagicMock()
    monkeypatch.setitem(sys.modules, "rtde_receive", module)
    exec(code, {"input": module.input})
    assert [args for _, args, _ in module.mock_calls[1:]] == [
        ("free.csv",),
        ("recording; press Enter to stop",),
        (),
    ]
    module.RTDEReceiveInterface.return_value.stopFileRecording.assert_called_once_with()


def fit(code: str, _: pytest.MonkeyPatch) -> None:
    """On recordings of the names that it has."""
    put_recordings(Path())
    known: dict[str, Any] = {}
    exec(code, known)
    assert known["forces"]["Fmap_Fx"].max() > 20
    assert {*known["errors"]["recording"]} == {"pushed"}
    assert Path("model.json").is_file()


def cross_validate(code: str, _: pytest.MonkeyPatch) -> None:
    """On recordings of the names that it has: errors are below those of a constant current."""
    put_recordings(Path())
    known: dict[str, Any] = {}
    exec(code, known)
    assert [*known["table"].index] == [1, 2, 3, 4, 5, 6]
    assert (known["table"]["nrmse", "fitted"] < 1).all()


def read_frames(code: str, _: pytest.MonkeyPatch) -> None:
    """On recordings of the names that it has."""
    put_recordings(Path())
    known: dict[str, Any] = {}
    exec(code, known)
    assert known["runs"].names == ["monday", "tuesday"]
    pd.testing.assert_frame_equal(known["run"].q, known["runs"]["monday"].q)


def judge(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """On verdicts that are made up; tests/artefacts/test_demo.py runs it on those of a study."""
    rows = [Verdict(question="force", state="do not use", reason="blind"), Verdict(question="load")]
    write_rows(Verdict, rows, "results/mine/tables/verdicts.csv")
    uses = [RecordingUse(recording="pushed", purpose="contacts", use="yes")]
    write_rows(RecordingUse, uses, "results/mine/tables/uses.csv")
    use = {"joint": [3], "parameter": "coulomb", "use": "no", "reason": "unlikely"}
    model = SimpleNamespace(use=pd.DataFrame(use))
    monkeypatch.setattr(FinishedStudy, "model", lambda _, robot: {"ur5e": model}[robot])
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code, {})
    assert printed.getvalue().splitlines() == [
        f"force: do not use. {reason_in_words('blind')}",
        f"coulomb of joint 3: no. {reason_in_words('unlikely')}",
        "pushed for contacts: yes. ",
    ]


def rows_to_type_in(code: str, _: pytest.MonkeyPatch) -> None:
    """On a table with a row that may be used, one that may not, and one of another joint."""
    rows = pd.DataFrame({"joint": [3, 3, 2], "parameter": ["total_0", "coulomb", "total_0"]})
    rows = rows.assign(
        value=[1.0, 2.0, 3.0], low=0.5, high=4.0, use=["yes", "no", "yes"], reason=""
    )
    Path("results/mine/tables").mkdir(parents=True)
    rows.to_csv("results/mine/tables/friction.csv", index=False)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code, {})
    assert [line.split()[0] for line in printed.getvalue().splitlines()] == ["parameter", "total_0"]


def read(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a table where the page says that it lies."""
    path = Path("results/mine/recordings/pushed/forces.parquet")
    path.parent.mkdir(parents=True)
    write_table(pd.DataFrame({"time": [0.0]}), str(path))
    exec("\n".join(line.removeprefix(">>> ") for line in code.splitlines()), {})


def draw(code: str, _: pytest.MonkeyPatch) -> None:
    """Of two tables; the figure has the width that the page states, and letters as outlines."""
    waves = {"time": [0.0, 1.0], "Fmap_Fx": [0.0, 9.0], "Fmap_std_Fx": 1.0, "compensated_Fx": 0.0}
    folder = Path("results/mine/recordings/pushed")
    folder.mkdir(parents=True)
    for name in ("forces", "sensor"):
        pd.DataFrame(waves).to_parquet(folder / f"{name}.parquet")
    Path("results/mine/tables").mkdir()
    exec(code, {})
    (page,) = PdfReader("force.pdf").pages
    assert float(page.mediabox.width) / 72 * 25.4 == pytest.approx(88, abs=0.1)
    for font in page["/Resources"]["/Font"].values():
        described = font["/DescendantFonts"][0].get_object()["/FontDescriptor"].get_object()
        assert "/FontFile2" in described, "TrueType, embedded"


def extend(code: str, _: pytest.MonkeyPatch) -> None:
    """As the file that states it; tests/workflow/test_extensions.py runs a study with all."""
    [kind] = [kind for kind, own in KINDS.items() if f"{own.name} = {{" in code]
    Path("extensions").mkdir()
    Path("extensions", f"{kind}.py").write_text(code)
    program = f"from {KINDS[kind].taken_up_by} import *"
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    subprocess.run([sys.executable, "-c", program], env=environment, check=True)


def use_the_rules(code: str, _: pytest.MonkeyPatch) -> None:
    """What it imports; tests/workflow/test_lab.py runs the rules as a module."""
    known: dict[str, Path] = {}
    exec(code.partition("\n")[0], known)
    assert known["SNAKEFILE"].is_file()


def estimate_live(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the exported file of the estimator, and an arm's file, beside it."""
    from tests.topics.live import made_arm

    Path("live.py").write_text(exported("ur5", None, "live.py", None, ""))
    Path("arm.json").write_text(json.dumps(made_arm.exported()))
    monkeypatch.syspath_prepend(".")
    known: dict[str, Any] = {"time": 0.0, "q": np.zeros(6), "qd": np.zeros(6)}
    exec(code, known | {"current": np.zeros(6)}, known)
    assert known["answer"].contact == "unknown"


def declare(code: str, _: pytest.MonkeyPatch) -> None:
    """As the module of the step does."""
    module = (PROJECT / "ur5lib" / "steps" / "estimate_forces.py").read_text()
    *stated, _ = code.splitlines()
    assert len(stated) > 5
    assert [line for line in stated if line not in module.splitlines()] == []


def script(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the files that the ten scripts name; the same recordings are fitted once."""
    run_script(code, Path(), monkeypatch)


PYTHON: dict[str, Callable[[str, pytest.MonkeyPatch], None]] = {
    "class Inputs": declare,
    **dict.fromkeys(SCRIPTS, script),
    "import rtde_receive": record,
    ">>> import ur5lib": read,
    "from ur5lib import load\n\nrows": rows_to_type_in,
    "from ur5lib import load": judge,
    "import matplotlib": draw,
    "import pandas as pd, ur5lib": read_frames,
    "import pandas as pd\nimport ur5lib": cross_validate,
    "import ur5lib": fit,
    "import numpy as np": extend,
    "from live import Live": estimate_live,
    "from ur5lib.workspace.places import": use_the_rules,
}


@of_kind("python")
def test_code_runs(example: Example, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    runs = [run for start, run in PYTHON.items() if example.text.startswith(start)]
    assert runs, "nobody has said yet how this example is run"
    runs[0](example.text, monkeypatch)
