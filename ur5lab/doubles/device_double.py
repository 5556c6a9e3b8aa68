"""The base of device doubles: a clock of its own, and a thread that samples and answers."""

import math
import select
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

from ur5lab.doubles.transmission import Delivery, TransmissionFaults
from ur5lib.timeseries.arrays import Array

HOST = "127.0.0.1"
MIN_SLEEP = 0.001  # s; samples that become due meanwhile are sent together
MAX_CATCH_UP_FACTOR = 3  # largest multiple of the rate at which late samples are sent
Reading = Callable[[float], Array]  # of the host's monotonic time [s]


@dataclass(frozen=True)
class DeviceClock:
    """A device's clock, which differs from the host's: t_host = start + (1 + drift) (t_device −
    offset).

    offset_s: the clock's time when the device is switched on [s]; drift_ppm: positive for a slow
    clock; start: host time when the device is switched on [s, time.monotonic].
    """

    offset_s: float = 0.0
    drift_ppm: float = 0.0
    start: float = 0.0

    @property
    def scale(self) -> float:
        """Return the host's seconds per second of the clock."""
        return 1 + 1e-6 * self.drift_ppm

    def begun(self) -> Self:
        """Return the clock of a device that is switched on now."""
        return replace(self, start=time.monotonic())

    def host(self, shown: float) -> float:
        """Return the host's time [s] at which the clock shows `shown` [s]."""
        return self.start + self.scale * (shown - self.offset_s)

    def shown(self, host: float) -> float:
        """Return the clock's time [s] at a host time [s]."""
        return self.offset_s + (host - self.start) / self.scale


class DeviceDouble(ABC):
    """A double of a device that samples by its own clock and answers requests, while its context
    lasts.

    reading: returns the true reading at a time [s, the host's monotonic], at or shortly before the
    present; called in the device's thread. delivery: the packets in transmission, and which samples
    were lost or late so far. line: file descriptor from which requests are read.
    """

    is_stream: bool
    line: int

    def __init__(
        self, reading: Reading, rate_hz: float, clock: DeviceClock, faults: TransmissionFaults
    ) -> None:
        self.reading, self.rate_hz = reading, rate_hz
        self.clock, self.faults = clock, faults
        self.delivery = Delivery(faults, self.is_stream)
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        self.clock = self.clock.begun()
        self._born = self.clock.start
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self._thread.join()
        self.disconnect()

    def is_powered(self) -> bool:
        """Return whether the device has power; without it, the device neither sends nor answers."""
        return self.faults.powered(time.monotonic() - self._born)

    def shown(self, sample: int) -> float:
        """Return the device's time [s] at a sample, numbered from 0."""
        return self.clock.offset_s + sample / self.rate_hz

    def instant(self, sample: int) -> float:
        """Return the host's time [s] at a sample, numbered from 0."""
        return self.clock.host(self.shown(sample))

    @abstractmethod
    def answer(self) -> None:
        """Read and answer the requests that have arrived."""

    @abstractmethod
    def packet(self, sample: int) -> bytes | None:
        """Return the bytes to send for a sample; None while no client asks for samples."""

    @abstractmethod
    def send(self, part: bytes) -> None:
        """Send bytes that arrive together at the client."""

    @abstractmethod
    def restart(self) -> None:
        """Reset the volatile state; called when the power is back."""

    @abstractmethod
    def disconnect(self) -> None:
        """Close the device's ports."""

    def _run(self) -> None:
        sampled, powered = 0, True
        while not self._stopped.is_set():
            wait = max(self.instant(sampled) - time.monotonic(), MIN_SLEEP)
            asked = bool(select.select([self.line], [], [], wait)[0])
            before, powered = powered, self.is_powered()
            if powered and not before:
                self.clock, sampled = self.clock.begun(), 0
                self.delivery.forget()
                self.restart()
            if asked:
                self.answer()
            if powered:
                sampled = self._sample(sampled, time.monotonic())

    def _sample(self, first: int, now: float) -> int:
        """Send the samples that are due; return the number of the next one."""
        due = math.floor((self.clock.shown(now) - self.clock.offset_s) * self.rate_hz) + 1
        end = min(due, first + 1 + round(MAX_CATCH_UP_FACTOR * self.rate_hz * MIN_SLEEP))
        for sample in range(first, end):
            packet = self.packet(sample)
            if packet is not None:
                self.delivery.put(sample, packet, self.instant(sample))
        for part in self.delivery.take(now):
            self.send(part)
        return end
