"""The thesis's contact wrenches, as printed and by the corrected equations."""

from collections.abc import Iterator
from typing import Any, Protocol

from ur5lib.force.controller import controller_estimate, environment_on_arm
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import FurtherForces
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, causal_lowpass, zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment
from ur5lib.topics.thesis.current_based import (
    PUBLISHED_JACOBIAN_LAG,
    delay,
    friction_torque,
    motor_torque,
    motor_torque_as_published,
    wrench_from_torque,
)


class Moved(Protocol):
    """What the thesis estimates forces from."""

    signals: Signals
    motion: Motion
    torques: Torques
    kinematics: Kinematics


def published_forces(
    recording: Moved, robot: Robot, design: Butterworth, min_singular_value: float
) -> FurtherForces:
    """Return F^u, F and F*: as the published script computes them (errata 5, 6 and 13), and by the
    printed equations with the measured motion and without delay.

    design: low-pass of the external torque; min_singular_value: least one of a usable Jacobian.
    """
    signals, torques = recording.signals, recording.torques
    jacobian = recording.kinematics.jacobian  # J_g

    def wrenches(external: Array, friction: Array, J: Array, lowpass: Any) -> Iterator[Array]:
        for torque in (external, external - friction):  # Equations 6.8 (F) and 6.9 (F*)
            smooth = by_segment(lowpass, torque, signals.segment, 1 / signals.period, *design)
            yield environment_on_arm(wrench_from_torque(J, smooth, min_singular_value))

    constants, friction = robot.current_to_torque, robot.friction
    current, qd, model = signals.actual_current, signals.target_qd, robot.chosen_model
    printed, corrected = controller_estimate(robot, signals), controller_estimate(robot, signals)
    if constants and friction and current is not None:
        if qd is not None and model in torques.target:
            external = motor_torque_as_published(current, constants) - torques.target[model]
            delayed = delay(jacobian, round(PUBLISHED_JACOBIAN_LAG / signals.period))
            found = wrenches(external, friction_torque(qd, friction), delayed, causal_lowpass)
            printed |= zip(("F", "F*"), found, strict=True)
        external = motor_torque(current, constants) - torques.measured[model]
        resisted = friction_torque(recording.motion.motor_qd, friction)
        found = wrenches(external, resisted, jacobian, zero_phase_lowpass)
        corrected |= zip(("F", "F*"), found, strict=True)
    return FurtherForces(
        time=signals.time,
        segment=signals.segment,
        printed=printed,
        corrected=corrected,
    )
