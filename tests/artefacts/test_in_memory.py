"""What is fitted in memory to real recordings is what the report of their study states."""

from pathlib import Path

import pytest

import ur5lib
from tests.conftest import build_once
from tests.in_memory import assert_as_in_study

pytestmark = pytest.mark.thorough


def test_the_thesis(thesis_results: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(thesis_results.parents[1])
    touched = "Movement_No9_Singularity_Free_ForceSensor"
    runs = ur5lib.read("workflow/studies/thesis.yaml")
    assert_as_in_study(runs, ur5lib.fit(runs), thesis_results, touched)


def test_a_ur10e(ur10e_data: Path, common_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def prepare(folder: Path) -> None:
        (folder / "raw").mkdir()
        (folder / "raw" / "ur10e").symlink_to(ur10e_data)

    study = "workflow/studies/ur10e.yaml"
    built = build_once(common_folder / "ur10e_built", prepare, "--configfile", study)
    monkeypatch.chdir(built.folder)
    runs = ur5lib.read(study)
    assert_as_in_study(runs, ur5lib.fit(runs), Path("results/ur10e"), "ur-20_01_22-push_pose_1")
