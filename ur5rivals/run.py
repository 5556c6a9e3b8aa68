"""One recording as input for all estimators of the benchmark."""

from dataclasses import dataclass, field, replace
from typing import NamedTuple, Self

import numpy as np

from ur5lib.force.external_torque import States, finite_rows
from ur5lib.force.force_input import Gears
from ur5lib.identification.currents import torque_constants
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.friction import Friction
from ur5lib.records.measured import Measured
from ur5lib.robots.description import Payload, Robot
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import unbroken


class Estimate(NamedTuple):
    """An estimated contact wrench.

    wrench: (N, 6) [N, Nm], the environment acting on the arm, base axes, at frame 6's origin, NaN
    where there is none; std: its standard deviation (N, 6), None if none is stated.
    """

    wrench: Array
    std: Array | None = None


class FittedArm(NamedTuple):
    """The arm of a recording as mounted, with its fit, payload, and assumed place of contacts."""

    robot: Robot
    friction: Friction
    payload: Payload | None
    place: ContactPlace


@dataclass(frozen=True, eq=False)  # equal only to itself, so that runs can be keys of caches
class Run:
    """One recording as input of all estimators; arrays are (N, 6) where no other shape is given,
    NaN where unknown.

    path: label of the trajectory; period: [s]; segment: (N,) labels of unbroken parts; states: of
    motion, by joint; q, qd, qdd: [rad, rad/s, rad/s²]; model: torque of the rigid-body model [Nm];
    friction: predicted, without contact [Nm]; jacobian: J_g (N, 6, 6), base frame; torque:
    external, k (i_predicted - i), unfiltered [Nm]; smoothed: the same through the study's
    zero-phase low-pass; momentum: p = D q̇ [Nm s]; rate: dp/dt of an arm without contact, tau_m -
    tau_f + Cᵀ q̇ - g [Nm]; breakaway: torque (6,) [Nm]; gears: their transmitted torque and
    friction, unfiltered; position_error: target less actual angles [rad], None if the target was
    not recorded; measured: the controller's unsmoothed samples; arm: with its fit; repeats: other
    runs of its path without contact; ready: estimates that the study already has; sensor: the force
    sensor's wrench less bias and tool weight, as in `Estimate`.
    """

    name: str
    path: int
    period: float
    segment: Labels
    states: States
    q: Array
    qd: Array
    qdd: Array
    model: Array
    friction: Array
    jacobian: Array
    torque: Array
    smoothed: Array
    momentum: Array
    rate: Array
    breakaway: Array
    gears: Gears
    position_error: Array | None = None
    measured: Measured | None = None
    arm: FittedArm | None = None
    repeats: tuple["Run", ...] = ()
    ready: dict[str, Estimate] = field(default_factory=dict)
    sensor: Array | None = None

    def part(self, rows: slice) -> Self:
        """Return the samples `rows`, without sensor and ready estimates."""
        names = ["segment", "states", "q", "qd", "qdd", "model", "friction", "jacobian"]
        names += ["torque", "smoothed", "momentum", "rate", "position_error"]
        sampled = {name: getattr(self, name) for name in names}
        parts = {name: values[rows] for name, values in sampled.items() if values is not None}
        measured = self.measured and self.measured.at(rows)
        return replace(
            self, **parts, gears=self.gears.at(rows), measured=measured, ready={}, sensor=None
        )

    def pushed(self, torque: Array) -> Self:
        """Return the same motion under an additional external torque (N, 6) [Nm].

        The motors' torque is reduced by it, and the motion does not change.
        """
        return replace(
            self,
            measured=self._with_less_current(torque),
            torque=self.torque + torque,
            smoothed=self.smoothed + torque,
            rate=self.rate - torque,
        )

    def _with_less_current(self, torque: Array) -> Measured | None:
        """Return the controller's samples with the current of `torque` (N, 6) [Nm] subtracted."""
        if self.measured is None or self.arm is None:
            return self.measured
        constant = torque_constants(self.arm.friction.fit_for(self.name))
        return self.measured._replace(current=self.measured.current - torque / constant)

    def complete(self) -> Mask:
        """Return the mask (N,) of samples at which all inputs are finite."""
        inputs = [self.q, self.qd, self.qdd, self.model, self.friction, self.torque, self.smoothed]
        inputs += [self.momentum, self.rate, *self.jacobian.transpose(1, 0, 2)]
        if self.position_error is not None:
            inputs.append(self.position_error)
        return finite_rows(np.sum(inputs, axis=0))

    def known(self) -> list[slice]:
        """Return slices of successive samples, without a gap, at which momentum and its rate are
        finite.
        """
        return self.stretches(self.momentum + self.rate)

    def stretches(self, values: Array) -> list[slice]:
        """Return slices of successive samples, without a gap, at which values (N, 6) are finite."""
        finite = finite_rows(values)
        return [rows for rows in unbroken(self.segment, finite) if finite[rows.start]]
