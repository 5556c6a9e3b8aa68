"""A study of efforts in an unknown unit, from `ur5 import` on: no newton is stated or exported, and
every door says what is missing.
"""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import ur5lib
from tests.command import Command
from tests.conftest import Workflow, build_once
from tests.stored_files import made_up_channels
from ur5lib.commands.exported import FOLDERS, FORMATS
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.tables import named, read_csv, read_table

OWN_CODE = {"live.py", "live.hpp", "live.schema.json"}  # of the estimator, the same for every arm
OF_EFFORTS = ("forces", "live_forces", "currents", "sensor")
MISSING, ENDS_IT = "the unit of actual_current is unknown", "--unit actual_current=A"
REMEDY = re.compile(rf"{MISSING}.*{ENDS_IT}", re.DOTALL)


@pytest.fixture(scope="module")
def study(common_folder: Path) -> Workflow:
    """Currents of a made-up arm, times a factor a joint, of a fit and of a contact recording, as
    import reads them.
    """

    def prepare(folder: Path) -> None:
        for seed, name in enumerate(("free", "pushed")):
            (folder / f"made_{name}").mkdir()
            time, channels = made_up_channels(folder / f"made_{name}", 8, seed)
            effort = channels["actual_current"] * np.linspace(40, 120, 6)
            table = {"time": time} | named(channels["actual_q"], "joint_position")
            pd.DataFrame(table | named(effort, "joint_current")).to_csv(
                folder / f"{name}.csv", index=False
            )
        paths = [folder / f"{name}.csv" for name in ("free", "pushed")]
        entries = [one.as_plain() for one in import_files(paths, UserStatement("ur5"))]
        for entry, role in zip(entries, ("fit", "contact"), strict=True):
            entry |= {"folder": ".", "role": role, "account": []}
        plain = {"study": "unknown", "title": "Unknown", "recordings": entries}
        (folder / "config.yaml").write_text(yaml.safe_dump(plain))

    return build_once(common_folder / "unknown", prepare)


@pytest.fixture
def results(study: Workflow, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(study.folder)
    return Path("results/unknown")


@pytest.mark.slow
def test_no_table_and_no_card_has_a_newton(results: Path) -> None:
    for recording in ("free", "pushed"):
        for file in OF_EFFORTS:
            table = read_table(results / "recordings" / recording / f"{file}.parquet")
            assert not np.isfinite(table.drop(columns=["time", "segment"]).to_numpy(float)).any()
    verdicts = read_csv(results / "tables" / "verdicts.csv").set_index(["question", "rank"])
    assert verdicts.loc[("force", 1), "state"] == "do not use"
    page = " ".join((results / "report.html").read_text().split())
    assert MISSING in page
    assert ENDS_IT in page


@pytest.mark.slow
def test_no_export_has_one(results: Path, run_ur5: Command) -> None:
    export = ("export", "--robot", "ur5", "--results", results, "--format")
    for format in sorted({*FORMATS} - OWN_CODE):
        assert run_ur5(*export, format).status == 1, format
    for format in ("live", "thresholds", "thresholds.script", "sensor", *FOLDERS):
        answer = run_ur5(*export, format, "--accept", "known on a bench", "--output", "made")
        assert (answer.status, Path("made").exists()) == (1, False), format


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ("check", "config.yaml"),
        ("payload", "config.yaml"),
        ("import", "free.csv", "--robot", "ur5"),
    ],
)
def test_commands_say_what_is_missing(
    results: Path, run_ur5: Command, command: tuple[str, ...]
) -> None:
    assert results.is_dir()
    assert REMEDY.search(run_ur5(*command).line)


@pytest.mark.slow
def test_a_replay_says_what_is_missing(results: Path, run_ur5: Command, tmp_path: Path) -> None:
    described = run_ur5("export", "--robot", "ur5", "--format", "mjcf")
    (tmp_path / "ur5.xml").write_text(described.out)
    answer = run_ur5("replay", tmp_path / "ur5.xml", results, "pushed")
    assert answer.status == 1
    assert REMEDY.search(answer.line)


METHODS: dict[str, Callable[[ur5lib.Model], object]] = {
    "torque": lambda model: model.torque([0, -1.5, 1.5, 0, 0, 0], 0, 0),
    "current": lambda model: model.current([0, -1.5, 1.5, 0, 0, 0], 0, 0),
    "friction": lambda model: model.friction([0.1, 0.5]),
    "single": lambda model: model.single(),
}


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_the_model_of_python_states_none(results: Path, method: str) -> None:
    model = ur5lib.load(results).model("ur5")
    with pytest.raises(ur5lib.InputError, match=REMEDY):
        METHODS[method](model)


@pytest.mark.slow
def test_tables_of_the_model_in_python_are_empty(results: Path) -> None:
    model = ur5lib.load(results).model("ur5")
    for name in ("friction", "torque_constants", "cross_validation"):
        assert model.table(name).empty, name
    assert "forces" not in repr(model) or "no " in repr(model)
