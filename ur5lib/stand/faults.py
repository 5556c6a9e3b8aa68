"""Simulated faults of a recording: in the frames, in the stream, in the files."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from ur5lib.stand.plan import Faults
from ur5lib.timeseries.arrays import Array, Mask

FILE_BUFFER_BYTES = 4096  # bytes; a partly filled buffer is never written to the file
LATE_PACKET_INTERVAL = 3  # packets: every third one is late
FIRST_PART_BYTES = 694  # of the packet after a late one, this many arrive with the late one
SECOND_PART_DELAY = 0.001  # s; delay of the rest of that packet
MOVING_SPEED = 1e-3  # rad/s; above it, the arm counts as moving


@dataclass(frozen=True)
class FaultyFrames:
    """Masks (N,) of a recording's faulty frames, one for each kind of fault; the first two frames
    and the last are never faulty.
    """

    lost: Mask
    cut: Mask
    stale_stamp: Mask
    stale_data: Mask


def draw_faulty_frames(faults: Faults, count: int, random: np.random.Generator) -> FaultyFrames:
    """Return which of `count` frames are faulty, drawn at random with the shares in `faults`; each
    has at most one fault.
    """
    numbers = random.random(count)
    numbers[[0, 1, -1]] = 1.0  # a reader accepts the first frame only if the second is complete
    shares = faults.lost_frames, faults.cut_frames, faults.stale_stamps, faults.stale_frames
    bounds = np.cumsum([0.0, *shares])
    return FaultyFrames(*((start <= numbers) & (numbers < end) for start, end in pairwise(bounds)))


def apply_faults(
    frames: pd.DataFrame, faulty: FaultyFrames, random: np.random.Generator
) -> pd.DataFrame:
    """Return the frames with stale timestamps and stale data, without lost frames.

    Adds `sent` [s], the true time of sending, and `kept`, the share of the bytes that arrives.
    """
    before, channels = frames.shift(), frames.columns.drop("time")
    kept = np.where(faulty.cut, random.random(len(frames)), 1.0)
    frames = frames.assign(sent=frames["time"], kept=kept)
    frames.loc[faulty.stale_stamp, "time"] = before.loc[faulty.stale_stamp, "time"]
    frames.loc[faulty.stale_data, channels] = before.loc[faulty.stale_data, channels]
    return frames[~faulty.lost]


def receipts_with_late_packets(
    messages: list[bytes], sent: Array, moving: Mask
) -> list[tuple[float, bytes]]:
    """Return time [s] and bytes of each receipt, with every third packet late (Figure 4.4).

    sent: times of sending [s] (N,); moving: whether the arm moves (N,). The late packet arrives
    with the first 694 bytes of the next one, the rest of which follows 1 ms later.
    """
    received: list[tuple[float, bytes]] = []
    late, count = b"", 0
    for message, time, moves in zip(messages, sent.tolist(), moving, strict=True):
        count = count + 1 if moves else 0
        if late:
            received += [
                (time, late + message[:FIRST_PART_BYTES]),
                (time + SECOND_PART_DELAY, message[FIRST_PART_BYTES:]),
            ]
            late = b""
        elif moves and count % LATE_PACKET_INTERVAL == 0:
            late = message
        else:
            received.append((time, message))
    return [*received, (float(sent[-1]) + SECOND_PART_DELAY, late)] if late else received


def is_moving(frames: pd.DataFrame) -> Mask:
    """Return whether the targets move, frame by frame (N,)."""
    speed = frames.filter(like="target_qd_").abs().max(axis="columns")
    return (speed > MOVING_SPEED).to_numpy()


def without_last_buffer(text: str) -> str:
    """Return the text of a file as a killed program leaves it: without its last, partly filled
    buffer.
    """
    return text[: max(len(text) // FILE_BUFFER_BYTES, 1) * FILE_BUFFER_BYTES]
