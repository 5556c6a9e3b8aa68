"""The controller's realtime port 30003: messages of fixed layout to every client, every cycle."""

from asyncio import StreamReader, StreamWriter

import numpy as np

from ur5lib.robots.realtime_message import fields
from ur5lib.stand.lab.control_box import ControlBox
from ur5lib.stand.lab.control_script import run_programs
from ur5lib.stand.lab.delivery import Faults, FaultyStream

STAMP = 4  # first byte of the controller's time


class RealtimeServer:
    """All clients of the realtime port, which may also send programs."""

    def __init__(self, box: ControlBox, size: int, faults: Faults) -> None:
        """size: of the messages [bytes], which decides on their layout."""
        self._box, self._size, self._faults = box, size, faults
        self._fields = fields(size) | {"timestamp": (STAMP, 1)}
        self._streams: set[FaultyStream] = set()

    async def serve(self, reader: StreamReader, writer: StreamWriter) -> None:
        """Send to a client, and run its programs, until it hangs up."""
        stream = FaultyStream(writer, self._faults)
        self._streams.add(stream)
        try:
            await run_programs(self._box, reader)
        finally:
            self._streams.discard(stream)

    def publish(self) -> None:
        """Send the state of this cycle."""
        if self._streams:
            message = self.message()
            for stream in self._streams:
                stream.send(message)

    def message(self) -> bytes:
        """Return the state of this cycle: int32 size, then big-endian doubles."""
        doubles = np.zeros((self._size - 4) // 8, ">f8")
        for name, (first_byte, count) in self._fields.items():
            place = (first_byte - 4) // 8
            doubles[place : place + count] = self._box.outputs.get(name, 0.0)
        return self._size.to_bytes(4, "big") + doubles.tobytes()
