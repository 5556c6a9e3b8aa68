"""An emulated device: its clock, faults of its transmission, and its thread."""

import heapq
import math
import random
import select
import threading
import time
from abc import ABC, abstractmethod
from asyncio import StreamWriter
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

from ur5lib.timeseries.arrays import Array

HOST = "127.0.0.1"
MIN_SLEEP = 0.001  # s, shortest sleep: samples due meanwhile are sent together
MAX_HASTE = 3  # times the rate, at most, at which samples are sent after the computer was busy
Reading = Callable[[float], Array]  # of the host's monotonic time [s]
SECOND_PART_DELAY = 0.003  # s, until the second part of a split packet follows
MAX_BACKLOG_BYTES = 1 << 16  # bytes unread by a client, beyond which it is sent no more


@dataclass(frozen=True)
class DeviceClock:
    """A device's clock: t_host = start + (1 + drift) (t_device − offset).

    offset_s: its time when the device is switched on [s]; drift_ppm: positive: slow; start: when
    the device is switched on [s, the host's time.monotonic].
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
        """Return the clock's time at a time of the host [s]."""
        return self.offset_s + (host - self.start) / self.scale


@dataclass(frozen=True)
class TransmissionFaults:
    """Shares of faulty packets (the first never is, each has at most one fault), and power cuts.

    lost: never sent; late: sent late_s [s] later, by datagrams after their successors, by a stream
    before them; repeated: sent twice; split: sent in two parts, in streams only. dies_at, back_at:
    times at which the device loses and regains its power [s after it was switched on].
    """

    lost: float = 0.0
    late: float = 0.0
    repeated: float = 0.0
    split: float = 0.0
    late_s: float = 0.02
    dies_at: float | None = None
    back_at: float | None = None
    seed: int = 1

    def powered(self, age: float) -> bool:
        """Return whether the device has power, at an age [s]."""
        dead = self.dies_at is not None and age >= self.dies_at
        return not dead or (self.back_at is not None and age >= self.back_at)


class Delivery:
    """The packets in transmission.

    is_stream: bytes in order, as on a serial line; otherwise datagrams. lost: numbers of the
    samples that were never sent; late: of those that arrived after a later one. Numbers restart
    when the device is switched on.
    """

    def __init__(self, faults: TransmissionFaults, is_stream: bool) -> None:
        self.lost: list[int] = []
        self.late: list[int] = []
        self._faults, self._is_stream = faults, is_stream
        self._random = random.Random(faults.seed)
        self._queue: list[tuple[float, int, int, bytes]] = []
        self._parts, self._furthest = 0, -1
        self._latest = 0.0

    def put(self, sample: int, packet: bytes, when: float) -> None:
        """Send a sample's packet at a time [s, monotonic]."""
        fault = self._draw() if self._parts else ""
        if fault == "lost":
            self.lost.append(sample)
            return
        half = len(packet) // 2
        self._enqueue(sample, packet[:half] if fault == "split" else packet, when, fault)
        if fault == "repeated":
            self._enqueue(sample, packet, when)
        if fault == "split":
            self._enqueue(sample, packet[half:], when + SECOND_PART_DELAY)

    def take(self, now: float) -> list[bytes]:
        """Return the packets, or parts of them, that arrive until then [s, monotonic]."""
        arrived = []
        while self._queue and self._queue[0][0] <= now:
            _, _, sample, part = heapq.heappop(self._queue)
            if sample < self._furthest:
                self.late.append(sample)
            self._furthest = max(self._furthest, sample)
            arrived.append(part)
        return arrived

    def forget(self) -> None:
        """Drop the packets in transmission; samples are counted anew."""
        self._queue.clear()
        self._furthest = -1

    def _draw(self) -> str:
        """Return the fault that hits a packet, or none."""
        names = ["lost", "late", "repeated", *(["split"] if self._is_stream else [])]
        shares = [getattr(self._faults, name) for name in names]
        [name] = self._random.choices([*names, ""], [*shares, 1 - sum(shares)])
        return name

    def _enqueue(self, sample: int, part: bytes, when: float, fault: str = "") -> None:
        when += self._faults.late_s if fault == "late" else 0.0
        if self._is_stream:  # later packets wait
            when = self._latest = max(when, self._latest)
        heapq.heappush(self._queue, (when, self._parts, sample, part))
        self._parts += 1


class FaultyStream:
    """The packets of a controller to one client."""

    def __init__(self, writer: StreamWriter, faults: TransmissionFaults) -> None:
        self._writer, self._delivery = writer, Delivery(faults, is_stream=True)

    def send(self, packet: bytes) -> None:
        """Send a packet, unless a fault hits it or the client does not read.

        Late packets and second parts of split ones are sent with a later packet.
        """
        if self._writer.transport.get_write_buffer_size() <= MAX_BACKLOG_BYTES:
            now = time.monotonic()
            self._delivery.put(0, packet, now)
            self._writer.write(b"".join(self._delivery.take(now)))

    def write(self, packet: bytes) -> None:
        """Send a packet that no fault hits, after those in transmission."""
        self._writer.write(b"".join([*self._delivery.take(float("inf")), packet]))


class DeviceDouble(ABC):
    """A device that samples by its own clock and answers requests, while the context lasts.

    reading: returns the true reading at a time [s, the host's monotonic], at or shortly before the
    present; called in the device's thread. delivery: has the samples lost and late so far. line:
    file descriptor from which requests are read.
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
        """Return whether the device works; without power it neither sends nor answers."""
        return self.faults.powered(time.monotonic() - self._born)

    def shown(self, sample: int) -> float:
        """Return the time of a sample, counted from 0, by the device's clock [s]."""
        return self.clock.offset_s + sample / self.rate_hz

    def instant(self, sample: int) -> float:
        """Return the host's time of a sample [s]."""
        return self.clock.host(self.shown(sample))

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
        end = min(due, first + 1 + round(MAX_HASTE * self.rate_hz * MIN_SLEEP))
        for sample in range(first, end):
            packet = self.packet(sample)
            if packet is not None:
                self.delivery.put(sample, packet, self.instant(sample))
        for part in self.delivery.take(now):
            self.send(part)
        return end
