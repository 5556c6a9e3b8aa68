"""How controllers count: a motor does the work of the joints that it moves."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pydantic import ValidationError

from ur5lib.identification.current_samples import shafts_of
from ur5lib.recordings.counting import at_the_joints
from ur5lib.robots.description import CoupledMotor, Drives, Robot
from ur5lib.robots.drives import as_counted, of_the_joints, shaft_matrix


@pytest.fixture
def arm(ur5: Robot) -> Robot:
    """Motors' counts of gears of 32 to 50, two joints reversed, motor 6 turned by joint 5, too."""
    ratios = dict(zip(ur5.joint_numbers, (32.0, 32.0, 45.0, 48.0, 45.0, 50.0), strict=True))
    motors = {
        f"motor{k}": ur5.motor(k).model_copy(update={"gear_ratio": ratios[k]}) for k in ratios
    }
    drives = Drives(
        positions="motor",
        directions=(1, -1, 1, -1, 1, 1),
        home_deg=(0, -90, 90, 0, 0, 10),
        coupling=[CoupledMotor(motor=6, joint=5)],
    )
    return ur5.model_copy(
        update={"joints": (*motors,), "motors": motors, "drives": drives, "effort": "motor_torque"}
    )


def test_motors_do_the_work_of_the_joints(arm: Robot) -> None:
    """θ̇ᵀ τ_motor = q̇ᵀ τ."""
    rates, torques = np.random.default_rng(0).normal(size=(2, 50, 6))
    motor_rates = as_counted("actual_qd", rates, arm)
    motor_torques = as_counted("actual_torque", torques, arm)
    power = (motor_rates * motor_torques).sum(axis=1)
    np.testing.assert_allclose(power, (rates * torques).sum(axis=1))
    # and motor 6 with its gear of 50 turns with joints 5 and 6
    np.testing.assert_allclose(motor_rates[:, 5], 50 * (rates[:, 4] + rates[:, 5]))
    np.testing.assert_allclose(motor_rates[:, 5] / 50, (rates @ shaft_matrix(arm).T)[:, 5])


@pytest.mark.parametrize("name", ["actual_q", "target_qd", "actual_torque", "actual_current"])
def test_counts_are_told_back(arm: Robot, name: str) -> None:
    values = np.random.default_rng(1).normal(size=(20, 6))
    np.testing.assert_allclose(of_the_joints(name, as_counted(name, values, arm), arm), values)


def test_positions_are_those_of_the_description(arm: Robot) -> None:
    np.testing.assert_allclose(
        np.degrees(of_the_joints("actual_q", np.zeros((1, 6)), arm))[0], arm.drives.home_deg
    )


def test_a_channel_that_lacks_a_joint_stays_as_it_is(arm: Robot) -> None:
    """What then is said of it is said of the log, not of how it is counted."""
    table = pd.DataFrame(np.ones((3, 5)), columns=[f"target_qd_{joint}" for joint in range(5)])
    pd.testing.assert_frame_equal(at_the_joints(table, arm), table)


def test_each_joint_of_a_coupled_wrist_has_the_shaft_that_turns_with_it(arm: Robot) -> None:
    """Its own motor's, else that of the motor that turns most with it; other joints have none."""
    pairs = ((5, 4, 0.8), (6, 4, 0.5), (6, 5, -1.2))
    coupling = [CoupledMotor(motor=m, joint=j, ratio=ratio) for m, j, ratio in pairs]
    wrist = arm.model_copy(update={"drives": Drives(coupling=coupling)})
    rates = np.random.default_rng(2).normal(size=(20, 6))
    motion: Any = SimpleNamespace(q=rates, motor_qd=rates, qdd=rates)
    shafts = shafts_of(wrist, motion)
    assert shafts is not None
    turned = rates @ shaft_matrix(wrist).T
    np.testing.assert_allclose(shafts.qd[:, 3:], turned[:, [4, 4, 5]])
    assert np.isnan(shafts.qd[:, :3]).all()


def test_measured_torques_of_the_joints_are_no_currents_of_geared_motors(arm: Robot) -> None:
    """Whether the motors' gears are told, as of counted positions, or not."""
    sensed = arm.model_copy(update={"drives": Drives(positions="motor"), "effort": "torque"})
    assert sensed.maker_torque_constants() == [1.0] * 6
    of_motors = sensed.model_copy(update={"effort": "current"})
    assert min(of_motors.maker_torque_constants()) > 1


def test_a_coupling_is_of_two_joints_of_the_arm(ur5: Robot) -> None:
    with pytest.raises(ValidationError):
        CoupledMotor(motor=6, joint=6)
    data = ur5.model_dump() | {"drives": {"coupling": [{"motor": 7, "joint": 5}]}}
    with pytest.raises(ValidationError):
        Robot.model_validate(data)
