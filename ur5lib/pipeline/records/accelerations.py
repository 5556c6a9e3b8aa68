"""Acceleration of the end effector."""

from dataclasses import dataclass

from ur5lib.pipeline.records.table import JOINTS, SegmentedTable, channel, channels
from ur5lib.timeseries.arrays import Array

ESTIMATES = ("encoders", "encoders+imu", "filterpy")
PUBLISHED = ("euler", "euler, B corrected")
MOTION = "m/s2, rad/s2"


@dataclass(frozen=True, kw_only=True)
class Accelerations(SegmentedTable):
    """Linear and angular acceleration at the IMU's place, base frame, (N, 6) [m/s², rad/s²].

    felt: by the calibrated IMU, acceleration: by estimate; published_felt, published: the same as
    the thesis did it. None and empty where no IMU's clock could be estimated from its motion.
    """

    felt: Array | None = channel("felt", MOTION, JOINTS, optional=True)
    acceleration: dict[str, Array] = channels("acceleration_{}", MOTION, JOINTS, ESTIMATES)
    published_felt: Array | None = channel("published_felt", MOTION, JOINTS, optional=True)
    published: dict[str, Array] = channels("published_{}", MOTION, JOINTS, PUBLISHED)
