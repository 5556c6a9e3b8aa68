"""The relation of a device's clock to the robot's."""

from dataclasses import dataclass

import numpy as np

from ur5lib.errors import Remark
from ur5lib.timeseries.arrays import Array

# Standard deviation of an unknown drift. Quartz is accurate to 1e-4, but a host's software makes
# the stamps: the only host with a measured drift, the thesis's, drifts by 0.0033.
UNKNOWN_DRIFT_STD = 0.003


@dataclass(frozen=True)
class ClockRelation:
    """t_robot = offset + (1 + drift) t_device, both counted from their own start stamps.

    offset, offset_std: [s]; drift, drift_std: dimensionless, None if not estimated; method: source
    of the offset.
    """

    offset: float
    offset_std: float
    drift: float | None
    drift_std: float | None
    method: str

    def device_time(self, time: Array) -> Array:
        """Return the device's time at the robot's times (N,) [s]."""
        return (time - self.offset) / (1 + (self.drift or 0.0))

    def std_after(self, duration: float) -> float:
        """Return the standard error [s] at a time [s] after the robot's start stamp.

        A drift that was not estimated counts as 0 ± UNKNOWN_DRIFT_STD.
        """
        drift_std = UNKNOWN_DRIFT_STD if self.drift_std is None else self.drift_std
        return float(np.hypot(self.offset_std, drift_std * duration))


@dataclass(frozen=True)
class OwnClock(ClockRelation):
    """A device's clock from its own start stamp and motion.

    warning: why motion does not determine it, else None; stamps: the offset by start stamps only
    [s].
    """

    warning: Remark | None
    stamps: float


@dataclass(frozen=True)
class SettledClock(ClockRelation):
    """The clock that maps a device's samples to the robot's time.

    warning: of its own clock; end_std: standard error at the end of the recording [s].
    """

    warning: Remark | None
    end_std: float


@dataclass(frozen=True)
class HostDrift:
    """Drift and start of a host's clock relative to the robot's.

    devices: those on this host; drift: mean over recordings, std_error: of that mean, spread:
    standard deviation between recordings, all dimensionless; start, start_std_error, start_spread:
    the same for the delay of a device's clock relative to the start stamps [s]; recordings: names
    of those used.
    """

    devices: list[str]
    drift: float
    std_error: float
    spread: float
    start: float
    start_std_error: float
    start_spread: float
    recordings: list[str]
