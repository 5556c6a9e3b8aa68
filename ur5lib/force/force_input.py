"""A recording as the force estimates use it: motion, external torque, and the friction of gears."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ur5lib.force.external_torque import JointState, States, joint_states
from ur5lib.records.currents import Currents
from ur5lib.records.motion import Motion
from ur5lib.timeseries.arrays import Array, Labels, Mask

# At rest, dry friction takes any share of a contact's torque from 0 to 1; this is the mean.
MEAN_STICTION = 0.5


@dataclass(frozen=True)
class Gears:
    """The torque and friction of the gears by a fit, in a motion without contact, (N, 6) each,
    low-passed.

    load: torque that they transmit [Nm]; loss: load-dependent friction per Nm of load, c z, with z
    the direction of the friction, -1 to 1; friction: all of the friction [Nm].
    """

    load: Array
    loss: Array
    friction: Array

    @classmethod
    def without_friction(cls, torque: Array) -> Self:
        """Return gears with zero load, loss and friction, for a torque (N, 6)."""
        return cls(*(np.zeros_like(torque) for _ in range(3)))

    def at(self, rows: slice | Mask | Labels) -> Self:
        """Return the gears in some samples."""
        return type(self)(self.load[rows], self.loss[rows], self.friction[rows])

    def where_moving(self, states: States) -> Self:
        """Return the gears with zero friction at stopped joints, where it may have any value.

        states: of the joints (N, 6). Unknown friction counts as zero.
        """
        moves = states <= JointState.REVERSING
        loss, friction = (
            np.where(moves, np.nan_to_num(friction_values), 0.0)
            for friction_values in (self.loss, self.friction)
        )
        return replace(self, load=np.nan_to_num(self.load), loss=loss, friction=friction)

    def felt(self, torque: Array) -> Array:
        """Return y = x - c z (|l - x| - |l|) (N, 6) [Nm], the drop of the motors' torque in a
        contact.

        torque: x = Jᵀ F (N, 6) [Nm] of the contact, which changes the gears' load from l to l - x.
        """
        return torque - self.loss * (np.abs(self.load - torque) - np.abs(self.load))

    def contact_torque(self, torque: Array) -> tuple[Array, Array]:
        """Return the torque x (N, 6) [Nm] of a contact from the motors' y, and dx / dy (N, 6).

        torque: y (N, 6) [Nm]. The inverse of `felt`: l - x = m / (1 + c z sign m), where m = l + c
        z |l| - y is the motors' torque without the friction that does not depend on load.
        """
        motor = self.load + self.loss * np.abs(self.load) - torque
        share = 1 / (1 + self.loss * np.sign(np.nan_to_num(motor)))
        return self.load - motor * share, share


def mean_stiction_torque(torque: Array, breakaway: Array, share: float) -> Array:
    """Return s b tanh(τ / b) / 2, the torque (N, 6) [Nm] that dry friction at rest takes on
    average.

    torque: τ (N, 6) [Nm], of the contact; breakaway: b (6,) [Nm]; share: s. Friction opposes the
    contact and takes anything from nothing to s b.
    """
    return MEAN_STICTION * share * breakaway * np.tanh(torque / breakaway)


@dataclass(frozen=True)
class ForceInput:
    """Input of the force estimate of one run.

    q, qd, torque, states: positions, velocities, external torques and joint states, (N, 6) each,
    NaN where unknown; segment: (N,); period: [s]; doubt: (N, 6) [Nm], standard deviation of the
    torque of a load that was estimated, None without such a load; gears: None if their friction is
    unknown.
    """

    q: Array
    qd: Array
    torque: Array
    states: States
    segment: Labels
    period: float
    doubt: Array | None = None
    gears: Gears | None = None

    def load_std(self) -> Array:
        """Return the standard deviation (N, 6) [Nm] of an estimated load's torque, 0 without such a
        load.
        """
        return np.zeros(self.states.shape) if self.doubt is None else np.nan_to_num(self.doubt)

    def thinned(self, stride: int, rows: Labels | slice) -> Self:
        """Return the input at some rows, which are `stride` samples apart."""
        return replace(
            self,
            **{name: getattr(self, name)[rows] for name in ("q", "qd", "torque", "states")},
            segment=self.segment[rows],
            period=stride * self.period,
            doubt=None if self.doubt is None else self.doubt[rows],
            gears=None if self.gears is None else self.gears.at(rows),
        )


def force_input(motion: Motion, torque: Array, currents: Currents, cutoff: float) -> ForceInput:
    """Return the force estimate's input of a motion with its external torque (N, 6) [Nm].

    cutoff: of the torque's low-pass [Hz].
    """
    states = joint_states(motion.motor_qd, motion.segment, motion.period, cutoff)
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


def inputs(recordings: Iterable[tuple[Currents, Motion]], cutoff: float) -> list[ForceInput]:
    """Return the inputs of those recordings that have an external torque; cutoff: of its low-pass
    [Hz].
    """
    return [
        force_input(motion, currents.external_torque, currents, cutoff)
        for currents, motion in recordings
        if currents.external_torque is not None
    ]


def gears(currents: Currents) -> Gears | None:
    """Return the gears' load and friction during a motion by the fit; None where they are
    unknown.
    """
    load, loss, friction = currents.gear_torque, currents.load_loss, currents.friction_torque
    if load is None or loss is None or friction is None:
        return None
    return Gears(load, loss, friction)
