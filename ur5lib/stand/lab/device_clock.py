"""The clock of an emulated device, by which it takes its samples."""

import math
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Drift:
    """The deviation of a device's clock from the host's.

    offset_s: its time when the device is switched on [s]; drift_ppm: t_host = t_switched_on +
    (1 + drift) (t_device - offset); a fast clock has a negative drift.
    """

    offset_s: float = 0.0
    drift_ppm: float = 0.0


class DeviceClock:
    """Counts the samples of a device that samples at a rate [Hz] by its own clock."""

    def __init__(self, rate_hz: float, drift: Drift) -> None:
        """Switch on now."""
        self._start = time.monotonic()
        self._rate_hz, self._offset = rate_hz, drift.offset_s
        self._step = (1 + 1e-6 * drift.drift_ppm) / rate_hz

    def count(self, now: float) -> int:
        """Return the number of samples taken until `now` [s, the host's monotonic time]."""
        return math.floor((now - self._start) / self._step) + 1

    def instant(self, sample: int) -> float:
        """Return the host's monotonic time [s] of a sample, counted from 0."""
        return self._start + sample * self._step

    def host(self, shown: float) -> float:
        """Return the host's monotonic time [s] at which the device's clock shows `shown` [s]."""
        return self._start + (shown - self._offset) * self._rate_hz * self._step

    def shown(self, sample: int) -> float:
        """Return the time of a sample by the device's clock [s]."""
        return self._offset + sample / self._rate_hz
