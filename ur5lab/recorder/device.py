"""The interface between the recorder and its devices, and functions that devices share."""

import math
import select
import socket
import struct
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array
from ur5lib.workspace.beside import of_extra

CHUNK_BYTES = 1 << 16  # bytes read at a time
MAX_GAP = 10.0  # s; after a longer jump, the counter is damaged or was restarted
MAX_SILENCE = 1.0  # s
ANSWER_TIMEOUT = 3.0  # s
GATHERING_TIME = 0.05  # s; in which one call collects samples


class DeviceLost(Exception):  # noqa: N818, an event that every recorder expects
    """Raised where a device fails during the recording: no sample for a second, or its port is
    closed.
    """


def of_recorder(module: str, purpose: str) -> Any:
    """Return a module that the extra `record` installs; purpose: for the message. Raises InputError
    where it is not installed.
    """
    return of_extra("record", module, purpose)


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


@dataclass(frozen=True)
class Packets:
    """Packets of bytes as they arrived from a socket, of a device that does not decode them.

    received: the host's time.monotonic at the arrival of each packet (n,) [s]; packets: bytes;
    messages: the number of the device's messages that ended in them; lost: the number of messages
    missing before or among those.
    """

    received: Array
    packets: list[bytes]
    messages: int
    lost: int


@dataclass(kw_only=True)
class Identity:
    """A device's entry in the manifest; fields that are None are left out.

    rate_hz: nominal, None if the device does not state it; clock: the name of its own time;
    missing: channels that it lacks; the others: settings of an arm, a force sensor or an IMU.
    """

    model: str
    address: str
    units: str | dict[str, str]
    rate_hz: float | None
    serial_number: str | None = None
    firmware: str | None = None
    clock: str | None = None
    missing: list[str] | None = None
    message: str | None = None
    message_bytes: int | None = None
    counts_per_unit: dict[str, float] | None = None
    box_units: dict[str, str] | None = None
    bias: bool | None = None


class Device(Protocol):
    """A device that is being recorded: it streams from its construction until `close`.

    Its constructor raises InputError, with address and remedy, when the device does not answer.
    columns: the names of its samples' values, which include the device's own counters and times,
    but not the host's time; identity: its entry in the manifest.
    """

    columns: tuple[str, ...]
    identity: Identity

    def read(self) -> NewSamples | Packets:
        """Return the samples since the last call, after waiting at most 0.1 s.

        Raises DeviceLost when the device is silent for a second, or its connection is closed.
        """
        ...

    def close(self) -> None:
        """Stop streaming, also where the device has gone."""
        ...


class Counter:
    """A check of the numbers of consecutive samples for missing ones.

    bits: numbers wrap around at 2^bits; rate_hz: of the samples. Numbers that are repeated, late,
    or more than MAX_GAP ahead are not accepted. total: the number without wrap-around.
    """

    def __init__(self, bits: int, rate_hz: float) -> None:
        self._period = 1 << bits
        self._furthest = min(int(MAX_GAP * rate_hz), self._period // 2 - 1)
        self._last: int | None = None
        self.total = 0

    def lost_before(self, number: int) -> int | None:
        """Return the count of samples missing before this one; None if it is not accepted."""
        if self._last is None:
            self._last = self.total = number
            return 0
        step = (number - self._last) % self._period
        if not 1 <= step <= self._furthest:
            return None
        self._last, self.total = number, self.total + step
        return step - 1


class CycleCounter:
    """A count of the cycles [s] that are missing between a controller's timestamps.

    Stamps that are not finite, steps back, and steps beyond MAX_GAP are ignored: there, stamps are
    damaged or the controller was restarted. last: timestamp [s] before the first.
    """

    def __init__(self, cycle: float, last: float = math.nan) -> None:
        self._cycle, self._last = cycle, last

    def lost(self, stamps: Array) -> int:
        """Return the count of cycles missing before or among timestamps (n,) [s]."""
        finite = stamps[np.isfinite(stamps)]
        steps = np.diff(finite, prepend=self._last if math.isfinite(self._last) else finite[:1])
        self._last = float(finite[-1]) if len(finite) else self._last
        gaps = steps[(steps > 0) & (steps <= MAX_GAP)]
        return int((np.rint(gaps / self._cycle) - 1).clip(min=0).sum())


class Silence:
    """A timer that notices when a device has stopped sending; name: of the device, for messages."""

    def __init__(self, name: str) -> None:
        self._name, self._last = name, time.monotonic()

    def check(self, samples: int) -> None:
        """Restart the timer if there are samples; raise DeviceLost after 1 s without any."""
        now = time.monotonic()
        if samples:
            self._last = now
        elif now - self._last > MAX_SILENCE:
            raise DeviceLost(f"{self._name} has sent nothing for {MAX_SILENCE:g} s")


def receive(connection: socket.socket, address: str, patience: float) -> tuple[float, bytes]:
    """Return the host's time.monotonic [s] and the available bytes of a TCP connection.

    No bytes after `patience` [s] without any. address: of the device, for messages. Raises
    DeviceLost when the connection fails or is closed.
    """
    if not select.select([connection], [], [], patience)[0]:
        return time.monotonic(), b""
    try:
        data = connection.recv(CHUNK_BYTES)
    except OSError as error:
        raise DeviceLost(f"{address}: {error}") from error
    if not data:
        raise DeviceLost(f"{address} has closed the connection")
    return time.monotonic(), data


@contextmanager
def answering(interface: str, address: str, port: int) -> Iterator[socket.socket]:
    """Yield a connection to a controller's port; it is closed if the block of the context fails.

    Raises the error of `no_controller` if the controller does not answer, or unintelligibly.
    """
    try:
        connection = socket.create_connection((address, port), ANSWER_TIMEOUT)
        try:
            yield connection
        except BaseException:
            connection.close()
            raise
    except (OSError, struct.error) as error:
        raise no_controller(interface, address, port, error) from error


def no_controller(interface: str, address: str, port: int, error: Exception) -> InputError:
    """Return the error for a controller that does not answer; interface: name of the used one."""
    return InputError(
        f"no controller answers by {interface} at {address}, port {port} ({error}); check that it "
        "is switched on and that this is its address"
    )
