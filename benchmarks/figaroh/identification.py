"""FIGAROH's identification of an arm, and the torques that it predicts along paths it has not seen.

    python -m benchmarks.current_prediction             (in the project's environment)
    pip install figaroh==1.0.2                          (in an environment of its own)
    python benchmarks/figaroh/identification.py results/figaroh/<study>_<robot>
    python -m benchmarks.current_prediction

Reads samples.npz and arm.urdf of the folder, writes predicted.npz. FIGAROH's own model and solver
are used as they are: base parameters of the links, viscous and Coulomb friction, inertia of the
actuators and an offset of each joint, fitted to decimated torques by least squares (`ols`), and
weighted by the joints' residuals (`wls`). It is given the project's smoothed motion instead of its
own filter's.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import yaml
from figaroh.data.trajectory import TrajectoryData
from figaroh.identification.base_identification import BaseIdentification
from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced
from figaroh.tools.robot import load_robot

EDGE = (
    20  # samples beside a jump from one stretch to the next, of which a decimated one may be made
)
KEYS = ("q", "qd", "qdd", "torque", "stretch")


class Identification(BaseIdentification):
    """FIGAROH's identification of samples that are smoothed and differentiated already."""

    def __init__(self, robot, settings, samples):
        super().__init__(robot, settings)
        self.samples = samples
        indices = [robot.model.getJointId(name) for name in joint_names(samples)]
        joints = [robot.model.joints[index] for index in indices]
        self.identif_config |= {
            "active_joints": joint_names(samples),
            "act_Jid": indices,
            "act_J": joints,
            "act_idxq": [joint.idx_q for joint in joints],
            "act_idxv": [joint.idx_v for joint in joints],
        }

    def load_trajectory_data(self, data_source=None):  # noqa: ARG002 - as FIGAROH calls it
        """Return the samples, masked beside jumps."""
        own = self.samples
        jumps = np.flatnonzero(np.diff(own["stretch"]))
        near = np.abs(np.arange(len(own["q"]))[:, None] - jumps).min(axis=1, initial=EDGE)
        return TrajectoryData(
            t=np.arange(len(own["q"])) * own["period"],
            joint_names=joint_names(own),
            q=own["q"],
            dq=own["qd"],
            ddq=own["qdd"],
            effort=own["torque"],
            effort_kind="joint_torque",
            effort_unit="N·m",
            mask=near >= EDGE,
        )

    def filter_kinematics_data(self, filter_config=None):  # noqa: ARG002 - as FIGAROH calls it
        """Take the motion as it is given."""
        self.processed_data = dict(self.raw_data)

    def torque(self, samples, parameters):
        """Return the torque (N, n) that base parameters predict."""
        motion = (samples[key] for key in ("q", "qd", "qdd"))
        full = build_regressor_basic(self.robot, *motion, self.identif_config)
        base = build_regressor_reduced(full, self._idx_eliminated)[:, self._base_indices]
        return (base @ parameters).reshape(samples["q"].shape[1], -1).T


def main() -> None:
    """Write the torques of all recordings, by fits without their own path."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("folder", type=Path, help="with samples.npz and arm.urdf")
    folder = options.parse_args().folder
    with np.load(folder / "samples.npz") as file:
        samples = dict(file)
    urdf = str(folder / "arm.urdf")
    robot = load_robot(urdf, package_dirs=str(folder), load_by_urdf=True)
    found = {name: np.full_like(samples["q"], np.nan) for name in ("ols", "wls")}
    for path in np.unique(samples["path"]):
        tested = samples["path"] == path
        own = identified(robot, rows(samples, samples["fitted"] & ~tested))
        weighted, _ = own._apply_weighted_least_squares()
        for name, parameters in (("ols", own.phi_base), ("wls", weighted)):
            found[name][tested] = own.torque(rows(samples, tested), parameters)
    np.savez(folder / "predicted.npz", **found)


def joint_names(samples):
    """Return the names that the URDF gives the joints."""
    return [f"joint_{k}" for k in range(1, samples["q"].shape[1] + 1)]


def rows(samples, taken):
    """Return some of the samples."""
    return {key: samples[key][taken] for key in KEYS} | {"period": samples["period"]}


def identified(robot, samples) -> Identification:
    """Return FIGAROH's identification, solved by least squares."""
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as settings:
        settings.write(yaml.safe_dump(configuration(joint_names(samples))))
        settings.flush()
        own = Identification(robot, settings.name, samples)
    own.initialize()
    own.solve(plotting=False)
    return own


def configuration(joints) -> dict:
    """Return FIGAROH's configuration with all parts of its model that an arm has."""
    parts = {"friction": True, "joint_offset": True, "actuator_inertia": True}
    return {
        "robot": {
            "name": "arm",
            "properties": {"joints": {"active_joints": joints}, "mechanics": {}},
        },
        "tasks": {"identification": {"enabled": True, "problem": {"model_components": parts}}},
    }


if __name__ == "__main__":
    main()
