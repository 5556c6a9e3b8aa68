"""Friction that hides gravity, of a right recording, contradicts nothing."""

from pathlib import Path

import pytest

from ur5lib.checks.checked import Checked
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.recordings.entries import RtdeFiles
from ur5lib.recordings.intake import read_and_repair
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate


@pytest.mark.slow
def test_three_times_the_friction_exchanges_no_currents(tmp_path: Path) -> None:
    """Friction hides gravity there: the links explain two currents better exchanged, and these
    answer to their own joints.
    """
    ways = [[0.67, -1.42, 1.68, -1.76, 1.24, 0.27], [0.16, -1.50, 1.61, -1.80, 1.28, 0.18]]
    ways += [[0.51, -1.34, 1.73, -1.53, 1.21, 0.28], [0.18, -1.51, 1.91, -1.34, 1.33, -0.04]]
    plan = SimulatedRecording.model_validate(
        {
            "trajectory": {"kind": "movej", "way_points": ways, "pause_s": 1.0},
            "seconds": 12.0,
            "coulomb_factor": [3.0] * 6,
            "viscous_factor": [3.0] * 6,
            "seed": 2,
            "varied_friction": True,
        }
    )
    arm = load_robot(robot_path("ur5e"))
    simulate(arm, plan, "rtde-csv", tmp_path, tmp_path / "truth")
    own = RtdeFiles(format="rtde-csv", folder=str(tmp_path), file="robot.csv")
    right = Checked(read_and_repair(own, arm, 0.1).robot, arm, None, None, fitted=True, cutoff=2.0)
    assert right.motion is not None
    assert [one.finding.joints for one in right.motion.exchanges_of_efforts()] == [(2, 5)]
    assert stop_signs(right) == []
