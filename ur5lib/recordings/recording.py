"""A recording as its devices wrote it, before any repair: the result of every reader."""

from dataclasses import dataclass, field
from typing import Literal

import pandas as pd

from ur5lib.records.quality import Device, Finding

DAY = 86400.0  # s


@dataclass(frozen=True)
class Stamp:
    """The time at which a device's clock read zero.

    seconds: that time; since: what it counts from: the epoch, midnight UTC, the start of the
    recording, the zero of the robot's host, or the robot's first frame; std: its standard
    uncertainty [s]; drift_std: standard uncertainty of the clock's rate relative to the robot's,
    None if unknown, 0 of the robot's own clock.
    """

    seconds: float
    std: float
    since: Literal["epoch_s", "day_ms", "relative_s", "host_s", "first_frame"]
    drift_std: float | None = None

    def after(self, other: "Stamp") -> float | None:
        """Return by how much this stamp is later than another [s]; None if they count from
        different zeros.
        """
        if self.since == "first_frame":
            return self.seconds
        apart = self.seconds - other.seconds
        kinds = {self.since, other.since}
        if kinds == {"epoch_s", "day_ms"} or kinds == {"day_ms"}:
            return (apart + DAY / 2) % DAY - DAY / 2
        return apart if len(kinds) == 1 else None


@dataclass(frozen=True)
class DeviceRecord:
    """What one device recorded.

    table: `time` [s], counted from the device's own zero, and its channels, one row per sample;
    start: when that zero was, None if unknown; source: the file it came from.
    """

    table: pd.DataFrame
    start: Stamp | None
    source: str


@dataclass(frozen=True)
class RawRecording:
    """The devices of a recording, each on its own clock, and the findings of its reader.

    robot: RTDE channels; cells that were not received are NaN; cycle: the controller's [s], None
    where the format leaves it open; sensors: `ft_fx` .. `ft_tz` [N, Nm] for "force", `imu_ax` ..
    `imu_gz` [m/s², rad/s] for "imu", sensor frame; only those that recorded something.
    """

    robot: DeviceRecord
    cycle: float | None
    sensors: dict[Device, DeviceRecord]
    findings: list[Finding] = field(default_factory=list)
