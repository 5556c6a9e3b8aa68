"""The controller's realtime port 30003: messages of fixed layout to every client, every cycle."""

import asyncio

import numpy as np

from ur5lib.robots.realtime_message import fields
from ur5lib.stand.lab.control_box import ControlBox
from ur5lib.stand.lab.script_port import ScriptClient
from ur5lib.stand.lab.stream_faults import FaultyStream, StreamFaults

STAMP = 4  # first byte of the controller's time


class RealtimeServer:
    """All clients of the realtime port, which may also send programs."""

    def __init__(
        self, box: ControlBox, size: int, faults: StreamFaults, random: np.random.Generator
    ) -> None:
        """size: of the messages [bytes], which decides on their layout."""
        self._box, self._size, self._faults, self._random = box, size, faults, random
        self._fields = fields(size) | {"timestamp": (STAMP, 1)}
        self.streams: set[FaultyStream] = set()

    def connect(self) -> "RealtimeClient":
        """Return the protocol of a new client."""
        return RealtimeClient(self._box, self)

    def stream(self, transport: asyncio.Transport) -> FaultyStream:
        """Return the stream of a client."""
        return FaultyStream(transport, self._faults, self._random)

    def publish(self) -> None:
        """Send the state of this cycle."""
        if self.streams:
            message = self.message()
            for stream in self.streams:
                stream.send(message)

    def message(self) -> bytes:
        """Return the state of this cycle: int32 size, then big-endian doubles."""
        doubles = np.zeros((self._size - 4) // 8, ">f8")
        for name, (first_byte, count) in self._fields.items():
            place = (first_byte - 4) // 8
            doubles[place : place + count] = self._box.outputs.get(name, 0.0)
        return self._size.to_bytes(4, "big") + doubles.tobytes()


class RealtimeClient(ScriptClient):
    """One client's connection."""

    def __init__(self, box: ControlBox, server: RealtimeServer) -> None:
        super().__init__(box)
        self._server = server

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin to send."""
        super().connection_made(transport)
        self._stream = self._server.stream(self.transport)
        self._server.streams.add(self._stream)

    def connection_lost(self, _: Exception | None) -> None:
        """Forget the client."""
        super().connection_lost(_)
        self._server.streams.discard(self._stream)
