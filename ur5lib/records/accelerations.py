"""Acceleration of the end effector, and its errors against an IMU."""

from dataclasses import dataclass, field

from ur5lib.records.table import SIX, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array

ESTIMATES = ("encoders", "encoders+imu", "filterpy")
THROUGH_ANGLES = ("euler", "euler, B corrected")
MOTION = "m/s2, rad/s2"
COMPONENTS = {"x": "m/s2", "y": "m/s2", "z": "m/s2", "rx": "rad/s2", "ry": "rad/s2", "rz": "rad/s2"}


@dataclass(frozen=True, kw_only=True)
class Accelerations(SegmentedTable):
    """Linear and angular acceleration at the IMU's place, base frame, (N, 6) [m/s², rad/s²].

    felt: by the calibrated IMU; acceleration: by estimate; causal_felt, causal: with a causal
    filter, by the IMU as mounted and through Euler angles. None and empty if no IMU's clock could
    be estimated from its motion.
    """

    felt: Array | None = channel("felt", MOTION, SIX, optional=True)
    acceleration: dict[str, Array] = channel("acceleration_{}", MOTION, SIX, keys=ESTIMATES)
    causal_felt: Array | None = channel("causal_felt", MOTION, SIX, optional=True)
    causal: dict[str, Array] = channel("causal_{}", MOTION, SIX, keys=THROUGH_ANGLES)


@dataclass(frozen=True)
class AccelerationErrors:
    """MAE of an estimate against the IMU by component, and that of zero [m/s², rad/s²]."""

    mae: dict[str, float]
    zero_mae: dict[str, float]


@dataclass(frozen=True)
class Difference:
    """The difference of encoders and IMU in a range of frequency, x, y, z [m/s²], rx, ry, rz
    [rad/s²].

    square: (6,), mean squares; quantiles: (101, 6), percentiles of the absolute difference.
    """

    square: Array
    quantiles: Array


ByRange = dict[str, dict[str, Difference]]  # by range of frequency, in motion and at rest


@dataclass(frozen=True, kw_only=True)
class ImuComparison:
    """Errors by estimate against the IMU, and differences by range of frequency.

    calibrated_on: the recordings that calibrated the IMU; accelerometer_bias: (3,) [m/s²];
    plain_ranges: differences of a plain smoother. Empty where no IMU's clock could be estimated
    from its motion.
    """

    errors: dict[str, AccelerationErrors] = field(default_factory=dict)
    calibrated_on: list[str] = field(default_factory=list)
    accelerometer_bias: Array | None = None
    ranges: ByRange = field(default_factory=dict)
    plain_ranges: ByRange = field(default_factory=dict)
