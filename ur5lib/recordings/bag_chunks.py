"""Chunks of bags are unpacked up to a limit; the library that reads bags knows none."""

import bz2
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lz4.frame import LZ4FrameDecompressor
from rosbags.rosbag1 import reader as ros1
from rosbags.rosbag2 import storage_mcap as ros2

from ur5lib.recordings.limits import most_bytes, too_large

Unpack = Callable[[bytes], bytes]
CHUNK_SHARE = 0.2  # of the limit; a chunk has a megabyte or so, and is in memory three times
USUAL_COMPRESSION = 20  # bytes for each byte of a file with compressed chunks


@contextmanager
def with_bounded_chunks(path: Path) -> Iterator[Unpack]:
    """Let the library read a bag with chunks that raise InputError where they unpack to too much.

    Yields how a message that is compressed by itself is unpacked, within the same limit.
    """
    inflate, before = _inflate_within(path), (dict(ros1.decompressors), dict(ros2.DECOMPRESSORS))
    zstd_object = ros2.zstd.ZstdDecompressor
    ros1.decompressors["bz2"] = lambda data: inflate(data, bz2.BZ2Decompressor)
    ros1.decompressors["lz4"] = lambda data: inflate(data, LZ4FrameDecompressor)
    ros2.DECOMPRESSORS["lz4"] = lambda data, _: inflate(data, LZ4FrameDecompressor)
    ros2.DECOMPRESSORS["zstd"] = lambda data, _: inflate(data, zstd_object)
    try:
        yield lambda data: inflate(data, zstd_object)
    finally:
        ros1.decompressors.update(before[0])
        ros2.DECOMPRESSORS.update(before[1])


def most_unpacked(path: Path) -> float:
    """Return how many bytes a bag may unpack to."""
    return most_bytes() + USUAL_COMPRESSION * path.stat().st_size


def _inflate_within(path: Path) -> Callable[[bytes, Callable[[], Any]], bytes]:
    """Return a function that unpacks a chunk of a file. Raises InputError beyond the limit."""
    most = int(CHUNK_SHARE * most_bytes())
    left = most_unpacked(path)

    def inflate(data: bytes, new: Callable[[], Any]) -> bytes:
        nonlocal left
        frames, size = [], 0
        while data:
            one = new()
            frames.append(one.decompress(data, most + 1 - size))
            size += len(frames[-1])
            left -= len(frames[-1])
            if size > most:
                raise too_large(path, f"{most / 1e9:g} GB in a chunk")
            if left < 0:
                raise too_large(path, f"{USUAL_COMPRESSION} times as much as it has bytes")
            if not one.eof:
                raise EOFError(path)
            data = one.unused_data or b""
        return b"".join(frames)

    return inflate
