"""FIGAROH's optimal trajectory for the arm of a URDF, as CSV for `excitation.py --other`.

It runs in an environment of its own. Debian has what its optimiser needs: `apt install
coinor-libipopt-dev gfortran liblapack-dev libblas-dev libmumps-seq-dev`; then

    pip install figaroh==1.0.2 cyipopt
    ur5 export --robot ur5 > ur5.urdf
    python optimal_trajectory.py ur5.urdf figaroh.csv

Of the URDF's limits, the shares are used that `ur5 excite` keeps. FIGAROH knows no limits of
acceleration, jerk or singularity, and without collision bodies in the URDF none of collisions.
"""

import argparse
import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import yaml
from figaroh.optimal.base_optimal_trajectory import (
    BaseOptimalTrajectory,
    BaseTrajectoryIPOPTProblem,
)
from figaroh.tools.robot import load_robot
from scipy.interpolate import CubicSpline

SHARES = {"lower": 0.95, "upper": 0.95, "velocity": 0.5, "effort": 0.8}  # as ur5 excite's
JOINTS = [f"joint_{k}" for k in range(1, 7)]
WAY_POINTS, SPACING, SEGMENTS = 6, 2.0, 2  # 2 segments of 5 intervals of 2 s: 20 s
RATE = 20  # Hz, as in FIGAROH's example of a UR10
ITERATIONS = 100  # of Ipopt in each segment, as there


class Trajectory(BaseOptimalTrajectory):
    """FIGAROH's problem as it is."""

    def create_ipopt_problem(self, *given):
        """Return the problem of one segment."""
        return BaseTrajectoryIPOPTProblem(self, *given)


def main() -> None:
    """Write the trajectory: time [s] and six angles [rad] a line; or judge those of others."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("urdf", type=Path, help="what ur5 export writes")
    options.add_argument("csv", type=Path, nargs="+", help="file to write, or those to judge")
    options.add_argument("--judge", action="store_true", help="condition numbers of trajectories")
    options.add_argument("--seed", type=int, default=0, help="of the first way-points")
    options.add_argument("--iterations", type=int, default=ITERATIONS, help="of Ipopt")
    given = options.parse_args()
    np.random.seed(given.seed)  # noqa: NPY002 - what FIGAROH draws from
    with tempfile.TemporaryDirectory() as folder:
        own = problem_of(given.urdf, Path(folder), given.iterations)
        if given.judge:
            return judge(own, given.csv)
        found = own.solve(stack_reps=SEGMENTS)
    length = SPACING * (WAY_POINTS - 1)  # FIGAROH starts the clock of each segment anew
    time = [length * k + np.ravel(t) - t[0, 0] for k, t in enumerate(found["T_F"])]
    rows = np.column_stack([np.concatenate(time), np.vstack(found["P_F"])])
    fresh = np.append(True, np.diff(rows[:, 0]) > 0)  # segments share a way-point
    np.savetxt(given.csv[0], rows[fresh], delimiter=",", fmt="%.8f")
    judge(own, given.csv)


def judge(own: Trajectory, files: list[Path]) -> None:
    """Print the condition numbers of FIGAROH's regressor along trajectories."""
    for path in files:
        clock, *angles = np.loadtxt(path, delimiter=",").T
        at = np.arange(clock[0], clock[-1], 1 / RATE)
        q = CubicSpline(clock, np.column_stack(angles))
        W = own._stack_base_regressors(q(at), q(at, 1), q(at, 2))
        print(f"{path}: {clock[-1]:g} s, condition number {np.linalg.cond(W):.1f} of {W.shape[1]}")


def problem_of(urdf: Path, folder: Path, iterations: int) -> Trajectory:
    """Return FIGAROH's problem under our limits; folder: for its files."""
    limited, settings = folder / "arm.urdf", folder / "arm.yaml"
    tree = ElementTree.parse(urdf)
    for limit in tree.iter("limit"):
        for name, share in SHARES.items():
            limit.set(name, str(share * float(limit.get(name))))
    tree.write(limited)
    settings.write_text(yaml.safe_dump(configuration(iterations)))
    robot = load_robot(str(limited), package_dirs=str(folder), load_by_urdf=True)
    own = Trajectory(robot, JOINTS, str(settings))
    joints = [robot.model.joints[robot.model.getJointId(name)] for name in JOINTS]
    own.identif_config |= {
        "active_joints": JOINTS,
        "act_Jid": [robot.model.getJointId(name) for name in JOINTS],
        "act_J": joints,
        "act_idxq": [joint.idx_q for joint in joints],
        "act_idxv": [joint.idx_v for joint in joints],
    }
    own.initialize()
    return own


def configuration(iterations: int) -> dict:
    """Return FIGAROH's configuration: inertial parameters and rotors, as in the target torques."""
    parts = {"friction": False, "joint_offset": False, "actuator_inertia": True}
    return {
        "robot": {
            "name": "arm",
            "properties": {"joints": {"active_joints": JOINTS}, "mechanics": {}},
        },
        "tasks": {
            "identification": {"enabled": True, "problem": {"model_components": parts}},
            "optimal_trajectory": {
                "enabled": True,
                "problem": {"soft_lim": 0.0, "max_iterations": iterations, "segment_attempts": 5},
                "trajectory": {
                    "waypoints": WAY_POINTS,
                    "frequency": RATE,
                    "segment_duration": SPACING,
                },
            },
        },
    }


if __name__ == "__main__":
    main()
