"""Xbus, the protocol of Xsens motion trackers, at a serial port.

A message is FA FF, identifier, length, data, checksum. The length is one byte, or FF and two bytes
for 255 bytes of data and more. All bytes after FA, the checksum included, add up to a multiple of
256. Source: Xsens, MT Low-Level Communication Protocol Documentation, "Message structure"
and "Message reference".
"""

import contextlib
import time
from collections import deque
from typing import NamedTuple

from ur5lib.errors import InputError
from ur5lib.recorder.device import DeviceLost

START = b"\xfa\xff"  # preamble, and the bus identifier of a device that is connected directly
LONGEST = 2048  # bytes of data in a message
EXTENDED = 0xFF  # the length byte that announces two more
ERROR = 0x42  # identifier of the answer to a request that the device does not know or accept
WAIT = 0.02  # s, for which one call waits for bytes
ANSWER = 0.5  # s, for an acknowledgement
ATTEMPTS = 4  # requests that arrive while the device starts are lost


class Message(NamedTuple):
    """A message: its identifier and its data."""

    identifier: int
    data: bytes


def encode(identifier: int, data: bytes = b"") -> bytes:
    """Return the bytes of a message."""
    size = len(data)
    length = bytes([size]) if size < EXTENDED else bytes([EXTENDED, *size.to_bytes(2, "big")])
    body = START[1:] + bytes([identifier]) + length + data
    return START[:1] + body + bytes([-sum(body) % 256])


class Decoder:
    """Finds the messages in bytes that arrive piece by piece.

    After a wrong checksum or an impossible length, the search goes on at the next FA FF, so that
    only damaged messages are lost.
    """

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[Message]:
        """Return the messages that these bytes complete."""
        stream, messages, at = self._rest + data, [], 0
        while (at := _start(stream, at)) < len(stream):
            end = _end(stream, at)
            if end > len(stream):
                break
            if sum(stream[at + 1 : end]) % 256 == 0 and end > at + 4:
                head = 6 if stream[at + 3] == EXTENDED else 4
                messages.append(Message(stream[at + 2], stream[at + head : end - 1]))
                at = end
            else:
                at += 1
        self._rest = stream[at:]
        return messages


def _start(stream: bytes, at: int) -> int:
    """Return the offset of the next FA FF, or of an FA at the end; else the stream's length."""
    place = stream.find(START, at)
    if place >= 0:
        return place
    return len(stream) - int(stream.endswith(START[:1]) and len(stream) > at)


def _end(stream: bytes, at: int) -> int:
    """Return the end of the message that starts at an offset; the offset if it is no message.

    The end is beyond the stream's length while the message is incomplete.
    """
    if len(stream) < at + 4:
        return len(stream) + 1
    if stream[at + 3] != EXTENDED:
        return at + 5 + stream[at + 3]
    if len(stream) < at + 6:
        return len(stream) + 1
    size = int.from_bytes(stream[at + 4 : at + 6], "big")
    return at + 7 + size if EXTENDED <= size <= LONGEST else at


class RefusedError(Exception):
    """The device does not know a request, or does not accept its data."""


class XbusPort:
    """The messages of a device at a serial port."""

    def __init__(self, path: str, baudrate: int) -> None:
        """Open the port. Raises InputError when that fails."""
        import serial

        self._path = path
        self._decoder = Decoder()
        self._early: deque[Message] = deque()
        try:
            self._port = serial.Serial(path, baudrate, timeout=WAIT, write_timeout=ANSWER)
        except (OSError, ValueError) as error:  # SerialException is an OSError
            raise InputError(
                f"the IMU's serial port {path} cannot be opened; check the cable, the port and "
                f"baudrate in the study, and the permissions of {path}"
            ) from error

    def ask(self, request: int, data: bytes = b"") -> bytes:
        """Return the data of a request's acknowledgement, which is the next higher identifier.

        Raises RefusedError when the device answers with an error, InputError when not at all.
        """
        try:
            for _ in range(ATTEMPTS):
                self._port.write(encode(request, data))
                answer = self._answer(request)
                if answer is not None:
                    return answer
        except (OSError, DeviceLost):
            pass
        raise InputError(
            f"no Xsens motion tracker answers at {self._path}; check its power, the port and the "
            "baudrate in the study"
        )

    def send(self, request: int) -> None:
        """Send a request without waiting for its answer; does nothing when the device has gone."""
        with contextlib.suppress(OSError):
            self._port.write(encode(request))
            self._port.flush()

    def receive(self) -> list[Message]:
        """Return the messages that have arrived, after waiting at most 0.02 s for the first byte.

        Raises DeviceLost when the port has gone.
        """
        messages = [*self._early]
        self._early.clear()
        try:
            data = self._port.read(max(1, self._port.in_waiting))
        except OSError as error:
            raise DeviceLost(f"the serial port {self._path} of the IMU has gone") from error
        return messages + self._decoder.feed(data)

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    def _answer(self, request: int) -> bytes | None:
        """Return the acknowledgement's data, None if it is late; skip data messages before it."""
        until = time.monotonic() + ANSWER
        while time.monotonic() < until:
            messages = self.receive()
            for number, message in enumerate(messages):
                if message.identifier == ERROR:
                    raise RefusedError
                if message.identifier == request + 1:
                    self._early.extend(messages[number + 1 :])
                    return message.data
        return None
