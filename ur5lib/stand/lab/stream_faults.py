"""Faults of a controller's streams: packets that are late, split or lost."""

import asyncio
from dataclasses import dataclass

import numpy as np

REST = 0.001  # s, after which the second part of a split packet follows
BACKLOG = 1 << 16  # bytes unread by a client, beyond which it is sent no more


@dataclass(frozen=True)
class StreamFaults:
    """Shares of the packets (0 to 1): late (sent with the next one), split in two parts, or lost.

    TCP itself loses nothing: the controller never sends a lost packet.
    """

    late: float = 0.0
    split: float = 0.0
    lost: float = 0.0


class FaultyStream:
    """One client's stream of packets."""

    def __init__(
        self, transport: asyncio.Transport, faults: StreamFaults, random: np.random.Generator
    ) -> None:
        """random: generator that draws the packets hit."""
        self._transport, self._faults, self._random = transport, faults, random
        self._held = b""

    def send(self, packet: bytes) -> None:
        """Send a packet, unless a fault hits it or the client does not read."""
        drawn, faults = self._random.random(), self._faults
        if drawn < faults.lost or self._transport.get_write_buffer_size() > BACKLOG:
            return
        if drawn < faults.lost + faults.late:
            self._held += packet
            return
        data, self._held = self._held + packet, b""
        if drawn < faults.lost + faults.late + faults.split:
            middle = len(data) - len(packet) // 2
            self._transport.write(data[:middle])
            self._held = data[middle:]
            asyncio.get_running_loop().call_later(REST, self.flush)
        else:
            self._transport.write(data)

    def flush(self) -> None:
        """Send the delayed packets."""
        if self._held and not self._transport.is_closing():
            self._transport.write(self._held)
        self._held = b""
