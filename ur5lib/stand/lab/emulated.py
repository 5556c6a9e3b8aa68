"""The thread of an emulated device: sleeps until a sample is due or a request arrives."""

import select
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Self

from ur5lib.stand.lab.delivery import Delivery, Faults
from ur5lib.stand.lab.device_clock import DeviceClock, Drift
from ur5lib.timeseries.arrays import Array

NAP = 0.001  # s, shortest sleep: samples due meanwhile are sent together
HASTE = 3  # times the rate, at most, at which samples are sent after the computer was busy
Reading = Callable[[float], Array]  # of the host's monotonic time [s]


class Emulated(ABC):
    """A device that samples by its own clock and answers requests, while the context lasts.

    reading: returns the true reading at a time [s, the host's monotonic], at or shortly before the
    present; called in the device's thread. delivery: has the samples lost and late so far.
    """

    is_stream: bool

    def __init__(self, reading: Reading, rate_hz: float, drift: Drift, faults: Faults) -> None:
        self.reading, self.rate_hz = reading, rate_hz
        self.drift, self.faults = drift, faults
        self.delivery = Delivery(faults, self.is_stream)
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        """Switch on."""
        self._born = time.monotonic()
        self.clock = DeviceClock(self.rate_hz, self.drift)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Switch off and close the device's ports."""
        self._stopped.set()
        self._thread.join()
        self.disconnect()

    def is_powered(self) -> bool:
        """Return whether the device works; without power it neither sends nor answers."""
        return self.faults.powered(time.monotonic() - self._born)

    @abstractmethod
    def line(self) -> int:
        """Return the file descriptor from which requests are read."""

    @abstractmethod
    def answer(self) -> None:
        """Read and answer the requests that have arrived."""

    @abstractmethod
    def packet(self, sample: int) -> bytes | None:
        """Return the packet of a sample; None while no client asks for samples."""

    @abstractmethod
    def send(self, part: bytes) -> None:
        """Send bytes that arrive together."""

    @abstractmethod
    def restart(self) -> None:
        """Reset the volatile state; called when the power is back."""

    @abstractmethod
    def disconnect(self) -> None:
        """Close the device's ports."""

    def _run(self) -> None:
        sampled, powered = 0, True
        while not self._stopped.is_set():
            wait = max(self.clock.instant(sampled) - time.monotonic(), NAP)
            asked = bool(select.select([self.line()], [], [], wait)[0])
            before, powered = powered, self.is_powered()
            if powered and not before:
                self.clock, sampled = DeviceClock(self.rate_hz, self.drift), 0
                self.delivery.forget()
                self.restart()
            if asked:
                self.answer()
            if powered:
                sampled = self._sample(sampled, time.monotonic())

    def _sample(self, first: int, now: float) -> int:
        """Send the samples that are due; return the number of the next one."""
        count_max = 1 + round(HASTE * self.rate_hz * NAP)
        end = min(self.clock.count(now), first + count_max)
        for sample in range(first, end):
            packet = self.packet(sample)
            if packet is not None:
                self.delivery.put(sample, packet, self.clock.instant(sample))
        for part in self.delivery.take(now):
            self.send(part)
        return end
