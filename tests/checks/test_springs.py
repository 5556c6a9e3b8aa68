"""A spring that holds the tool of a simulated arm is told from a wrong column or sign."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.harness.right_logs import MED, of_seven, on_the_stand
from ur5lib.checks.checked import Checked
from ur5lib.checks.findings import contradictions
from ur5lib.checks.springs import spring_on_tool
from ur5lib.recordings.entries import RtdeFiles
from ur5lib.recordings.intake import read_and_repair
from ur5lib.records.codes import Found
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import POSTURE, SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.tables import channel, named


@pytest.mark.slow
def test_a_spring_is_named_before_a_wrong_sign(ur5: Robot, tmp_path: Path) -> None:
    """Without the role contact, it is a stop sign."""
    posture = POSTURE + np.random.default_rng(0).uniform(-0.4, 0.4, 6)
    about = {"kind": "fourier", "draw": 10, "period_s": 20, "harmonics": 10}
    spring = {"kind": "spring", "start_s": 0.0, "seconds": 20.0, "stiffness_n_m": 300.0}
    plan = SimulatedRecording.model_validate(
        {
            "trajectory": about | {"posture": posture.tolist()},
            "root_friction": True,
            "varied_friction": True,
            "contacts": [spring | {"point": [0.0, 0.0, 0.1]}],
        }
    )
    simulate(ur5, plan, "rtde-csv", tmp_path, tmp_path / "truth")
    entry = RtdeFiles(format="rtde-csv", folder=str(tmp_path), file="robot.csv")
    table = read_and_repair(entry, ur5, 0.1).robot
    touched = Checked(table, ur5, None, None, fitted=False, cutoff=2.0, touched=True)
    found = contradictions(touched, [], False, {"currents": 2.0}, {})
    assert found.stop_signs == []
    (first,) = (one for one in found.findings if one.code == Found.CONTACT)
    assert "pulls on the tool throughout" in first.detail
    other = contradictions(replace(touched, touched=False), [], False, {"currents": 2.0}, {})
    assert other.stop_signs


@pytest.mark.slow
def test_torques_of_the_opposite_sign_are_no_spring(tmp_path: Path) -> None:
    """A spring and twice the arm's weight pull alike, along a path of an arm of seven joints."""
    own = on_the_stand(of_seven("seven", *MED), 2, tmp_path)
    torque = channel(own.robot, "actual_torque")
    turned = replace(own, robot=own.robot.assign(**named(-torque, "actual_torque")))
    for one in (own, turned):
        assert one.motion is not None
        assert not spring_on_tool(one.motion.motion).is_shown()
