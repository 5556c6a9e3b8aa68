"""The live estimator of the default study: what is exported, and what the report shows of it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from tests.conftest import Workflow
from ur5lib.commands.exported import exported, write_folder
from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.records.signals import Signals
from ur5lib.records.verdicts import Verdict
from ur5lib.tables import read_json, write_rows
from ur5lib.topics.live.exports import NODE
from ur5lib.topics.live.live import Live

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(demo: Workflow) -> Path:
    return demo.folder / "results" / "demo"


def test_what_the_live_estimator_needs_is_exported(results: Path, tmp_path: Path) -> None:
    """The file is what its schema says, tells the force, and is refused where the report does."""
    text = exported("ur5", None, "live", results, "way_points_pushed")
    known, schema = (
        json.loads(text),
        json.loads(exported("ur5", None, "live.schema.json", None, "")),
    )
    jsonschema.validate(known, schema)
    [pushed] = [row for row in known["judged_on"] if row["recording"] == "way_points_pushed"]
    sensor = StudyFiles(results).sensor("way_points_pushed")
    size = np.linalg.norm(sensor[[f"compensated_F{axis}" for axis in "xyz"]], axis=1)
    assert pushed["rmse_in_contact"] < 0.7 * np.sqrt((size[size > 5.0] ** 2).mean())
    table = StudyFiles(results).table("live_pushes")
    stated = [own["value"] or np.nan for own in known["smallest_pushes"]]
    np.testing.assert_allclose(stated, table["value"].astype(float))
    shutil.copytree(results / "parameters", tmp_path / "parameters")
    for part in ("tables", "recordings", "configuration.yaml"):
        (tmp_path / part).symlink_to(results / part)
    path = tmp_path / "parameters" / "ur5" / "live.json"
    refused = {"refused": {"code": "short recordings", "text": "too short"}}
    path.write_text(json.dumps(read_json(path) | refused))
    with pytest.raises(InputError, match="no force of ur5 is stated: "):
        exported("ur5", None, "live", tmp_path, "")


def test_the_folder_of_a_node_has_all_it_needs(results: Path, tmp_path: Path) -> None:
    """But rclpy; it replaces no other folder, and is written as a whole."""
    folder = tmp_path / "force"
    write_folder("ros2", "ur5", results, "", "", folder)
    assert {own.name for own in folder.iterdir()} == {*NODE, "arm.json"}
    assert os.access(folder / "ur5_force.py", os.X_OK)
    call = "from live import Live; print(Live.load('arm.json').input)"
    done = subprocess.run(
        [sys.executable, "-c", call], cwd=folder, capture_output=True, text=True, check=True
    )
    assert done.stdout == "current\n"
    for node in ("ur5_force.py", "ur5_force.launch.py"):
        compile((folder / node).read_text(), node, "exec")
    with pytest.raises(InputError, match="force exists; name another"):
        write_folder("ros2", "ur5", results, "", "", folder)
    with pytest.raises(InputError, match="ur7"):
        write_folder("ros2", "ur7", results, "", "", tmp_path / "other")
    assert [*tmp_path.iterdir()] == [folder]
    with pytest.raises(InputError, match="ros2 is a folder; name it by --output"):
        exported("ur5", None, "ros2", results, "")


def test_it_carries_the_reason_for_which_a_verdict_is_overruled(
    results: Path, tmp_path: Path
) -> None:
    for part in ("parameters", "recordings", "configuration.yaml"):
        (tmp_path / part).symlink_to(results / part)
    row = Verdict(question="force", state="do not use", reason="blind")
    write_rows(Verdict, [row], tmp_path / "tables" / "verdicts.csv")
    with pytest.raises(InputError, match="force: do not use"):
        exported("ur5", None, "live", tmp_path, "")
    known = json.loads(exported("ur5", None, "live", tmp_path, "", accept="a lesson"))
    jsonschema.validate(known, json.loads(exported("ur5", None, "live.schema.json", None, "")))
    assert known["accepted"]["reason"] == "a lesson"
    Live(known)


@pytest.mark.parametrize("name", ["way_points_pushed", "standstill_pushed"])
def test_the_report_shows_what_the_exported_estimator_states(results: Path, name: str) -> None:
    """Fed sample by sample: its wrench, its contacts, and the rows of its table."""
    study = StudyFiles(results)
    run, stated = study.record(Signals, name), study.frame(name, "live_forces")
    estimator = Live(json.loads(exported("ur5", None, "live", results, name)))
    assert run.actual_q is not None
    assert run.actual_qd is not None
    assert run.actual_current is not None
    samples = zip(run.time, run.actual_q, run.actual_qd, run.actual_current, strict=True)
    answers = [estimator.step(*sample) for sample in samples]
    wrench = stated[[f"live_{part}" for part in ("Fx", "Fy", "Fz", "nx", "ny", "nz")]]
    np.testing.assert_allclose(wrench, [one.wrench for one in answers], rtol=0, atol=1e-9)
    contact = np.array([one.contact for one in answers])
    np.testing.assert_array_equal(stated["contact"], contact == "contact")
    np.testing.assert_array_equal(stated["known"], contact != "unknown")
    detection = study.table("live_detection").query("recording == @name")
    alarms = np.count_nonzero(np.diff(np.append(0, contact == "contact")) > 0)
    minutes = len(run.time) * run.period / 60
    assert (detection["alarms_per_min"] * minutes).round(6).unique() == [alarms]
    assert detection["unknown"].unique() == pytest.approx([np.mean(contact == "unknown")])
    assert (detection["found"] <= alarms).all()
