"""An arm as MuJoCo reads it, replayed along motions."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.pipeline.records.motion import Motion
from ur5lib.robots.description import Payload, Robot, load_robot, robot_path
from ur5lib.robots.mjcf import JointFriction, mjcf
from ur5lib.study.exported import exported
from ur5lib.study.replay import inverse_dynamics
from ur5lib.timeseries.arrays import Array

RANDOM = np.random.default_rng(3)
STATES = RANDOM.uniform(-1.5, 1.5, (3, 40, 6))
FRICTION = JointFriction(np.arange(1.0, 7.0), np.linspace(0.5, 3, 6))
GRAVITY = np.array([1.0, -2.0, 9.0])


def motion() -> Motion:
    q, qd, qdd = STATES
    time, std = 0.008 * np.arange(40), 0 * q
    known = {"q": q, "qd": qd, "qdd": qdd, "q_std": std, "qd_std": std, "qdd_std": std}
    return Motion(time=time, segment=np.zeros(40, dtype=np.int64), **known)


def replayed(robot: Robot, friction: JointFriction | None, folder: Path) -> Array:
    file = folder / "arm.xml"
    file.write_text(mjcf(robot, f"{robot.chosen_model}+rotors", friction))
    return inverse_dynamics(file, motion(), GRAVITY)


@pytest.mark.parametrize("name", ["ur5e", "ur10e", "ur20"])
def test_its_torques_are_this_project_s(name: str, tmp_path: Path) -> None:
    robot = load_robot(robot_path(name)).mounted(GRAVITY)
    robot = robot.carrying(Payload(mass=1.5, center_of_mass=(0.02, 0.0, 0.1)))
    expected = LinkModel(robot, f"{robot.chosen_model}+rotors").inverse_dynamics(*STATES)
    np.testing.assert_allclose(replayed(robot, None, tmp_path), expected, rtol=1e-4, atol=1e-3)


def test_its_friction_is_coulomb_and_viscous(tmp_path: Path) -> None:
    robot = load_robot(robot_path("ur5e")).mounted(GRAVITY)
    qd = STATES[1]
    added = replayed(robot, FRICTION, tmp_path) - replayed(robot, None, tmp_path)
    expected = FRICTION.coulomb * np.sign(qd) + FRICTION.viscous * qd
    moving = np.abs(qd) > 0.1  # at lower speeds, MuJoCo's dry friction gives way
    np.testing.assert_allclose(added[moving], expected[moving], atol=1e-3)


def test_limits_are_those_of_the_joints() -> None:
    robot = load_robot(robot_path("ur5e"))
    model = mujoco.MjModel.from_xml_string(mjcf(robot, "maker", None))
    np.testing.assert_allclose(model.jnt_range[:, 1], robot.position_limits(), rtol=1e-5)
    most = [robot.motor(joint).torque_max for joint in range(1, 7)]
    np.testing.assert_allclose(model.actuator_ctrlrange[:, 1], most)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"to": "sdf"}, "available: urdf, mjcf"),
        ({"robot": "ur6"}, "no description"),
        ({"model": "Z"}, "no link model 'Z'"),
        ({"as_in": "pushed"}, "--results"),
        ({"results": Path("nowhere")}, "run snakemake"),
    ],
)
def test_what_is_not_there_is_told(changed: dict[str, object], message: str) -> None:
    asked = {"robot": "ur5", "model": None, "to": "mjcf", "results": None, "as_in": ""}
    with pytest.raises(InputError, match=message):
        exported(**asked | changed)  # type: ignore[arg-type]


def test_what_is_no_model_is_told(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text("<robot")
    with pytest.raises(InputError, match="cannot be read by MuJoCo"):
        inverse_dynamics(tmp_path / "arm.xml", motion(), GRAVITY)
