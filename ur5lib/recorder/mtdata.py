"""Measurements of Xsens motion trackers: the data of MTData2 and of the older MTData messages.

Units as sent: acceleration [m/s²], rate of turn [rad/s], magnetic field [arbitrary units, about 1
in the Earth's field], in the tracker's axes. Sources: Xsens, MT Low-Level Communication Protocol
Documentation, "MTData2" (data identifiers, precisions) and, for the older MTi, "MTData message",
"SetOutputMode" and "SetOutputSettings".
"""

import math
import struct
from typing import Final, NamedTuple

MTDATA, MTDATA2 = 0x32, 0x36  # identifiers of the messages
COUNTER_BITS = 16

# Data identifiers of MTData2; the last four bits are precision and axes.
PACKET_COUNTER, SAMPLE_TIME_FINE = 0x1020, 0x1060
ACCELERATION, RATE_OF_TURN, MAGNETIC_FIELD = 0x4020, 0x8020, 0xC020
VECTORS: Final = (ACCELERATION, RATE_OF_TURN, MAGNETIC_FIELD)
PRECISION, GROUP = 0x3, 0xFFF0

# Three numbers in each precision: float32, fixed point 12.20 and 16.32, float64.
LAYOUTS: Final = (">3f", ">3i", ">IhIhIh", ">3d")

# Output mode and settings of MTData, and its samples under them: three vectors and the counter.
CALIBRATED, SAMPLE_COUNTER = 0x2, 0x1
SAMPLE = struct.Struct(">9fH")

Vector = tuple[float, ...]
NOTHING: Final = (math.nan, math.nan, math.nan)


class Measurement(NamedTuple):
    """One sample; quantities that a message does not contain are NaN.

    time_fine: the device's own time [ticks of 0.1 ms]; vectors: acceleration [m/s²], rate of turn
    [rad/s] and magnetic field [arbitrary units] (9,), axes of the tracker.
    """

    counter: int
    time_fine: float
    vectors: Vector


def decode_mtdata2(data: bytes) -> Measurement | None:
    """Return the sample in an MTData2 message; None without a packet counter or if inconsistent."""
    items = _items(data)
    counter = items.get(PACKET_COUNTER, (0, b""))[1]
    fine = items.get(SAMPLE_TIME_FINE, (0, b""))[1]
    vectors = [_vector(*items[name]) if name in items else NOTHING for name in VECTORS]
    whole = [vector for vector in vectors if vector is not None]
    if len(counter) != 2 or len(fine) not in (0, 4) or len(whole) < len(vectors):
        return None
    time = float(int.from_bytes(fine, "big")) if fine else math.nan
    return Measurement(int.from_bytes(counter, "big"), time, sum(whole, ()))


def decode_mtdata(data: bytes) -> Measurement | None:
    """Return the sample in an MTData message of CALIBRATED data with the SAMPLE_COUNTER.

    None for a message of another size, as other settings have.
    """
    if len(data) != SAMPLE.size:
        return None
    *numbers, counter = SAMPLE.unpack(data)
    return Measurement(counter, math.nan, tuple(numbers))


def _items(data: bytes) -> dict[int, tuple[int, bytes]]:
    """Return precision and bytes of each item of an MTData2 message; none if lengths disagree."""
    items, at = {}, 0
    while at + 3 <= len(data):
        name = int.from_bytes(data[at : at + 2], "big")
        end = at + 3 + data[at + 2]
        items[name & GROUP] = name & PRECISION, data[at + 3 : end]
        at = end
    return items if at == len(data) else {}


def _vector(precision: int, data: bytes) -> Vector | None:
    """Return three numbers; None if the bytes are too few or too many for the precision."""
    if len(data) != struct.calcsize(LAYOUTS[precision]):
        return None
    sent = struct.unpack(LAYOUTS[precision], data)
    if precision == 1:
        return tuple(number / 2**20 for number in sent)
    if precision == 2:  # the 32 bits after the point come first
        pairs = zip(sent[::2], sent[1::2], strict=True)
        return tuple(whole + part / 2**32 for part, whole in pairs)
    return sent
