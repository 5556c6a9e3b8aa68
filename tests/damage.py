"""Damage to files and streams: what a disk, a network, a cable or a crash does to bytes.

Hypothesis draws it, `DAMAGED=3000 pytest ...` more of it. Damage that nothing in a file tells from
good data is left out: a number that changed within what an arm may do, and blocks that hold good
data of another place.
"""

import os
import random
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from ur5lib.recordings.intake import Intake

DRAWS = st.randoms(use_true_random=True)  # of which Hypothesis draws the seed
FLIPPED = 7  # bytes at most
FAR = 0.15  # share of a channel's span that filled or resampled values may be off by
FLAGS = ("time", "segment", "interpolated")
PAGE = b"<html><body>404 not found</body></html>\n"  # where a download failed
STREAM_FAULTS = ["cut", "flip", "insert", "repeat", "drop"]


class Damaged(NamedTuple):
    """Bytes after a fault; in_place: whether it changed bytes and moved none."""

    fault: str
    data: bytes
    in_place: bool


def drawn(usual: int) -> settings:
    """Let a test draw the same `usual` examples each time, or as many others as DAMAGED says."""
    wanted = os.environ.get("DAMAGED")
    return settings(
        max_examples=int(wanted or usual),
        derandomize=wanted is None,
        deadline=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )


def damaged_stream(data: bytes, draw: random.Random) -> bytes:
    """A stream after one fault: truncated, a bit flipped, bytes inserted, repeated or dropped."""
    at = draw.randrange(len(data) + 1)
    length = draw.randint(1, 12)
    match draw.choice(STREAM_FAULTS):
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


def _flipped_head(data: bytes, draw: random.Random) -> bytes:
    """Other bytes among the first thousands, which say how a file is built."""
    changed = bytearray(data)
    for _ in range(draw.randint(1, FLIPPED)):
        changed[draw.randrange(min(len(data), 3000))] = draw.randrange(256)
    return bytes(changed)


def _block(data: bytes, draw: random.Random, sizes: list[int], zero: bool) -> bytes:
    """A block that was never written, or holds random bytes."""
    size = draw.choice(sizes)
    start = draw.randrange(len(data)) // size * size
    size = min(size, len(data) - start)
    return data[:start] + (bytes(size) if zero else draw.randbytes(size)) + data[start + size :]


def _moved(data: bytes, draw: random.Random, more: bool) -> bytes:
    """Bytes missing, or too many, inside."""
    start, size = draw.randrange(len(data)), draw.randint(1, 5000)
    return data[:start] + (draw.randbytes(size) + data[start:] if more else data[start + size :])


FILE_FAULTS: dict[str, tuple[float, Callable[[bytes, random.Random], bytes]]] = {  # by weight
    "cut": (5, lambda data, draw: data[: draw.randrange(len(data))]),
    "zeroed": (5, lambda data, draw: _block(data, draw, [64, 512, 4096, 16384], zero=True)),
    "garbled": (5, lambda data, draw: _block(data, draw, [16, 512, 4096], zero=False)),
    "flipped head": (5, _flipped_head),
    "lost": (3, lambda data, draw: _moved(data, draw, more=False)),
    "inserted": (3, lambda data, draw: _moved(data, draw, more=True)),
    "text": (0.5, lambda _, draw: PAGE * draw.randint(1, 8)),
    "nothing": (0.3, lambda *_: b""),
}


def damaged_file(data: bytes, draw: random.Random) -> Damaged:
    """The contents of a file after one fault."""
    (fault,) = draw.choices([*FILE_FAULTS], [weight for weight, _ in FILE_FAULTS.values()])
    return Damaged(fault, FILE_FAULTS[fault][1](data, draw), fault in ("garbled", "flipped head"))


def findings(taken: Intake) -> set[tuple[str, int, str]]:
    return {(f.code, f.count, f.device) for f in taken.quality.findings}


def compare(
    robot: pd.DataFrame, whole: pd.DataFrame, start: float = 0.0, exact: bool = True
) -> tuple[int, int]:
    """Cells that differ from the undamaged recording's at their time, and frames fewer.

    start: how much later its clock starts [s]. Cells that are told as filled, or lie between the
    undamaged recording's times, may differ some; all where they are not exact.
    """
    time, at = robot["time"].to_numpy() + start, whole["time"].to_numpy()
    period = float(np.median(np.diff(at)))
    outside = (time < at[0] - period) | (time > at[-1] + period)
    nearest = np.abs(np.interp(time, at, np.arange(len(at))) % 1 - 0.5) > 0.499
    wrong = int(outside.sum())
    channels = [name for name in whole if name not in FLAGS and not name.startswith("filled_")]
    for name in set(channels) & set(robot):
        values = whole[name].to_numpy(float)
        truth = np.interp(time, at, values)
        loose = FAR * np.ptp(values) + 5 * np.std(np.diff(values)) + 1e-3
        flag = f"filled_{name.rpartition('_')[0]}"
        filled = robot[flag].to_numpy(bool) if flag in robot else np.zeros(len(robot), dtype=bool)
        tolerance = np.where(filled | ~nearest | (not exact), loose, 1e-5)
        wrong += int((~(np.abs(robot[name].to_numpy() - truth) <= tolerance) & ~outside).sum())
    missing = len(set(channels) - set(robot))
    return wrong, max(0, len(whole) - len(robot)) + len(whole) * missing
