"""Xbus, the framing of Xsens motion trackers: messages in a stream of bytes.

A message is FA FF, identifier, length, data, checksum. The length is one byte, or FF and two bytes
for 255 bytes of data and more. All bytes after FA, the checksum included, add up to a multiple of
256. Source: Xsens, MT Low-Level Communication Protocol Documentation, "Message structure".
"""

from typing import NamedTuple

START = b"\xfa\xff"  # preamble, and the bus identifier of a device that is connected directly
LONGEST = 2048  # bytes of data in a message
EXTENDED = 0xFF  # the length byte that announces two more


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
                messages.append(_message(stream[at:end]))
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


def _message(packet: bytes) -> Message:
    return Message(packet[2], packet[6 if packet[3] == EXTENDED else 4 : -1])
