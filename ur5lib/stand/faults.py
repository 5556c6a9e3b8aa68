"""What goes wrong while a recording is made: in the frames, in the stream, in the files."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from ur5lib.stand.plan import Faults
from ur5lib.timeseries.arrays import Array, Mask

BUFFER = 4096  # bytes; what had not filled one was never written
LATE, SPLIT, REST = 3, 694, 0.001  # every how many packets; bytes that come first; s to the others
MOVES = 1e-3  # rad/s, of an arm that moves


@dataclass(frozen=True)
class Hit:
    """Which frames (N,) faults hit: never the first two or the last."""

    lost: Mask
    cut: Mask
    stale_stamp: Mask
    stale_data: Mask


def choose_hit(faults: Faults, count: int, random: np.random.Generator) -> Hit:
    """Draw which of so many frames are hit, each by one fault at most."""
    drawn = random.random(count)
    drawn[[0, 1, -1]] = 1.0  # the first is safe for a reader when the second is whole, too
    shares = faults.lost_frames, faults.cut_frames, faults.stale_stamps, faults.stale_frames
    bounds = np.cumsum([0.0, *shares])
    return Hit(*((start <= drawn) & (drawn < end) for start, end in pairwise(bounds)))


def spoil(frames: pd.DataFrame, hit: Hit, random: np.random.Generator) -> pd.DataFrame:
    """Frames as faults leave them: some with the stamp or the data of the one before, some gone.

    Adds `sent` [s], when each was sent, whatever its stamp says; and `kept`, which share of its
    bytes comes.
    """
    before, channels = frames.shift(), frames.columns.drop("time")
    kept = np.where(hit.cut, random.random(len(frames)), 1.0)
    frames = frames.assign(sent=frames["time"], kept=kept)
    frames.loc[hit.stale_stamp, "time"] = before.loc[hit.stale_stamp, "time"]
    frames.loc[hit.stale_data, channels] = before.loc[hit.stale_data, channels]
    return frames[~hit.lost]


def split_late(messages: list[bytes], sent: Array, moving: Mask) -> list[tuple[float, bytes]]:
    """When a capture receives which bytes, with every third packet late (Figure 4.4).

    messages; sent: when [s] (N,); moving: whether the arm does (N,). The late packet comes with the
    first 694 bytes of the next, whose others follow 1 ms after.
    """
    received: list[tuple[float, bytes]] = []
    late, count = b"", 0
    for message, time, moves in zip(messages, sent.tolist(), moving, strict=True):
        count = count + 1 if moves else 0
        if late:
            received += [(time, late + message[:SPLIT]), (time + REST, message[SPLIT:])]
            late = b""
        elif moves and count % LATE == 0:
            late = message
        else:
            received.append((time, message))
    return [*received, (float(sent[-1]) + REST, late)] if late else received


def is_moving(frames: pd.DataFrame) -> Mask:
    """Whether the arm is to move, frame by frame (N,)."""
    speed = frames.filter(like="target_qd_").abs().max(axis="columns")
    return (speed > MOVES).to_numpy()


def tear(text: str) -> str:
    """A file as it is when its last, unfilled buffer was lost."""
    return text[: max(len(text) // BUFFER, 1) * BUFFER]
