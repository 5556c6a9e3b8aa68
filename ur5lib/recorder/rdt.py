"""ATI's Raw Data Transfer (RDT): requests to a Net F/T box and its records, over UDP.

Source: ATI Industrial Automation, Net F/T manual 9620-05-NET FT, "UDP Interface Using RDT" and
"System Status Code". All numbers are big-endian. A box streams one record per datagram; records
have no checksum of their own besides UDP's.
"""

import struct
from typing import Final

PORT = 49152
HIGHEST_RATE = 8000.0  # Hz; Net F/T boxes send up to 7000 records a second, Axia sensors 7812
SEQUENCE_BITS = 32
HEADER = 0x1234
STOP, STREAM, SET_BIAS = 0x0000, 0x0002, 0x0042  # commands; STREAM: one record per datagram
SATURATED, ERROR = 1 << 17, 1 << 31  # bits of the status: gauges saturated; any error

FIELDS: Final = ("rdt_sequence", "ft_sequence", "status")  # before the six counts
REQUEST = struct.Struct(">HHI")
RECORD = struct.Struct(">3I6i")


def request(command: int) -> bytes:
    """Return a request; STREAM: of records until STOP, whose count is zero."""
    return REQUEST.pack(HEADER, command, 0)


def decode(datagram: bytes) -> tuple[int, ...] | None:
    """Return the nine numbers of a record, FIELDS first; None for a datagram of another size.

    The last six are counts of Fx, Fy, Fz, Tx, Ty, Tz.
    """
    return RECORD.unpack(datagram) if len(datagram) == RECORD.size else None
