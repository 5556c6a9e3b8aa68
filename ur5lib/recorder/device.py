"""The interface between the recorder and any device that it records."""

from dataclasses import dataclass
from typing import Any, Protocol

from ur5lib.timeseries.arrays import Array


class DeviceLost(Exception):  # noqa: N818, an event that every recorder expects
    """A device failed during the recording: no sample for a second, or its port is closed."""


@dataclass(frozen=True)
class NewSamples:
    """Samples of a device since the last call of `read`, in the order of its counter.

    received: the host's time.monotonic at the arrival of each sample (n,) [s];
    values: one row per sample (n, len(columns)); lost: samples missing before or among them, by
    the device's own counter.
    """

    received: Array
    values: Array
    lost: int


class Device(Protocol):
    """A device to record: call `open`, then `read` repeatedly, then `close`.

    name: "robot", "force_sensor" or "imu", also the name of its file; columns: the names of its
    samples' values, which include the device's own counters and times, but not the host's time.
    """

    name: str
    columns: tuple[str, ...]

    def open(self) -> dict[str, Any]:
        """Connect, start the stream, and return the device's entry in the manifest.

        It holds at least model, serial number, units and rate_hz.

        Raises InputError, with address and remedy, when the device does not answer.
        """
        ...

    def read(self) -> NewSamples:
        """Return the samples since the last call, after waiting at most 0.1 s.

        Raises DeviceLost when the device has gone.
        """
        ...

    def close(self) -> None:
        """Stop streaming; does nothing when the device is closed or gone."""
        ...
