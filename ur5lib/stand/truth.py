"""The truth of a simulated recording, as `write_truth` writes it: samples, and true parameters."""

from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from ur5lib.records.table import JOINTS, SIX, Table, channel
from ur5lib.robots.description import Payload, Vector3
from ur5lib.stand.plan import Imu
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import interpolated


@dataclass(frozen=True, kw_only=True)
class Truth(Table):
    """The true motion, joint torques and contact wrench.

    q, qd, qdd: (N, n) [rad, rad/s, rad/s²]; torques of motors, friction and contact: (N, n) [Nm];
    wrench: (N, 6) [N, Nm], of the environment on the arm, base axes, at the origin of frame 6.
    """

    q: Array = channel("q", "rad", JOINTS)
    qd: Array = channel("qd", "rad/s", JOINTS)
    qdd: Array = channel("qdd", "rad/s2", JOINTS)
    motor_torque: Array = channel("tau_motor", "Nm", JOINTS)
    friction_torque: Array = channel("tau_friction", "Nm", JOINTS)
    contact_torque: Array = channel("tau_contact", "Nm", JOINTS)
    wrench: Array = channel("wrench", "N, Nm", SIX)

    def at(self, time: Array) -> Self:
        """Return the truth at times (N,) [s], linearly interpolated; NaN outside."""
        arrays = {
            own.name: interpolated(time, self.time, getattr(self, own.name), outside=np.nan)
            for own in fields(self)
            if own.name != "time"
        }
        return type(self)(time=time, **arrays)


@dataclass(frozen=True)
class TruePlan:
    """The part of a simulation's plan in truth.json: payloads and IMU of the arm, and the seed of
    its noise.
    """

    seed: int
    payload: Payload | None
    undeclared_payload: Payload | None
    imu: Imu | None


@dataclass(frozen=True)
class TrueDrive:
    """The drives in truth.json: torque constants (n,) [Nm/A], and the offset (n,) [Nm] of sensed
    torques.
    """

    torque_constant: Array
    offset: Array | None = None


@dataclass(frozen=True)
class TrueParameters:
    """The part of truth.json that estimates are compared with; `write_truth` writes it.

    model: simulated link model; friction: `FrictionParameters` (n,) of the test stand, by name;
    clocks: `offset_s` and `drift_ppm` by device.
    """

    robot: str
    gravity: Vector3
    model: str
    plan: TruePlan
    drive: TrueDrive
    friction: dict[str, Array]
    clocks: dict[str, dict[str, float]]
