"""The packets of a double on their way to a client, with faults of transmission."""

import heapq
import random
import time
from asyncio import StreamWriter
from dataclasses import dataclass

SECOND_PART_DELAY = 0.003  # s; between the parts of a split packet
MAX_BACKLOG_BYTES = 1 << 16  # unread bytes, above which a client gets no more packets


@dataclass(frozen=True)
class TransmissionFaults:
    """Faults of transmission that a double shall have: shares of packets, and a power cut.

    The first packet has no fault, each at most one. lost: never sent; late: sent late_s [s] later,
    by datagrams after their successors, by a stream before them; repeated: sent twice; split: sent
    in two parts, in streams only. dies_at, back_at: times at which the device loses and regains its
    power [s after it was switched on].
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
        """Return whether the device has power; age: time since it was switched on [s]."""
        dead = self.dies_at is not None and age >= self.dies_at
        return not dead or (self.back_at is not None and age >= self.back_at)


class Delivery:
    """The packets of a double in transmission.

    is_stream: bytes in order, as on a serial line; otherwise datagrams. lost: numbers of the
    samples that were never sent; late: numbers of the samples that arrived after a later one.
    Numbers restart when the device is switched on.
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
        """Put a sample's packet into transmission, to be sent at `when` [s, monotonic]."""
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
        """Remove and return the packets, or parts of them, that arrive until `now` [s,
        monotonic].
        """
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
        """Return the name of a randomly drawn fault for a packet, "" for none."""
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
    """The packets of a controller to one client, with faults of transmission."""

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
        """Send a packet without a fault, after those that are still in transmission."""
        self._writer.write(b"".join([*self._delivery.take(float("inf")), packet]))
