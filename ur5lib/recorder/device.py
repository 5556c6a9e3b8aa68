"""What the recorder knows of a device."""

from dataclasses import dataclass
from typing import Any, Protocol

from ur5lib.timeseries.arrays import Array


class DeviceLost(Exception):  # noqa: N818, an event that every recorder expects
    """A device that was being recorded has gone: no sample for a second, or its port is closed."""


@dataclass(frozen=True)
class Samples:
    """Samples of a device in the order of its counter.

    received: the host's time.monotonic at the arrival of each sample (n,) [s];
    values: one row per sample (n, len(columns)); lost: samples missing before or among them, by
    the device's own counter.
    """

    received: Array
    values: Array
    lost: int


class Device(Protocol):
    """A device that is recorded: open, read until closed, close.

    name: "robot", "force_sensor" or "imu", also its file's name; columns: of its samples after the
    host's time, the device's own counters and times among them.
    """

    name: str
    columns: tuple[str, ...]

    def open(self) -> dict[str, Any]:
        """Connect, start, and return what the manifest says: model, serial number, units, rate_hz.

        Raises InputError, with address and remedy, when the device does not answer.
        """
        ...

    def read(self) -> Samples:
        """Return the samples since the last call, after waiting at most 0.1 s.

        Raises DeviceLost when the device has gone.
        """
        ...

    def close(self) -> None:
        """Stop streaming; does nothing when the device is closed or gone."""
        ...
