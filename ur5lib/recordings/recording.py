"""A recording as its devices wrote it, before any repair: what every reader returns."""

from dataclasses import dataclass

import pandas as pd

from ur5lib.recordings.quality import Device, Finding


@dataclass(frozen=True)
class StartOffset:
    """How much later a device's clock started than the robot's, by the stamps both wrote [s]."""

    seconds: float
    std: float


@dataclass(frozen=True)
class RawRecording:
    """Tables of the devices, each on its own clock, and what was found while reading.

    robot: `time` [s] and RTDE channels, one row per frame; period: the controller's cycle [s];
    sensors: by device, `time` [s] and `ft_fx` .. `ft_tz` [N, Nm] (sensor frame) for "force",
    `imu_ax` .. `imu_gz` [m/s², rad/s] (sensor frame) for "imu"; only what recorded something
    usable and can be placed on the robot's clock; starts: by device.
    """

    robot: pd.DataFrame
    period: float
    sensors: dict[Device, pd.DataFrame]
    starts: dict[Device, StartOffset]
    findings: list[Finding]
