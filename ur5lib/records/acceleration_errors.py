"""Rows of the tables about accelerations compared with an IMU."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class AccelerationError:
    """A row of acceleration_mae.csv: MAE of the end effector's acceleration against the IMU, and
    that of zero [m/s², rad/s²].
    """

    estimate: str
    component: str
    mae: float
    zero_mae: float


@dataclass(frozen=True, kw_only=True)
class AccelerationBand:
    """A row of acceleration_bands.csv: RMS difference from the IMU in a range of frequency, in
    motion or at rest, of encoders and of filterpy's plain smoother.

    std: of the other recordings; held: share of the samples within its 95 % band.
    """

    range: str
    during: str
    component: str
    unit: str
    rms: float
    std: float
    held: float
    filterpy_rms: float


@dataclass(frozen=True, kw_only=True)
class Innovation:
    """A row of innovations.csv: the test of a channel's innovations, see `InnovationTest`."""

    estimate: str
    channel: str
    variance: float
    variance_low: float
    variance_high: float
    portmanteau: float
    portmanteau_limit: float
    consistent: bool
    white: bool
    colour: float
