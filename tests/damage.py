"""Damage to bytes on their way, drawn at random from a seed."""

import random

FAULTS = ["cut", "flip", "insert", "repeat", "drop"]


def damaged(data: bytes, draw: random.Random) -> bytes:
    """The bytes after one fault: truncated, a bit flipped, bytes inserted, repeated or dropped."""
    at = draw.randrange(len(data) + 1)
    length = draw.randint(1, 12)
    match draw.choice(FAULTS):
        case "cut":
            return data[:at]
        case "flip" if data:
            at = draw.randrange(len(data))
            return data[:at] + bytes([data[at] ^ 1 << draw.randrange(8)]) + data[at + 1 :]
        case "insert":
            # FA and FF, which start a message of Xbus, more often than by chance
            foreign = bytes(draw.choice([0xFA, 0xFF, draw.randrange(256)]) for _ in range(length))
            return data[:at] + foreign + data[at:]
        case "repeat":
            return data[:at] + data[max(at - length, 0) : at] + data[at:]
    return data[:at] + data[at + length :]
