"""`ur5 leaderboard` on what is no study that estimators can be compared on.

tests/workflow/test_lab.py and tests/artefacts/test_demo.py compare them on a built one.
"""

from pathlib import Path

import numpy as np
import pytest

from tests.command import Command
from tests.rivals.synthetic_run import synthetic_run
from ur5lib.force.external_torque import JointState
from ur5lib.force.residual_model import ResidualModel
from ur5lib.records.friction import Friction
from ur5lib.robots.description import Robot, robot_yaml
from ur5lib.tables import write_json
from ur5rivals.force import force

POSTURES = """\
study: mine
title: Mine
recordings:
  - name: postures
    robot: {{arm: ur5, name: left}}
    role: fit
    format: table-csv
    folder: {folder}
    file: postures.csv
    columns: [actual_q, actual_current]
    still: true
"""


@pytest.fixture
def study(tmp_path: Path, ur5: Robot) -> Path:
    """A study of an arm without any recording that tells a force."""
    parameters = tmp_path / "mine" / "parameters" / "left"
    parameters.mkdir(parents=True)
    (parameters / "arm.yaml").write_text(robot_yaml(ur5))
    write_json(Friction(), str(parameters / "friction.json"))
    (tmp_path / "mine" / "recordings").mkdir()
    (tmp_path / "mine" / "configuration.yaml").write_text(POSTURES.format(folder=tmp_path))
    return tmp_path / "mine"


def test_a_study_that_is_not_built_is_told(tmp_path: Path, run_ur5: Command) -> None:
    answer = run_ur5("leaderboard", tmp_path)
    assert answer.status == 1
    assert answer.err == f"ur5: {tmp_path} is not built; `ur5 run` its study, or name another\n"


def test_a_name_that_no_file_can_have_is_told_in_a_sentence(
    run_ur5: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = run_ur5("leaderboard", name := 300 * "a")
    assert answer.status == 1
    assert answer.err.startswith(f"ur5: {name}")
    assert answer.err.count("\n") == 1


def test_a_study_without_contacts_is_told(study: Path, run_ur5: Command) -> None:
    answer = run_ur5("leaderboard", study)
    assert answer.status == 1
    assert "has recordings with currents of the role `fit`, and others of" in answer.err


def test_an_estimator_that_is_none_is_told(study: Path, run_ur5: Command) -> None:
    answer = run_ur5("leaderboard", study, "--estimator", "math:pie")
    assert answer.status == 1
    assert answer.err == "ur5: math:pie is not there (did you mean `pi`?); correct the name\n"


def test_a_force_is_that_of_whitened_least_squares_and_its_band_is_how_it_scatters() -> None:
    """Of the torque over its spread, which differs by joint; all else alike, in any unit."""
    run = synthetic_run(1, noise=1.0)
    spread = np.tile([4.0, 2.0, 1.0, 0.5, 0.3, 0.2], (len(JointState), 1))
    noise = ResidualModel(spread, spread, np.ones(len(JointState)), 1.0, np.ones(6))
    torque = run.torque * spread[0]
    found = force(run, torque, noise)
    assert found.std is not None
    whitened = run.jacobian[0, :3].T / spread[0][:, None]
    expected = np.linalg.lstsq(whitened, (torque / spread[0]).T, rcond=None)[0].T
    np.testing.assert_allclose(found.wrench[:, :3], expected, atol=1e-9)
    assert not found.wrench[:, 3:].any()
    scatter = found.wrench[:, :3].std(axis=0)
    np.testing.assert_allclose(found.std[0, :3], scatter, rtol=0.1)
    np.testing.assert_allclose(
        force(run, 3 * torque, noise.wider(3)).std, 3 * found.std, rtol=1e-9, atol=1e-12
    )
