"""An arm recorded from its controller's realtime port 30003, for controllers without RTDE."""

import contextlib
import socket
import struct
import time

import numpy as np

from ur5lab.recorder.device import (
    ANSWER_TIMEOUT,
    MAX_SILENCE,
    CycleCounter,
    Identity,
    Packets,
    Silence,
    answering,
    receive,
)
from ur5lib.robots.realtime_message import SOFTWARE_BY_SIZE

PORT = 30003
MESSAGE_HEAD = struct.Struct(">id")  # size and timestamp of a message
READ_TIMEOUT = 0.1  # s; of one call
MIN_CYCLE = 1e-4  # s; shorter than that of any controller


class RealtimeArm:
    """The arm at an address, recorded as packets of bytes for the format `realtime-stream`."""

    columns: tuple[str, ...] = ("payload_hex",)

    def __init__(self, address: str, port: int = PORT) -> None:
        """Connect to the controller. Raises InputError also where its messages have an unknown
        layout.
        """
        self._address = address
        with answering("its stream", address, port) as self._socket:
            self._size, first, second = self._peek()
        cycle = second - first
        self._rest, self._cycles = b"", CycleCounter(cycle, first - cycle)
        self._silence = Silence(address)
        self.identity = Identity(
            model="Universal Robots controller, realtime port",
            address=address,
            firmware=SOFTWARE_BY_SIZE[self._size],
            rate_hz=round(1 / cycle),
            message_bytes=self._size,
            units="SI",
            clock="timestamp",
        )

    def read(self) -> Packets:
        """Return the bytes since the last call, as `Device.read`."""
        arrived, data = receive(self._socket, self._address, READ_TIMEOUT)
        self._silence.check(len(data))
        if not data:
            return Packets(np.zeros(0), [], 0, 0)
        return Packets(np.array([arrived]), [data], *self._count(data))

    def close(self) -> None:
        """Close the connection."""
        with contextlib.suppress(OSError):
            self._socket.close()

    def _peek(self) -> tuple[int, float, float]:
        """Return the messages' size [bytes] and the first two timestamps [s]; the messages stay to
        be read.
        """
        (size, _) = MESSAGE_HEAD.unpack(self._ahead(MESSAGE_HEAD.size))
        if size not in SOFTWARE_BY_SIZE:
            raise ConnectionError(f"the layout of its messages of {size} bytes is unknown")
        both = self._ahead(size + MESSAGE_HEAD.size)
        first, second = MESSAGE_HEAD.unpack_from(both)[1], MESSAGE_HEAD.unpack_from(both, size)[1]
        if not MIN_CYCLE < second - first < MAX_SILENCE:
            raise ConnectionError("its messages have no timestamps")
        return size, first, second

    def _ahead(self, count: int) -> bytes:
        """Return the next bytes and leave them in the socket."""
        until = time.monotonic() + ANSWER_TIMEOUT
        while len(data := self._socket.recv(count, socket.MSG_PEEK)) < count:
            if not data or time.monotonic() > until:
                raise ConnectionError("it does not send")
            time.sleep(0.001)
        return data

    def _count(self, data: bytes) -> tuple[int, int]:
        """Return how many messages are complete, and how many are missing before or among them."""
        stream, at, stamps = self._rest + data, 0, list[float]()
        while len(stream) - at >= self._size:
            size, stamp = MESSAGE_HEAD.unpack_from(stream, at)
            if size != self._size:  # damaged; repaired when the recording is read
                at = len(stream)
                break
            stamps.append(stamp)
            at += size
        self._rest = stream[at:]
        return len(stamps), self._cycles.lost(np.array(stamps))
