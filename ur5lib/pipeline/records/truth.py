"""The simulated truth."""

from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from ur5lib.pipeline.records.table import JOINTS, Table, channel
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import interpolated


@dataclass(frozen=True, kw_only=True)
class Truth(Table):
    """True motion [rad, rad/s, rad/s²], joint torques [Nm] of motors, friction and contact, and the
    wrench of the environment on the arm [N, Nm], base axes, frame 6's origin; (N, 6) each.
    """

    q: Array = channel("q", "rad", JOINTS)
    qd: Array = channel("qd", "rad/s", JOINTS)
    qdd: Array = channel("qdd", "rad/s2", JOINTS)
    motor_torque: Array = channel("tau_motor", "Nm", JOINTS)
    friction_torque: Array = channel("tau_friction", "Nm", JOINTS)
    contact_torque: Array = channel("tau_contact", "Nm", JOINTS)
    wrench: Array = channel("wrench", "N, Nm", JOINTS)

    def at(self, time: Array) -> Self:
        """Return the truth at times (N,) [s], linearly interpolated; NaN outside."""
        arrays = {
            own.name: interpolated(time, self.time, getattr(self, own.name), outside=np.nan)
            for own in fields(self)
            if own.name != "time"
        }
        return type(self)(time=time, **arrays)
