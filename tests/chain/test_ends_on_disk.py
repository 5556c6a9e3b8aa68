"""What else is a file: exports, comparisons, the live estimator and a built study, from Python."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import ur5lib
from tests.chain.test_in_memory import spoilt
from tests.conftest import PROJECT
from tests.in_memory import FREE
from ur5lib.commands.exported import FOLDERS, FORMATS, exported

NOT_HERE = {"sensor", *FOLDERS}  # no force sensor; a folder is no text
OF_OTHERS = {"live"}  # it lists the pushes of all recordings, not of the fit's alone


def test_each_format_is_told_without_a_study(model: ur5lib.Model) -> None:
    texts = {name: model.export(name) for name in FORMATS if name not in NOT_HERE}
    assert all(texts.values())
    assert "friction=" in texts["urdf"]
    with pytest.raises(ur5lib.InputError, match="no reading of a force sensor on ur5e"):
        model.export("sensor")
    with pytest.raises(ur5lib.InputError, match="did you mean `urdf`"):
        model.export("urfd")
    for name in FOLDERS:
        with pytest.raises(ur5lib.InputError, match=f"{name} has several files; `ur5 export"):
            model.export(name)
    with pytest.raises(ur5lib.InputError, match="leave out `as_in`"):
        model.export("thresholds", as_in="free1")
    joint = model.export("urdf", ros_names=True, link_model="maker")
    assert "shoulder_pan_joint" in joint


def test_what_a_model_in_a_file_lacks_is_told(model: ur5lib.Model, tmp_path: Path) -> None:
    model.save(tmp_path / "model.json")
    again = ur5lib.load_model(tmp_path / "model.json")
    for asked in (again.export, lambda: ur5lib.compare(again, model)):
        with pytest.raises(ur5lib.InputError, match="lacks the recordings"):
            asked()


def test_a_model_differs_from_another_by_more_than_their_errors(
    folder: Path, model: ur5lib.Model, tmp_path: Path
) -> None:
    same = ur5lib.compare(model, model)
    assert [*same] == ["topic", "name", "before", "after", "differs", "changed"]
    assert {"model", "friction", "currents"} <= {*same["topic"]}
    assert not same[["differs", "changed"]].any(axis=None)
    for name in FREE:  # a brake that drags, and doubles the friction
        table = pd.read_csv(folder / name)
        table["actual_current_3"] += 0.3 * np.sign(table["actual_qd_3"])
        table.to_csv(tmp_path / name, index=False)
    worn = ur5lib.fit(ur5lib.read([tmp_path / name for name in FREE], "ur5e"))
    found = ur5lib.compare(model, worn).query("changed and topic == 'friction'")
    assert "ur5e, joint 4, coulomb" in {*found["name"]}


def test_the_live_estimator_follows_a_push(model: ur5lib.Model, pushed: ur5lib.Recordings) -> None:
    estimate, table = ur5lib.live(model), pushed.device("robot")
    states = [
        table[[f"actual_{name}_{k}" for k in range(6)]].to_numpy()
        for name in ("q", "qd", "current")
    ]
    rows = zip(table.index, *states, strict=True)
    answers = [estimate.step(*row) for row in rows]
    force = np.array([one.wrench[0] for one in answers])
    times = table.index.to_numpy()
    assert force[(times > 3.5) & (times < 4.8)].max() == pytest.approx(40, abs=12)


def test_recordings_that_may_not_be_used_are_refused_by_their_check(
    folder: Path, free: ur5lib.Recordings, tmp_path: Path
) -> None:
    pd.testing.assert_frame_equal(free.check(), free.findings())
    with pytest.raises(ur5lib.InputError, match=r"free1: .*joint 2.*\nfree2: "):
        spoilt(folder, tmp_path).check()


def test_a_missing_study_is_told_before_anything_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ur5lib.InputError, match="this folder has no study"):
        ur5lib.run("mine")


@pytest.mark.slow
def test_a_study_is_built_and_its_model_exported_as_on_the_command_line(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """To the byte, and, but for what rests on other recordings, as the same fit in memory."""
    monkeypatch.chdir(tmp_path)
    runs = [
        {"name": Path(name).stem, "format": "rtde-csv", "folder": str(folder), "file": name}
        | {"role": "contact" if name == "pushed.csv" else "fit"}
        for name in (*FREE, "pushed.csv")
    ]
    plain = {"study": "mine", "title": "Mine", "robot": "ur5e", "recordings": runs}
    Path("mine.yaml").write_text(yaml.safe_dump(plain))
    study = ur5lib.run("mine.yaml", quiet=True)
    assert study.recordings == ["free1", "free2", "pushed"]
    built, fitted = study.model("ur5e"), ur5lib.fit(ur5lib.read("mine.yaml"))
    for name in (one for one in FORMATS if one not in NOT_HERE):
        command = [sys.executable, "-m", "ur5lib", "export", "--robot", "ur5e", "--format", name]
        done = subprocess.run(
            [*command, "--results", "mine", "--output", "told"],
            env={"PYTHONPATH": str(PROJECT), "OMP_NUM_THREADS": "1", "PATH": ""}, check=True,
        )  # fmt: skip
        assert done.returncode == 0
        told = Path("told").read_text()
        Path("told").unlink()
        assert built.export(name) == told, name
        assert name in OF_OTHERS or fitted.export(name) == told, name
    assert exported("ur5e", None, "urdf", study.folder, "") + "\n" == built.export()
