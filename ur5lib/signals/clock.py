"""The relation of a device's clock to the robot's: offset and drift."""

from dataclasses import dataclass

import numpy as np

from ur5lib.errors import Remark
from ur5lib.timeseries.arrays import Array

# Standard deviation of an unknown drift. Quartz is accurate to 1e-4, but stamps are made by a
# host's software: the only host whose drift is known, the thesis's, is off by 0.0033.
UNKNOWN_DRIFT = 0.003
BY_STAMPS, BY_MOTION, BY_HOST = "start stamps", "angular rate", "host's stamps"  # methods


@dataclass(frozen=True)
class Clock:
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

        A drift that was not estimated counts as 0 ± UNKNOWN_DRIFT.
        """
        drift_std = UNKNOWN_DRIFT if self.drift_std is None else self.drift_std
        return float(np.hypot(self.offset_std, drift_std * duration))


@dataclass(frozen=True)
class OwnClock(Clock):
    """A device's clock from its own start stamp and motion.

    warning: why motion does not determine it, None if it does; stamps: the offset by start stamps
    alone [s].
    """

    warning: Remark | None
    stamps: float


@dataclass(frozen=True)
class SettledClock(Clock):
    """The clock by which a device's samples are put on the robot's time.

    warning: of its own clock; end_std: standard error at the end of the recording [s].
    """

    warning: Remark | None
    end_std: float


def clock_from_stamps(offset: float, std: float) -> Clock:
    """Return the clock of start stamps `offset` [s] apart; its drift is unknown."""
    return Clock(offset, std, None, None, BY_STAMPS)


def clock_from_host(offset: float, std: float, drift_std: float) -> Clock:
    """Return the clock of a device whose samples the robot's host stamped, with its errors."""
    return Clock(offset, std, 0.0, drift_std, BY_HOST)
