"""The thesis's contact wrenches, as it printed them, and by its equations put right."""

from functools import partial
from typing import Any, NamedTuple

import numpy as np

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
    """Return F^u, F and F*; jacobian: J_g (N, 6, 6)."""
    printed = as_printed(robot, signals, torques, jacobian, settings)
    right = corrected(robot, signals, motion, torques, jacobian, settings)
    return PublishedForces(
        time=signals.time,
        segment=signals.segment,
        printed={name: environment_on_arm(wrench) for name, wrench in printed.items()},
        corrected={name: environment_on_arm(wrench) for name, wrench in right.items()},
    )


def as_printed(
    robot: Robot, signals: Signals, torques: Torques, jacobian: Array, settings: Settings
) -> dict[str, Array]:
    """Return F^u, F and F* the way the published script makes them (errata 5, 6 and 13)."""
    constants, friction = robot.current_to_torque, robot.friction
    modelled = torques.target.get(robot.chosen_model)
    current, qd = signals.actual_current, signals.target_qd
    estimates = controller_estimate(robot, signals)
    if constants and friction and modelled is not None and current is not None:
        assert qd is not None  # of which `modelled` is
        external = motor_torque_as_published(current, constants) - modelled
        delayed = delay(jacobian, round(PUBLISHED_JACOBIAN_LAG / signals.period))
        resisted = friction_torque(qd, friction)
        estimates |= wrenches(signals, external, resisted, delayed, causal_lowpass, settings)
    return estimates


def corrected(
    robot: Robot,
    signals: Signals,
    motion: Motion,
    torques: Torques,
    jacobian: Array,
    settings: Settings,
) -> dict[str, Array]:
    """Return F^u, F and F* by the printed equations, at the measured motion, without delay."""
    constants, friction = robot.current_to_torque, robot.friction
    estimates = controller_estimate(robot, signals)
    if constants and friction and signals.actual_current is not None:
        modelled = torques.measured[robot.chosen_model]
        external = motor_torque(signals.actual_current, constants) - modelled
        resisted = friction_torque(motion.motor_qd, friction)
        estimates |= wrenches(signals, external, resisted, jacobian, zero_phase_lowpass, settings)
    return estimates


def controller_estimate(robot: Robot, signals: Signals) -> dict[str, Array]:
    """Return the controller's own F^u, the arm acting on its environment, where it was recorded.

    With a wrist sensor, the controller states the environment acting on the arm.
    """
    if signals.actual_TCP_force is None:
        return {}
    return {"Fu": (-1 if robot.wrist_sensor else 1) * signals.actual_TCP_force}


def wrenches(
    signals: Signals,
    external: Array,
    friction: Array,
    jacobian: Array,
    lowpass: Any,
    settings: Settings,
) -> dict[str, Array]:
    """Return Equations 6.8 (F) and 6.9 (F*) of low-passed torques (N, 6) [Nm]."""
    run = partial(lowpass, rate=1 / signals.period, **settings.design._asdict())
    estimates: dict[str, np.ndarray] = {}
    for name, torque in {"F": external, "F*": external - friction}.items():
        smooth = by_segment(run, torque, signals.segment)
        estimates[name] = wrench_from_torque(jacobian, smooth, settings.min_singular_value)
    return estimates
