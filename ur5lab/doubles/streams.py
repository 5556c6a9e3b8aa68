"""The controller's streams: RTDE, port 30004, and the realtime port 30003.

Source of RTDE: Universal Robots' guide to RTDE, protocol versions 1 and 2. A package is its size
(uint16), its kind (uint8) and its content, big-endian; texts list variables separated by commas.
"""

import struct
from asyncio import StreamReader, StreamWriter

import numpy as np

from ur5lab import rtde_variables as rtde
from ur5lab.doubles.control_box import ControlBox
from ur5lab.doubles.control_script import run_programs
from ur5lab.doubles.transmission import FaultyStream, TransmissionFaults
from ur5lab.rtde_variables import (
    INPUT_TYPES,
    OUTPUT_TYPES,
    PACKAGE_HEADER,
    STRUCT_FORMATS,
    exists,
    size,
)
from ur5lib.robots.realtime_message import encoded

INFO_LEVEL = 2  # level of a text message
TEXT_SOURCE = b"URControl"


def recipe(names: list[str], kinds: list[str]) -> np.dtype[np.void]:
    """Return the layout of an RTDE data package: variables of these names and types, big-endian,
    without padding.
    """
    pairs = zip(names, kinds, strict=True)
    return np.dtype([(name, ">" + STRUCT_FORMATS[kind][-1], (size(kind),)) for name, kind in pairs])


class RtdeServer:
    """The RTDE interface of one controller, with all its clients."""

    def __init__(self, box: ControlBox, faults: TransmissionFaults) -> None:
        self.box, self._faults = box, faults
        self.clients: set[RtdeConnection] = set()
        box.log.append(self._send_text)

    async def serve(self, reader: StreamReader, writer: StreamWriter) -> None:
        """Answer the packages of a client, and send it data, until it hangs up."""
        client = RtdeConnection(self, FaultyStream(writer, self._faults))
        self.clients.add(client)
        try:
            while True:
                length, kind = PACKAGE_HEADER.unpack(await reader.readexactly(PACKAGE_HEADER.size))
                client.handle(kind, await reader.readexactly(length - PACKAGE_HEADER.size))
        finally:
            self.clients.discard(client)

    def publish(self, cycle: int) -> None:
        """Send the outputs of a cycle to the clients for which it is time; cycle: its number."""
        for client in self.clients:
            client.publish(cycle)

    def claimed(self, name: str, by: "RtdeConnection") -> bool:
        """Return whether a client other than `by` writes an input."""
        return any(name in client.inputs for client in self.clients - {by})

    def _send_text(self, text: str) -> None:
        for client in self.clients:
            client.send_text(text)


class RtdeConnection:
    """The connection of one RTDE client."""

    def __init__(self, server: RtdeServer, stream: FaultyStream) -> None:
        self.box, self._server, self._stream = server.box, server, stream
        self._version, self._started = 1, False
        self._outputs: np.dtype[np.void] | None = None
        self._every = 1  # cycles between data packages
        self._recipes: list[np.dtype[np.void]] = []

    @property
    def inputs(self) -> set[str]:
        """Return the inputs that this client writes."""
        return {name for recipe in self._recipes for name in recipe.names or ()}

    def handle(self, kind: int, content: bytes) -> None:
        """Execute a client's package and answer it; kind: its type."""
        match kind:
            case rtde.DATA_PACKAGE:
                self._write_inputs(content)
                return
            case rtde.VERSION_PACKAGE:
                version = int.from_bytes(content, "big")
                accepted = version in (1, 2)
                self._version = version if accepted else self._version
                answer = bytes([accepted])
            case rtde.SOFTWARE_PACKAGE:
                answer = struct.pack(">4I", *self.box.software)
            case rtde.OUTPUTS_PACKAGE:
                answer = self._set_outputs(content)
            case rtde.INPUTS_PACKAGE:
                answer = self._set_inputs(content)
            case rtde.START_PACKAGE:
                self._started = self._outputs is not None
                answer = bytes([self._started])
            case rtde.PAUSE_PACKAGE:
                self._started, answer = False, b"\x01"
            case _:
                return
        self._stream.write(_package(kind, answer))

    def publish(self, cycle: int) -> None:
        """Send the outputs of a cycle, if it is time for this client; those not emulated are
        zero.
        """
        if self._outputs is None or not self._started or cycle % self._every:
            return
        row, outputs = np.zeros((), self._outputs), self.box.outputs
        for name in self._outputs.names or ():
            row[name] = outputs.get(name, 0.0)
        self._stream.send(
            _package(rtde.DATA_PACKAGE, b"\x01" * (self._version > 1) + row.tobytes())
        )

    def send_text(self, text: str) -> None:
        """Send a text message."""
        if self._started and self._version > 1:
            message = text.encode()[:255]
            source = bytes([len(TEXT_SOURCE)]) + TEXT_SOURCE
            parts = bytes([len(message)]), message, source, bytes([INFO_LEVEL])
            self._stream.write(_package(rtde.TEXT_PACKAGE, b"".join(parts)))

    def _set_outputs(self, content: bytes) -> bytes:
        frequency = 1 / self.box.cycle
        if self._version > 1:
            (frequency,), content = struct.unpack_from(">d", content), content[8:]
        names, software = _names(content), self.box.software[:2]
        kinds = [OUTPUT_TYPES[name] if exists(name, *software) else "NOT_FOUND" for name in names]
        accepted = "NOT_FOUND" not in kinds and frequency > 0
        self._outputs = recipe(names, kinds) if accepted else None
        self._every = max(1, round(1 / (self.box.cycle * frequency))) if accepted else 1
        return b"\x01" * (self._version > 1) + ",".join(kinds).encode()

    def _set_inputs(self, content: bytes) -> bytes:
        names = _names(content)
        kinds = [
            "IN_USE" if self._server.claimed(name, self) else INPUT_TYPES.get(name, "NOT_FOUND")
            for name in names
        ]
        accepted = not {"IN_USE", "NOT_FOUND"} & set(kinds)
        if accepted:
            self._recipes.append(recipe(names, kinds))
        return bytes([len(self._recipes) * accepted]) + ",".join(kinds).encode()

    def _write_inputs(self, content: bytes) -> None:
        """Write the values of a client's data package, which begins with its recipe's number, into
        the inputs.
        """
        if not content or not 0 < content[0] <= len(self._recipes):
            return
        recipe = self._recipes[content[0] - 1]
        if len(content) - 1 != recipe.itemsize:
            return
        row = np.frombuffer(content, recipe, offset=1)[0]
        written = self.box.registers.keys() & set(recipe.names or ())  # no register is a vector
        self.box.registers.update({name: row[name].item() for name in written})
        watchdog = self.box.watchdog
        if watchdog is not None and watchdog.name in written:
            watchdog.last = self.box.time


class RealtimeServer:
    """The realtime port with all its clients, which get each cycle's message and may send
    programs.
    """

    def __init__(self, box: ControlBox, size: int, faults: TransmissionFaults) -> None:
        """Take the controller; size: of the messages [bytes], which decides on their layout."""
        self._box, self._size, self._faults = box, size, faults
        self._streams: set[FaultyStream] = set()

    async def serve(self, reader: StreamReader, writer: StreamWriter) -> None:
        """Send messages to a client, and run its programs, until it hangs up."""
        stream = FaultyStream(writer, self._faults)
        self._streams.add(stream)
        try:
            await run_programs(self._box, reader)
        finally:
            self._streams.discard(stream)

    def publish(self) -> None:
        """Send the message of this cycle to all clients."""
        if self._streams:
            message = self.message()
            for stream in self._streams:
                stream.send(message)

    def message(self) -> bytes:
        """Return the message of this cycle."""
        outputs = self._box.outputs
        [message] = encoded(self._size, np.atleast_1d(outputs["timestamp"]), outputs)
        return message


def _names(content: bytes) -> list[str]:
    return [name for name in content.decode("ascii", "replace").split(",") if name]


def _package(kind: int, content: bytes) -> bytes:
    return PACKAGE_HEADER.pack(PACKAGE_HEADER.size + len(content), kind) + content
