"""The controller's Real-Time Data Exchange (RTDE), port 30004.

Source: Universal Robots' guide to RTDE, protocol versions 1 and 2. A package is its size (uint16),
its kind (uint8) and its content, big-endian; texts list variables separated by commas.
"""

import asyncio
import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ur5lib.robots.rtde_variables import INPUTS, OUTPUTS, exists, layout, size
from ur5lib.stand.lab.connection import Connection
from ur5lib.stand.lab.control_box import ControlBox
from ur5lib.stand.lab.outputs import Outputs
from ur5lib.stand.lab.stream_faults import FaultyStream, StreamFaults

HEADER = struct.Struct(">HB")
VERSION, SOFTWARE, TEXT, DATA = b"VvMU"
SETUP_OUTPUTS, SETUP_INPUTS, START, PAUSE = b"OISP"
INFO = 2  # level of a text message
SOURCE = b"URControl"


@dataclass(frozen=True)
class Recipe:
    """The variables of a data package, in order.

    layout: of the package; casts: conversion of each number to its type.
    """

    names: list[str]
    sizes: list[int]
    layout: struct.Struct
    casts: list[type[int] | type[float]]


def recipe(names: list[str], kinds: list[str]) -> Recipe:
    """Return the recipe of variables of these types."""
    sizes = [size(kind) for kind in kinds]
    casts = [
        float if kind in ("DOUBLE", "VECTOR3D", "VECTOR6D") else int
        for kind, count in zip(kinds, sizes, strict=True)
        for _ in range(count)
    ]
    return Recipe(names, sizes, layout(kinds), casts)


class RtdeServer:
    """All RTDE clients of one controller."""

    def __init__(self, box: ControlBox, faults: StreamFaults, random: np.random.Generator) -> None:
        self.box, self._faults, self._random = box, faults, random
        self.clients: set[RtdeClient] = set()
        box.log.append(self._send_text)

    def connect(self) -> "RtdeClient":
        """Return the protocol of a new client."""
        return RtdeClient(self)

    def stream(self, transport: asyncio.Transport) -> FaultyStream:
        """Return the stream of a client."""
        return FaultyStream(transport, self._faults, self._random)

    def publish(self, cycle: int) -> None:
        """Send the outputs of a cycle, by its number, to the clients that are due."""
        for client in self.clients:
            client.publish(cycle)

    def claimed(self, name: str, by: "RtdeClient") -> bool:
        """Return whether another client writes an input."""
        return any(name in client.inputs for client in self.clients - {by})

    def _send_text(self, text: str) -> None:
        for client in self.clients:
            client.send_text(text)


class RtdeClient(Connection):
    """One client's connection."""

    def __init__(self, server: RtdeServer) -> None:
        super().__init__(server.box)
        self._server = server
        self._buffer, self._version, self._started = b"", 1, False
        self._outputs: Recipe | None = None
        self._every = 1  # cycles between data packages
        self._recipes: list[Recipe] = []
        self._answers: dict[int, Callable[[bytes], bytes]] = {
            VERSION: self._negotiate,
            SOFTWARE: lambda _: struct.pack(">4I", *self.box.software),
            SETUP_OUTPUTS: self._set_outputs,
            SETUP_INPUTS: self._set_inputs,
            START: self._start,
            PAUSE: self._pause,
        }

    @property
    def inputs(self) -> set[str]:
        """Return the inputs that this client writes."""
        return {name for entry in self._recipes for name in entry.names}

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin."""
        super().connection_made(transport)
        self._stream = self._server.stream(self.transport)
        self._server.clients.add(self)

    def connection_lost(self, _: Exception | None) -> None:
        """Forget the client."""
        super().connection_lost(_)
        self._server.clients.discard(self)

    def data_received(self, data: bytes) -> None:
        """Answer all complete packages."""
        self._buffer += data
        while len(self._buffer) >= HEADER.size:
            length, kind = HEADER.unpack_from(self._buffer)
            if length < HEADER.size:
                self.transport.abort()
                return
            if len(self._buffer) < length:
                return
            content, self._buffer = self._buffer[HEADER.size : length], self._buffer[length:]
            self._handle(kind, content)

    def publish(self, cycle: int) -> None:
        """Send the outputs of a cycle, if this client is due."""
        if self._outputs is None or not self._started or cycle % self._every:
            return
        content = _packed(self._outputs, self.box.outputs)
        self._stream.send(_package(DATA, b"\x01" * (self._version > 1) + content))

    def send_text(self, text: str) -> None:
        """Send a text message."""
        if self._started and self._version > 1:
            message = text.encode()[:255]
            parts = bytes([len(message)]), message, bytes([len(SOURCE)]), SOURCE, bytes([INFO])
            self._stream.flush()
            self.transport.write(_package(TEXT, b"".join(parts)))

    def _handle(self, kind: int, content: bytes) -> None:
        if kind == DATA:
            self._write_inputs(content)
        elif kind in self._answers:
            try:
                self.transport.write(_package(kind, self._answers[kind](content)))
            except (struct.error, OverflowError):  # a package that is cut, a frequency near zero
                self.transport.abort()

    def _negotiate(self, content: bytes) -> bytes:
        version = int.from_bytes(content, "big")
        accepted = version in (1, 2)
        self._version = version if accepted else self._version
        return bytes([accepted])

    def _set_outputs(self, content: bytes) -> bytes:
        frequency = 1 / self.box.cycle
        if self._version > 1:
            (frequency,), content = struct.unpack_from(">d", content), content[8:]
        names, software = _names(content), self.box.software[:2]
        kinds = [OUTPUTS[name] if exists(name, *software) else "NOT_FOUND" for name in names]
        accepted = "NOT_FOUND" not in kinds and frequency > 0
        self._outputs = recipe(names, kinds) if accepted else None
        self._every = max(1, round(1 / (self.box.cycle * frequency))) if accepted else 1
        return b"\x01" * (self._version > 1) + ",".join(kinds).encode()

    def _set_inputs(self, content: bytes) -> bytes:
        names = _names(content)
        kinds = [
            "IN_USE" if self._server.claimed(name, self) else INPUTS.get(name, "NOT_FOUND")
            for name in names
        ]
        accepted = not {"IN_USE", "NOT_FOUND"} & set(kinds)
        if accepted:
            self._recipes.append(recipe(names, kinds))
        return bytes([len(self._recipes) * accepted]) + ",".join(kinds).encode()

    def _start(self, _: bytes) -> bytes:
        self._started = self._outputs is not None
        return bytes([self._started])

    def _pause(self, _: bytes) -> bytes:
        self._started = False
        return b"\x01"

    def _write_inputs(self, content: bytes) -> None:
        """Write the inputs of a data package: the number of its recipe, then the values."""
        if not content or not 0 < content[0] <= len(self._recipes):
            return
        recipe = self._recipes[content[0] - 1]
        if len(content) - 1 != recipe.layout.size:
            return
        values = recipe.layout.unpack_from(content, 1)
        if len(values) == len(recipe.names):  # vectors are accepted, but no register is one
            self.box.registers.values.update(zip(recipe.names, values, strict=True))
        watchdog = self.box.watchdog
        if watchdog is not None and watchdog.name in recipe.names:
            watchdog.feed(self.box.time)


def _names(content: bytes) -> list[str]:
    return [name for name in content.decode("ascii", "replace").split(",") if name]


def _package(kind: int, content: bytes) -> bytes:
    return HEADER.pack(HEADER.size + len(content), kind) + content


def _packed(recipe: Recipe, outputs: Outputs) -> bytes:
    """Return outputs as a data package holds them; zero for those that are not emulated."""
    numbers: list[float] = []
    for name, count in zip(recipe.names, recipe.sizes, strict=True):
        value = outputs.get(name, 0.0)
        numbers += value.tolist() if isinstance(value, np.ndarray) else [value] * count
    return recipe.layout.pack(*[cast(n) for cast, n in zip(recipe.casts, numbers, strict=True)])
