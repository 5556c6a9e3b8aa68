"""Chunks of bags are unpacked up to a limit; the library that reads bags knows none."""

import bz2
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from lz4.frame import LZ4FrameDecompressor
from rosbags.rosbag1 import reader as ros1
from rosbags.rosbag2 import storage_mcap as ros2

from ur5lib.recordings.limits import Unpacking

Unpack = Callable[[bytes], bytes]


@contextmanager
def with_bounded_chunks(path: Path) -> Iterator[Unpack]:
    """Let the library read a bag; a chunk raises InputError if it unpacks to more than may be read.

    Yields a function that unpacks a message which is compressed on its own, within the same limit.
    """
    inflate, before = Unpacking(path).unpacked, (dict(ros1.decompressors), dict(ros2.DECOMPRESSORS))
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
