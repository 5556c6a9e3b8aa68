"""A recording as a force estimate without a sensor uses it."""

from collections.abc import Callable, Iterable

from ur5lib.force.external_torque import States, joint_states
from ur5lib.force.force_input import ForceInput, Gears
from ur5lib.records.currents import Currents
from ur5lib.records.motion import Motion
from ur5lib.timeseries.arrays import Array, Labels


def force_input(
    motion: Motion,
    torque: Array,
    currents: Currents,
    states_of: Callable[[Array, Labels, float], States] = joint_states,
) -> ForceInput:
    """Return the measured motion and an external torque (N, 6) [Nm] of the same recording."""
    states = states_of(motion.motor_qd, motion.segment, motion.period)
    return ForceInput(
        motion.q,
        motion.motor_qd,
        torque,
        states,
        motion.segment,
        motion.period,
        currents.load_doubt,
        gears(currents),
    )


def inputs(
    recordings: Iterable[tuple[Currents, Motion]],
    torque: str = "external_torque",
    states_of: Callable[[Array, Labels, float], States] = joint_states,
) -> list[ForceInput]:
    """Return the inputs of the recordings that have an external torque, a field of `Currents`."""
    return [
        force_input(motion, known, currents, states_of)
        for currents, motion in recordings
        if (known := getattr(currents, torque)) is not None
    ]


def gears(currents: Currents) -> Gears | None:
    """Return what the fit says of the gears in a motion, None where that is unknown."""
    load, loss, friction = currents.gear_torque, currents.load_loss, currents.friction_torque
    if load is None or loss is None or friction is None:
        return None
    return Gears(load, loss, friction)
