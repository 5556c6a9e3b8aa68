"""Loads on the virtual stand, by all steps: one that nobody declared, and one that is grasped."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from tests.conftest import build_once
from ur5lib.force.estimators import GATED
from ur5lib.records.contacts import Contacts
from ur5lib.records.forces import Forces
from ur5lib.records.judgement import Judgement
from ur5lib.records.premises import Premises
from ur5lib.stand.truth import Truth
from ur5lib.steps.make_tables import OF_RECORDINGS, rows_of_recordings
from ur5lib.tables import read_record, table_by_owner
from ur5lib.timeseries.sampling import interpolated

pytestmark = pytest.mark.slow

SECONDS = 16.0
CARRIED = {"mass": 2.7, "center_of_mass": [0.02, 0.0, 0.06]}
PUSH = {"kind": "push", "start_s": 3, "seconds": 2, "force": [0, 40, 0]}
LOAD = {"kind": "load", "start_s": 8, "seconds": 8, "mass": 2}


def recording(
    name: str, role: str, seed: int, draw: int, seconds: float = SECONDS, **more: Any
) -> dict[str, Any]:
    """An entry of the study; what differs of its motion and what it carries comes as keywords."""
    motion = {key: more.pop(key) for key in ("posture", "limit_share") if key in more}
    motion |= {"period_s": seconds, "harmonics": 10 if role == "fit" else 8}
    trajectory = {"kind": "fourier", "draw": draw} | motion
    plan = {"trajectory": trajectory, "seconds": seconds, "seed": seed} | more
    return {"name": name, "robot": "ur5", "format": "thesis-csv", "role": role, "simulate": plan}


STUDY = {
    "study": "loads",
    "title": "A load that nobody declared, and one that is grasped",
    "recordings": [
        recording("fit_1", "fit", 1, 4),
        recording("fit_2", "fit", 2, 7, posture=[-0.4, -1.2, 1.3, -1.2, 1.2, -0.5]),
        recording("fit_3", "fit", 3, 9, posture=[1.2, -1.9, 1.9, -1.0, 0.9, 1.0], limit_share=0.25),
        # These two are of one path, and alone on it: a template of each other, were it not for the
        # load of one of them.
        recording("unloaded", "validate", 4, 12),
        recording("loaded", "validate", 5, 12, undeclared_payload=CARRIED),
        recording("grasping", "contact", 6, 13, seconds=20.0, contacts=[PUSH, LOAD]),
    ],
}


@pytest.fixture(scope="module")
def results(common_folder: Path) -> Path:
    def prepare(folder: Path) -> None:
        (folder / "config.yaml").write_text(yaml.safe_dump(STUDY, sort_keys=False))

    until = "--until", "judge_recording", "judge_contacts"
    return build_once(common_folder / "loads", prepare, *until).folder / "results" / "loads"


def table(results: Path, name: str, recording: str) -> pd.DataFrame:
    """As the report's."""
    folder = results / "recordings" / recording
    judged = {recording: read_record(Judgement, folder / "judgement.json")}
    contacts = {recording: read_record(Contacts, folder / "contacts.json")}
    return table_by_owner(OF_RECORDINGS[name], rows_of_recordings(judged, {}, contacts, {})[name])


def gated(results: Path, name: str, recording: str) -> pd.DataFrame:
    """The rows of the estimates with odds of contact; published ones raise false alarms, too."""
    rows = table(results, name, recording)
    return rows[rows["estimate"].isin(GATED)]


def estimated(results: Path, recording: str) -> tuple[Forces, np.ndarray]:
    """Forces as estimated, and the true wrench (N, 6) at the same time."""
    forces = Forces.read(results / "recordings" / recording / "forces.parquet")
    truth = Truth.read(results / "truth" / f"{recording}.parquet")
    time = forces.time - forces.time[0], truth.time - truth.time[0]
    return forces, interpolated(*time, truth.wrench)


@pytest.mark.parametrize("recording", ["unloaded", "loaded"])
def test_neither_run_of_a_path_shows_a_contact(results: Path, recording: str) -> None:
    """By no gated estimate: the load is in the prediction."""
    rows, found = (gated(results, name, recording) for name in ("detection", "contacts"))
    assert "Fmap" in set(rows["estimate"])
    assert (rows["alarms"] == 0).all()
    assert (rows["time_in_alarm"] == 0).all()
    assert found.empty
    forces, _ = estimated(results, recording)
    for name in rows["estimate"]:
        force, std = forces.wrench[name][:, :3], forces.std[name][:, :3]
        assert np.abs(force).max() < 2.0
        assert (np.abs(force) <= 1.96 * std).all()


def test_a_load_that_nobody_declared_is_told(results: Path) -> None:
    row = table(results, "payload", "loaded").iloc[0]
    assert row["low"] < CARRIED["mass"] < row["high"]
    assert abs(row["mass"] / CARRIED["mass"] - 1) < 0.05
    assert row["high"] - row["low"] < 0.5
    assert (row["taken"], row["configured"]) == ("yes", 0)
    found = row[["center_of_mass_x", "center_of_mass_y", "center_of_mass_z"]].to_numpy(float)
    assert np.abs(found - CARRIED["center_of_mass"]).max() < 0.03


@pytest.mark.parametrize("recording", ["fit_1", "fit_2", "fit_3", "unloaded", "grasping"])
def test_where_there_is_no_load_none_is_taken(results: Path, recording: str) -> None:
    """One that is grasped in mid-run is not there all along."""
    row = table(results, "payload", recording).iloc[0]
    assert row["taken"] == "no"
    if recording != "grasping":
        assert row["low"] < 0 < row["high"] < 0.2


def test_what_is_grasped_in_mid_run_is_named_a_load(results: Path) -> None:
    rows = table(results, "contacts", "grasping")
    # the third is false: 6 N for a third of a second, near the end of the motion
    push, load, *others = (row for _, row in rows[rows["estimate"] == "Fmap"].iterrows())
    assert all(row["end_s"] - row["start_s"] < 0.5 for row in others)
    assert len(others) <= 1
    assert (push["kind"], load["kind"]) == ("contact", "load")
    assert abs(load["load_mass"] / LOAD["mass"] - 1) < 0.1
    assert abs(load["load_mass"] - LOAD["mass"]) < 1.96 * load["load_mass_std"]
    assert abs(load["start_s"] - LOAD["start_s"]) < 0.4
    assert abs(load["end_s"] - LOAD["start_s"] - LOAD["seconds"]) < 0.4
    assert np.isnan(push["load_mass"])
    assert abs(push["peak_s"] - 4.0) < 0.3


def test_the_load_does_not_spoil_the_forces(results: Path) -> None:
    """Push and weight come back, and between and after them hardly anything is left."""
    forces, truth = estimated(results, "grasping")
    wrench, std = forces.wrench["Fmap"][:, :3], forces.std["Fmap"][:, :3]
    off, time = np.abs(wrench - truth[:, :3]), forces.time - forces.time[0]
    touched = np.linalg.norm(truth[:, :3], axis=1) > 5
    assert (off[touched] <= 1.96 * std[touched]).mean() > 0.9
    apart = touched & (time < 6), touched & (time > 8.5) & (time < 15.5)
    for rows, axis, size in zip(apart, (1, 2), (40.0, 19.6), strict=True):
        assert np.abs(truth[rows, axis]).max() > 0.9 * size
        assert off[rows].mean() < 0.15 * size
    free = ((time > 6) & (time < 7.5)) | (time > 16.5)
    assert off[free].max() < 7.0
    assert np.quantile(off[free], 0.9) < 2.0


def test_nothing_but_the_study_says_so(results: Path) -> None:
    """The truth about the load is in no file that a step reads."""
    for name in ("loaded", "grasping"):
        premises = read_record(Premises, results / "recordings" / name / "premises.json")
        assert premises.load.payload is None
