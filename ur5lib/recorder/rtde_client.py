"""A client of the controller's Real-Time Data Exchange (RTDE) that misses no package.

ur_rtde's receive interface is made for control: it keeps the newest package only, and its
constructor blocks all threads until a controller answers. A recorder needs every package with its
time of arrival.

Source: Universal Robots' guide to RTDE, protocol version 2. A package is its size (uint16), its
kind (uint8) and its content, big-endian; texts list variables separated by commas.
"""

import contextlib
import select
import socket
import struct
from collections.abc import Sequence

from ur5lib.errors import InputError
from ur5lib.recorder.arrivals import receive
from ur5lib.recorder.device import DeviceLost
from ur5lib.robots.rtde_variables import FORMATS, layout

PORT = 30004
PATIENCE = 3.0  # s, for the controller to answer
HEADER = struct.Struct(">HB")
PROTOCOL = 2
VERSION, SOFTWARE, SETUP_OUTPUTS, START, PAUSE, DATA = b"VvOSPU"


class RtdeClient:
    """A connection to one controller. software: major, minor, bugfix and build."""

    def __init__(self, address: str, port: int = PORT) -> None:
        """Connect. Raises InputError when no controller answers."""
        self._address, self._port = address, port
        self._buffer = b""
        try:
            self._socket = socket.create_connection((address, port), PATIENCE)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            if self._ask(VERSION, struct.pack(">H", PROTOCOL)) != b"\x01":
                raise ConnectionError("it does not speak version 2")
            major, minor, bugfix, build = struct.unpack(">4I", self._ask(SOFTWARE))
        except (OSError, struct.error) as error:
            raise self._no_answer(error) from error
        self.software = int(major), int(minor), int(bugfix), int(build)

    def start(self, names: Sequence[str], rate: float) -> list[str]:
        """Start data packages and return their outputs: those of `names` that the controller has.

        rate: [Hz]. Raises InputError when the controller refuses.
        """
        try:
            names, kinds = self._set_up(names, rate)
            if self._ask(START) != b"\x01":
                raise ConnectionError("it does not start")
        except OSError as error:
            raise self._no_answer(error) from error
        self._layout = layout(kinds)
        return names

    def receive(self, patience: float) -> list[tuple[float, tuple[float, ...]]]:
        """Return the packages that have arrived, after waiting at most `patience` [s].

        Each is the host's time.monotonic [s] at arrival, and the values of the outputs. Raises
        DeviceLost when the connection fails or the controller closes it.
        """
        if not select.select([self._socket], [], [], patience)[0]:
            return []
        arrived, data = receive(self._socket, self._address)
        self._buffer += data
        return [(arrived, package) for package in self._packages()]

    def close(self) -> None:
        """Stop the packages and close the connection."""
        with contextlib.suppress(OSError):
            self._socket.sendall(HEADER.pack(HEADER.size, PAUSE))
        self._socket.close()

    def _packages(self) -> list[tuple[float, ...]]:
        """Remove complete packages from the buffer, and return the numbers of data packages."""
        packages, start = [], 0
        while len(self._buffer) - start >= HEADER.size:
            size, kind = HEADER.unpack_from(self._buffer, start)
            if size < HEADER.size:
                raise DeviceLost(f"{self._address} does not send RTDE packages")
            if len(self._buffer) - start < size:
                break
            if kind == DATA and size == HEADER.size + 1 + self._layout.size:
                packages.append(self._layout.unpack_from(self._buffer, start + HEADER.size + 1))
            start += size
        self._buffer = self._buffer[start:]
        return packages

    def _set_up(self, names: Sequence[str], rate: float) -> tuple[list[str], list[str]]:
        """Request outputs; if the controller lacks some, request the others only."""
        for _ in range(2):
            content = struct.pack(">d", rate) + ",".join(names).encode()
            kinds = self._ask(SETUP_OUTPUTS, content)[1:].decode("ascii", "replace").split(",")
            available = [name for name, kind in zip(names, kinds, strict=False) if kind in FORMATS]
            if len(available) == len(names):
                return list(names), kinds
            names = available
        raise ConnectionError("it refuses outputs that it offered")

    def _ask(self, kind: int, content: bytes = b"") -> bytes:
        """Send a request and return the content of the answer to it."""
        self._socket.sendall(HEADER.pack(HEADER.size + len(content), kind) + content)
        while True:
            size, answered = HEADER.unpack(self._exactly(HEADER.size))
            answer = self._exactly(size - HEADER.size)
            if answered == kind:  # text messages may arrive first
                return answer

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            more = self._socket.recv(count - len(data))
            if not more:
                raise ConnectionError("it has closed the connection")
            data += more
        return data

    def _no_answer(self, error: Exception) -> InputError:
        return InputError(
            f"no controller answers by RTDE at {self._address}, port {self._port} ({error}); check "
            "that it is switched on and that its address is the one in the study"
        )
