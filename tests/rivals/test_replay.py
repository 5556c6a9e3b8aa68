"""A model of the arm, replayed along motions."""

from pathlib import Path

import numpy as np
import pytest

from tests.command import Command
from tests.commands.test_exported import GRAVITY, motion
from tests.conftest import Workflow
from tests.robots.test_from_urdf import made_up, saved
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.records.motion import Motion
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.exports import urdf
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.mjcf import mjcf
from ur5rivals.replay import SERVO_RANGE, deviation, inverse_dynamics, read_model


def test_shapes_of_a_urdf_may_lie_elsewhere(tmp_path: Path) -> None:
    """Files of meshes belong to another package: they change no torque."""
    robot = robot_from_urdf(saved(made_up(3), tmp_path))[0].mounted(GRAVITY)
    text, states = urdf(robot, rigid_bodies(robot, "maker")), motion(3)
    shapes = "".join(
        f'<{tag}><geometry><mesh filename="package://nowhere/link.stl"/></geometry></{tag}>'
        for tag in ("visual", "collision")
    )
    (tmp_path / "shaped.urdf").write_text(text.replace("</inertial>", f"</inertial>{shapes}"))
    expected = LinkModel(robot, "maker").inverse_dynamics(states.q, states.qd, states.qdd)
    found = inverse_dynamics(read_model(tmp_path / "shaped.urdf", GRAVITY, 3), states)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-3)
    with pytest.raises(InputError, match="3 degrees of freedom instead of 6"):
        read_model(tmp_path / "shaped.urdf", GRAVITY, 6)
    with pytest.raises(InputError, match="cannot be read by MuJoCo"):
        read_model(tmp_path / "nothing.urdf", GRAVITY, 3)


def test_a_right_model_stays_on_the_motion_and_a_wrong_torque_pulls_it_off(tmp_path: Path) -> None:
    """By that torque over the servo's stiffness. After a gap, it starts on the motion again."""
    robot, wrong = load_robot(robot_path("ur5e")), np.array([5.0, -5, 2, 1, -1, 0.5])
    (tmp_path / "arm.xml").write_text(mjcf(robot, "maker+rotors", None))
    model = read_model(tmp_path / "arm.xml", GRAVITY, 6)
    swung, torque_max = swing(seconds=4, period=0.008), np.array(robot.torque_limits())
    torque = inverse_dynamics(model, swung)
    followed = deviation(model, swung, torque, torque_max, 0.008)
    assert np.abs(followed).max() < np.radians(0.005)
    pulled = deviation(model, swung, torque + wrong, torque_max, 0.008)
    np.testing.assert_allclose(pulled[-1], wrong * SERVO_RANGE / torque_max, rtol=0.05)
    torque[200] = np.nan
    pulled = deviation(model, swung, torque + wrong, torque_max, 0.008)
    assert np.isnan(pulled[200]).all()
    assert (pulled[[0, 201]] == 0).all()


def swing(seconds: float, period: float) -> Motion:
    """All joints, by a radian at most, at 0.3 Hz."""
    time = np.arange(0, seconds, period)
    w, phase = 0.6 * np.pi, np.arange(6)
    angle = w * time[:, None] + phase
    known = {"q": np.sin(angle), "qd": w * np.cos(angle), "qdd": -(w**2) * np.sin(angle)}
    std = dict.fromkeys(["q_std", "qd_std", "qdd_std"], 0 * angle)
    segment = np.zeros(len(time), dtype=np.int64)
    return Motion(time=time, segment=segment, motor_qd=known["qd"], **known, **std)


def test_what_is_no_model_is_reported(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text("<robot")
    with pytest.raises(InputError, match="cannot be read by MuJoCo"):
        read_model(tmp_path / "arm.xml", GRAVITY, 6)


def test_the_identified_arm_is_replayed_in_mujoco(
    demo: Workflow, run_ur5: Command, tmp_path: Path
) -> None:
    """Closer to the currents than the maker's model, on a recording that it was not fitted to."""
    results, name = demo.folder / "results" / "demo", "way_points"
    options = ["--robot", "ur5", "--format", "mjcf", "--results", results]
    (tmp_path / "arm.xml").write_text(run_ur5("export", *options, "--as-in", name).out)
    told = run_ur5("replay", tmp_path / "arm.xml", results, name).out
    rows = [(line[:40].strip(), line[40:].split()) for line in told.splitlines()]
    assert rows[0] == ("torque error [Nm], joint", [*"123456"])
    assert rows[5] == ("error in closed loop [deg], joint", [*"123456"])
    for (_, ours), (label, maker) in (rows[1:3], rows[6:8]):
        assert label == "maker's model (C)"
        assert all(float(x) < 0.5 * float(y) for x, y in zip(ours, maker, strict=True))
    torque, predicted = ([float(value) for value in rows[k][1]] for k in (1, 3))
    assert sum(torque) < 2 * sum(predicted)  # which knows more terms of friction
