"""Xbus, the protocol of Xsens motion trackers, at a serial port: messages, and samples in them.

A message is FA FF, identifier, length, data, checksum. The length is one byte, or FF and two bytes
for 255 bytes of data and more. All bytes after FA, the checksum included, add up to a multiple of
256. Samples are the data of MTData2 and of the older MTData messages, in units as sent:
acceleration [m/s²], rate of turn [rad/s], magnetic field [arbitrary units, about 1 in the Earth's
field], in the tracker's axes. Sources: Xsens, MT Low-Level Communication Protocol Documentation,
"Message structure", "Message reference", "MTData2" (data identifiers, precisions) and, for the
older MTi, "MTData message", "SetOutputMode" and "SetOutputSettings".
"""

import contextlib
import math
import struct
import time
from collections import deque
from typing import Final, NamedTuple

from ur5lab.recorder.device import DeviceLost, of_recorder
from ur5lib.errors import InputError

PREAMBLE = b"\xfa\xff"  # preamble, and the bus identifier of a device that is connected directly
MAX_DATA_BYTES = 2048  # bytes of data in a message
EXTENDED_LENGTH = 0xFF  # the length byte that announces two more
ERROR_MESSAGE = 0x42  # identifier of the answer to a request that is unknown or not accepted
READ_TIMEOUT = 0.02  # s; for bytes in one call
ACKNOWLEDGEMENT_TIMEOUT = 0.5  # s
REQUEST_ATTEMPTS = 4  # requests that arrive while the device starts are lost

MTDATA, MTDATA2 = 0x32, 0x36  # identifiers of the messages
COUNTER_BITS = 16

# Data identifiers of MTData2; the last four bits are precision and axes.
PACKET_COUNTER, SAMPLE_TIME_FINE = 0x1020, 0x1060
ACCELERATION, RATE_OF_TURN, MAGNETIC_FIELD = 0x4020, 0x8020, 0xC020
VECTORS: Final = (ACCELERATION, RATE_OF_TURN, MAGNETIC_FIELD)
PRECISION_MASK, ITEM_MASK = 0x3, 0xFFF0

# Three numbers in each precision: float32, fixed point 12.20 and 16.32, float64.
VECTOR_LAYOUTS: Final = (">3f", ">3i", ">IhIhIh", ">3d")

# Output mode and settings of MTData, and its samples under them: three vectors and the counter.
CALIBRATED_MODE, SAMPLE_COUNTER = 0x2, 0x1
MTDATA_SAMPLE = struct.Struct(">9fH")

Vector = tuple[float, ...]
MISSING_VECTOR: Final = (math.nan, math.nan, math.nan)


class Message(NamedTuple):
    """A message: its identifier and its data."""

    identifier: int
    data: bytes


def encode(identifier: int, data: bytes = b"") -> bytes:
    """Return the bytes of a message."""
    size = len(data)
    is_short = size < EXTENDED_LENGTH
    length = bytes([size]) if is_short else bytes([EXTENDED_LENGTH, *size.to_bytes(2, "big")])
    body = PREAMBLE[1:] + bytes([identifier]) + length + data
    return PREAMBLE[:1] + body + bytes([-sum(body) % 256])


class Decoder:
    """A decoder that finds the messages in bytes which arrive piece by piece.

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
                head = 6 if stream[at + 3] == EXTENDED_LENGTH else 4
                messages.append(Message(stream[at + 2], stream[at + head : end - 1]))
                at = end
            else:
                at += 1
        self._rest = stream[at:]
        return messages


def _start(stream: bytes, at: int) -> int:
    """Return the offset of the next FA FF, or of an FA at the end; else the stream's length."""
    place = stream.find(PREAMBLE, at)
    if place >= 0:
        return place
    return len(stream) - int(stream.endswith(PREAMBLE[:1]) and len(stream) > at)


def _end(stream: bytes, at: int) -> int:
    """Return the end of the message that starts at an offset; the offset if it is no message.

    The end is beyond the stream's length while the message is incomplete.
    """
    if len(stream) < at + 4:
        return len(stream) + 1
    if stream[at + 3] != EXTENDED_LENGTH:
        return at + 5 + stream[at + 3]
    if len(stream) < at + 6:
        return len(stream) + 1
    size = int.from_bytes(stream[at + 4 : at + 6], "big")
    return at + 7 + size if EXTENDED_LENGTH <= size <= MAX_DATA_BYTES else at


class ImuSample(NamedTuple):
    """One sample of a motion tracker; quantities that a message does not contain are NaN.

    time_fine: the device's own time [ticks of 0.1 ms]; vectors: acceleration [m/s²], rate of turn
    [rad/s] and magnetic field [arbitrary units] (9,), axes of the tracker.
    """

    counter: int
    time_fine: float
    vectors: Vector


def decode_mtdata2(data: bytes) -> ImuSample | None:
    """Return the sample in an MTData2 message; None without a packet counter or if inconsistent."""
    items = _items(data)
    counter = items.get(PACKET_COUNTER, (0, b""))[1]
    fine = items.get(SAMPLE_TIME_FINE, (0, b""))[1]
    vectors = [_vector(*items[name]) if name in items else MISSING_VECTOR for name in VECTORS]
    whole = [vector for vector in vectors if vector is not None]
    if len(counter) != 2 or len(fine) not in (0, 4) or len(whole) < len(vectors):
        return None
    time = float(int.from_bytes(fine, "big")) if fine else math.nan
    return ImuSample(int.from_bytes(counter, "big"), time, sum(whole, ()))


def decode_mtdata(data: bytes) -> ImuSample | None:
    """Return the sample in an MTData message of CALIBRATED_MODE data with the SAMPLE_COUNTER.

    None for a message of another size, as other settings have.
    """
    if len(data) != MTDATA_SAMPLE.size:
        return None
    *numbers, counter = MTDATA_SAMPLE.unpack(data)
    return ImuSample(counter, math.nan, tuple(numbers))


def _items(data: bytes) -> dict[int, tuple[int, bytes]]:
    """Return, by identifier, precision and bytes of each item of an MTData2 message; empty if
    lengths disagree.
    """
    items, at = {}, 0
    while at + 3 <= len(data):
        name = int.from_bytes(data[at : at + 2], "big")
        end = at + 3 + data[at + 2]
        items[name & ITEM_MASK] = name & PRECISION_MASK, data[at + 3 : end]
        at = end
    return items if at == len(data) else {}


def _vector(precision: int, data: bytes) -> Vector | None:
    """Return three numbers; None if the bytes are too few or too many for the precision."""
    if len(data) != struct.calcsize(VECTOR_LAYOUTS[precision]):
        return None
    sent = struct.unpack(VECTOR_LAYOUTS[precision], data)
    if precision == 1:
        return tuple(number / 2**20 for number in sent)
    if precision == 2:  # the 32 bits after the point come first
        pairs = zip(sent[::2], sent[1::2], strict=True)
        return tuple(whole + part / 2**32 for part, whole in pairs)
    return sent


class RefusedError(Exception):
    """Raised where the device does not know a request, or does not accept its data."""


class XbusPort:
    """The messages of a device at a serial port."""

    def __init__(self, path: str, baudrate: int) -> None:
        """Open the port. Raises InputError when that fails, or pyserial is not installed."""
        serial = of_recorder("serial", "reading the IMU")
        self._path = path
        self._decoder = Decoder()
        self._early: deque[Message] = deque()
        try:
            self._port = serial.Serial(
                path, baudrate, timeout=READ_TIMEOUT, write_timeout=ACKNOWLEDGEMENT_TIMEOUT
            )
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
            for _ in range(REQUEST_ATTEMPTS):
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
        """Return the data of the acknowledgement to a request, None if it is late; data messages
        before it are skipped.
        """
        until = time.monotonic() + ACKNOWLEDGEMENT_TIMEOUT
        while time.monotonic() < until:
            messages = self.receive()
            for number, message in enumerate(messages):
                if message.identifier == ERROR_MESSAGE:
                    raise RefusedError
                if message.identifier == request + 1:
                    self._early.extend(messages[number + 1 :])
                    return message.data
        return None
