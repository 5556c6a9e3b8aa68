"""The stand simulates arms of any number of joints, with torque sensors or currents."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.serial_arms import figures, with_motors
from tests.robots.test_from_urdf import made_up, planar, saved
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.recordings.entries import RtdeFiles
from ur5lib.recordings.intake import read_and_repair
from ur5lib.robots.description import Robot
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import Experiment, perform
from ur5lib.stand.simulate import simulate
from ur5lib.stand.torque_sensors import FRICTION_SHARE_BEHIND_SENSOR, TorqueSensors
from ur5lib.stand.truth import Truth
from ur5lib.study.reading import parse_study

PUSH = {"kind": "push", "start_s": 0.5, "seconds": 1.0, "force": [10, -5, 8]}


def described(count: int, folder: Path, currents: bool = False) -> Robot:
    robot, _ = robot_from_urdf(saved(planar(2) if count == 2 else made_up(count), folder))
    return with_motors(robot) if currents else robot


def plan(count: int, **keys: Any) -> SimulatedRecording:
    moving = {"kind": "fourier", "posture": [0.3] * count, "amplitude_rad": 0.3}
    return SimulatedRecording.model_validate(
        {"trajectory": moving, "seconds": 2.0, "contacts": [PUSH]} | keys
    )


def performed(robot: Robot, **keys: Any) -> Experiment:
    return perform(robot, plan(len(robot.joints), **keys), np.random.default_rng(0))


@pytest.mark.parametrize("currents", [False, True], ids=["sensors", "currents"])
@pytest.mark.parametrize("count", [2, 8])
def test_the_arm_obeys_its_equation(count: int, currents: bool, tmp_path: Path) -> None:
    """D q̈ + C q̇ + g = motor - friction + contact, by our own dynamics."""
    robot = described(count, tmp_path, currents)
    done = performed(robot)
    motion = done.motion
    model = LinkModel(robot, done.rig.model)
    torque = model.inverse_dynamics(motion["q"], motion["qd"], motion["qdd"])
    driven = motion["motor_torque"] - motion["friction_torque"] + motion["contact_torque"]
    np.testing.assert_allclose(torque, driven, atol=1e-6)
    assert np.abs(motion["contact_torque"]).max() > 0.5


@pytest.mark.parametrize("count", [2, 7])
def test_sensors_read_the_torque_of_the_links(count: int, tmp_path: Path) -> None:
    """What is read from the file: gain τ + bias, with little of the friction of the gears."""
    robot = described(count, tmp_path)
    folder = tmp_path / "raw"
    simulate(robot, plan(count, noise=False), "rtde-csv", folder, tmp_path / "truth")
    entry = RtdeFiles(format="rtde-csv", folder=str(folder), file="robot.csv")
    read = read_and_repair(entry, robot, 0.1).robot.filter(like="actual_torque_").to_numpy()
    true, sensors = Truth.read(tmp_path / "truth.parquet"), TorqueSensors.of(robot)
    felt = true.motor_torque - (1 - FRICTION_SHARE_BEHIND_SENSOR) * true.friction_torque
    np.testing.assert_allclose(read, sensors.gain * felt + sensors.bias, atol=1e-5)


@pytest.mark.parametrize(
    ("keys", "named"),
    [
        ({"trajectory": {"kind": "standstill"}}, r"posture` has 6 numbers.* 7 joints"),
        ({"coulomb_factor": [1.0, 1.0]}, r"coulomb_factor` has 2 numbers"),
        ({"contacts": [PUSH | {"link": 8}]}, r"contacts\[0\].link` is 8"),
    ],
)
def test_what_does_not_fit_the_arm_is_named(
    keys: dict[str, Any], named: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=named):
        performed(described(7, tmp_path), **keys)


def test_a_study_names_what_does_not_fit_its_arm() -> None:
    simulated = {"trajectory": {"kind": "standstill", "posture": [0.0] * 5}}
    entry = {"name": "a", "format": "rtde-csv", "role": "fit", "simulate": simulated}
    study = {"study": "s", "title": "t", "robot": "ur5", "recordings": [entry]}
    with pytest.raises(InputError, match=r"recordings.a.simulate.trajectory.posture` has 5"):
        parse_study(study, "study.yaml")


@pytest.mark.slow
@pytest.mark.thorough
def test_forces_come_back_within_their_bands(tmp_path: Path) -> None:
    found = {row["quantity"]: row["value"] for row in figures(described(7, tmp_path), 0, 20.0)}
    error, zero = found["force in contact, error [N]"], found["of an estimate of zero [N]"]
    assert error < 0.1 * zero
    assert found["force inside its band"] > 0.9
    assert found["contacts found"] == 1.0
    assert found["false alarms a minute"] <= 3.0  # one alarm in 20 s
