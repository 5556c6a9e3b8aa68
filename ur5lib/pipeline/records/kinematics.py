"""Where the flange is at the measured positions."""

from dataclasses import dataclass

from ur5lib.pipeline.records.table import JOINTS, XYZ, Table, channel
from ur5lib.timeseries.arrays import Array

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
