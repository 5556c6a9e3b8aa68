"""The flange's pose at the measured positions, and joint torques of the link models."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ur5lib.records.table import JOINTS, XYZ, SegmentedTable, Table, channel
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import in_chunks

ROTATION = tuple(map(str, range(9)))


@dataclass(frozen=True, kw_only=True)
class Kinematics(Table):
    """Pose and Jacobian of the last frame, base frame.

    origin: (N, 3) [m]; rotation: R_6 (N, 3, 3); jacobian: geometric, J_g (N, 6, n) [m, 1];
    smallest_singular_value: of J_g, (N,).
    """

    origin: Array = channel("o6", "m", XYZ)
    rotation: Array = channel("R6", "1", ROTATION, shape=(3, 3))
    jacobian: Array = channel("J", "m, 1", JOINTS, shape=(6, -1))
    smallest_singular_value: Array = channel("sigma_min", "1")

    @classmethod
    def of(cls, time: Array, rotation: Array, origin: Array, jacobian: Array) -> Self:
        """Return the record from the results of `flange_kinematics`, with singular values."""

        def smallest(J: Array) -> Array:
            return np.linalg.svd(J, compute_uv=False)[:, -1].astype(float)

        return cls(
            time=time,
            origin=origin,
            rotation=rotation,
            jacobian=jacobian,
            smallest_singular_value=in_chunks(smallest, jacobian),
        )


@dataclass(frozen=True, kw_only=True)
class Torques(SegmentedTable):
    """Inverse dynamics and its parts, (N, 6) [Nm] each.

    target, measured: by link model, at the targets and at the measured motion, with the payload
    configured in the controller; payload_torque: true payload less configured payload.
    """

    interpolated: Mask = channel("interpolated", "1", dtype=np.bool_)
    target: dict[str, Array] = channel("tau_target_{}", "Nm", JOINTS)
    measured: dict[str, Array] = channel("tau_measured_{}", "Nm", JOINTS)
    payload_torque: Array = channel("payload_torque", "Nm", JOINTS)
