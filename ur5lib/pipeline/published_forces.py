"""The thesis's contact wrenches, as it printed them, and by its equations put right."""

from functools import partial
from typing import Any, NamedTuple

from ur5lib.force.current_based import (
    PUBLISHED_JACOBIAN_LAG,
    delay,
    environment_on_arm,
    friction_torque,
    motor_torque,
    motor_torque_as_published,
    wrench_from_torque,
)
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.forces import PublishedForces
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, causal_lowpass, zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment


class Settings(NamedTuple):
    """Low-pass of the external torque, and the least singular value of a usable Jacobian."""

    design: Butterworth
    min_singular_value: float


def published_forces(
    robot: Robot,
    signals: Signals,
    motion: Motion,
    torques: Torques,
    jacobian: Array,
    settings: Settings,
) -> PublishedForces:
    """Return F^u, F and F*: as the published script makes them (errata 5, 6 and 13), and by the
    printed equations, at the measured motion, without delay.

    jacobian: J_g (N, 6, 6).
    """
    constants, friction = robot.current_to_torque, robot.friction
    current, qd, model = signals.actual_current, signals.target_qd, robot.chosen_model
    printed, corrected = controller_estimate(robot, signals), controller_estimate(robot, signals)
    if constants and friction and current is not None:
        wrenches = partial(_wrenches, signals, settings)
        if qd is not None and model in torques.target:
            external = motor_torque_as_published(current, constants) - torques.target[model]
            delayed = delay(jacobian, round(PUBLISHED_JACOBIAN_LAG / signals.period))
            printed |= wrenches(external, friction_torque(qd, friction), delayed, causal_lowpass)
        external = motor_torque(current, constants) - torques.measured[model]
        resisted = friction_torque(motion.motor_qd, friction)
        corrected |= wrenches(external, resisted, jacobian, zero_phase_lowpass)
    return PublishedForces(
        time=signals.time,
        segment=signals.segment,
        printed=printed,
        corrected=corrected,
    )


def controller_estimate(robot: Robot, signals: Signals) -> dict[str, Array]:
    """Return the controller's own F^u, the environment acting on the arm, where it was recorded.

    Without a wrist sensor, the controller states the arm acting on its environment.
    """
    if signals.actual_TCP_force is None:
        return {}
    stated = signals.actual_TCP_force
    return {"Fu": stated if robot.wrist_sensor else environment_on_arm(stated)}


def _wrenches(
    signals: Signals,
    settings: Settings,
    external: Array,
    friction: Array,
    jacobian: Array,
    lowpass: Any,
) -> dict[str, Array]:
    """Return Equations 6.8 (F) and 6.9 (F*) of low-passed torques (N, 6) [Nm]."""
    rate = 1 / signals.period
    estimates: dict[str, Array] = {}
    for name, torque in {"F": external, "F*": external - friction}.items():
        smooth = by_segment(lowpass, torque, signals.segment, rate, *settings.design)
        wrench = wrench_from_torque(jacobian, smooth, settings.min_singular_value)
        estimates[name] = environment_on_arm(wrench)
    return estimates
