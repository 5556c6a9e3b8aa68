"""Postures at rest."""

from dataclasses import dataclass

from ur5lib.records.quality import Contradictions
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Postures:
    """postures.json: the postures of a recording without time.

    q: (M, n) [rad]; current: (M, n) [A]; gravity: [m/s²], base frame; payload: on the flange;
    contradictions: of the recording and the study.
    """

    q: Array
    current: Array
    gravity: list[float]
    payload: Payload | None
    contradictions: Contradictions

    def held_torque(self, arm: Robot, model: str) -> Array:
        """Return the torque (M, n) [Nm] against gravity of an arm with its payload, in each
        posture.
        """
        loaded = arm.mounted(self.gravity).carrying(self.payload)
        return gravity_torque(loaded, model, self.q)
