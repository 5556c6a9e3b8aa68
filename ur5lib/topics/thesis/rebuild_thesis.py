"""The thesis's methods: the joints in closed loop, contact wrenches, torque constants."""

from typing import NamedTuple

from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import FurtherForces
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.lowpass import Butterworth
from ur5lib.topics.thesis.closed_loop import closed_loops
from ur5lib.topics.thesis.records import ClosedLoop
from ur5lib.topics.thesis.rows import (
    EstimatedGain,
    LoopError,
    PublishedGain,
    TorqueConstant,
    estimated_gains,
    loop_errors,
    published_gains,
    torque_constants,
)
from ur5lib.topics.thesis.torque_lines import current_torque, published_constants
from ur5lib.topics.thesis.wrenches import published_forces


class RebuiltThesis(NamedTuple):
    """A recording by the thesis's methods.

    closed_loop: with published gains and with those that fit the recording best; further: F̂ᵘ, F̂
    and F̂*, as printed and by the corrected equations; errors to constants: rows of tables.
    """

    closed_loop: ClosedLoop
    further: FurtherForces
    errors: list[LoopError]
    gains: list[EstimatedGain]
    published_gains: list[PublishedGain]
    constants: list[TorqueConstant]


class Inputs(Opened):
    """What is read of a recording."""

    gravity: list[float] | None
    kinematics: Kinematics
    signals: Signals
    motion: Motion
    torques: Torques
    premises: Premises


@step(
    "recording",
    "closed_loop.parquet further=published_forces.parquet errors=closed_loop_mae.csv gains.csv "
    "published_gains.csv constants=published_constants.csv",
    arm="described",
    lowpass="published_lowpass",
)
def rebuild_thesis(
    recording: Inputs,
    friction: Friction,
    arm: Robot,
    lowpass: Butterworth,
    min_singular_value: float,
) -> RebuiltThesis:
    """Return a recording by the thesis's methods, without forces if it contradicts the study.

    lowpass: of the external torques; min_singular_value: least one of a usable Jacobian.
    """
    signals, torques = recording.signals, recording.torques
    loop, gains = closed_loops(signals, arm.mounted(recording.gravity))
    forces = FurtherForces(time=signals.time, segment=signals.segment)
    if not recording.premises.contradictions.stop_signs and not friction.stopped:
        forces = published_forces(recording, arm, lowpass, min_singular_value)
    constants = published_constants(current_torque(arm, signals, torques))
    return RebuiltThesis(
        closed_loop=loop,
        further=forces,
        errors=[*loop_errors(loop, signals)],
        gains=[*estimated_gains(gains)],
        published_gains=[*published_gains(gains)],
        constants=[*torque_constants(constants)],
    )
