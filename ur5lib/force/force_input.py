"""A recording as the force estimates use it: motion, external torque, and what it offers others."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ur5lib.force.external_torque import States, finite_rows, is_still
from ur5lib.force.gears import Gears
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.trajectories import SAME, place


@dataclass(frozen=True)
class ForceInput:
    """Input of the force estimate of one run.

    q, qd, torque, states: positions, velocities, external torques and joint states, (N, 6) each,
    NaN where unknown; segment: (N,); period: [s]; doubt: (N, 6) [Nm], standard deviation of an
    estimated load's torque, None without a load; gears: None if their friction is unknown.
    """

    q: Array
    qd: Array
    torque: Array
    states: States
    segment: Labels
    period: float
    doubt: Array | None = None
    gears: Gears | None = None

    def moves(self) -> Mask:
        """Return the samples (N,) in which the arm moves and its motion is known."""
        return finite_rows(self.q) & finite_rows(self.qd) & ~is_still(self.states)

    def offered(self) -> Mask:
        """Return the samples (N,) that may serve as template: those in motion, of known torque."""
        return self.moves() & finite_rows(self.torque)

    def with_torque(self, torque: Array, states: States) -> Self:
        """Return the same motion with another torque and the states of another model."""
        return replace(self, torque=torque, states=states)


def extent(run: ForceInput) -> Array | None:
    """Return the lowest and the highest `place` (2, 12) that a run offers to templates, if any."""
    passed = place(run.q, run.qd)[run.offered()]
    return np.array([passed.min(axis=0), passed.max(axis=0)]) if len(passed) else None


def may_repeat(run: ForceInput, extent: Array) -> bool:
    """Return whether a contact-free run of this extent can be of the same trajectory.

    A quick necessary condition of `same_trajectory`: a sample near one of the other run lies within
    its extent, widened by the distance that counts as near.
    """
    states = place(run.q, run.qd)[run.moves()]
    inside = ((states >= extent[0] - 1) & (states <= extent[1] + 1)).all(axis=1)
    return bool(len(states) and inside.mean() >= SAME)
