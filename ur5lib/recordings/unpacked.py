"""How many numbers a compressed file would unpack to, found before it is unpacked."""

import io
import struct
import zlib
from collections.abc import Collection, Iterator
from itertools import accumulate
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ur5lib.recordings.limits import BYTES_PER_NUMBER, expect_room, most_bytes

PIECE_BYTES = 1 << 20  # bytes that are unpacked at a time
MATRIX_ELEMENT, COMPRESSED_ELEMENT = 14, 15  # kinds of elements of a MAT file
# An element takes this many in addition to its content: 112 bytes for an array of four.
NUMBERS_PER_ELEMENT = 4
MAT_SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}


def parquet_numbers(file: pq.ParquetFile, columns: Collection[str]) -> float:
    """Return how many numbers the given columns of a Parquet file contain, by the list at its
    end.
    """
    groups = map(file.metadata.row_group, range(file.num_row_groups))
    chunks = (group.column(k) for group in groups for k in range(group.num_columns))
    wanted = [chunk for chunk in chunks if _is_of(chunk.path_in_schema, columns)]
    sizes = (one.total_uncompressed_size / BYTES_PER_NUMBER for one in wanted)
    return sum(max(one.num_values, size) for one, size in zip(wanted, sizes, strict=True))


def _is_of(path: str, columns: Collection[str]) -> bool:
    """Return whether a path, as `q.list.element`, is one of the columns or inside one."""
    parts = path.split(".")
    return any(".".join(parts[:k]) in columns for k in range(1, len(parts) + 1))


def feather_numbers(path: Path) -> float:
    """Return how many numbers a Feather file contains, by the headers of its batches and buffers.

    0 for the version that begins with FEA1, which compresses nothing.
    """
    with pa.memory_map(str(path)) as file:
        if file.read(8)[:6] != b"ARROW1":
            return 0
        return sum(map(_batch_numbers, pa.ipc.MessageReader.open_stream(file)))


def _batch_numbers(message: pa.Message) -> float:
    """Return how many numbers a message of Arrow contains: by its rows, or by the sizes that its
    compressed buffers begin with.

    https://arrow.apache.org/docs/format/Columnar.html#recordbatch-message
    """
    if message.type not in ("record batch", "dictionary"):
        return 0
    head = message.metadata.to_pybytes()
    batch = _follow(head, _field(head, _follow(head, 0), 2))
    if message.type == "dictionary":
        batch = _follow(head, _field(head, batch, 1))
    nodes, buffers = (_pairs(head, _follow(head, _field(head, batch, k))) for k in (1, 2))
    unpacked = 0
    for start, length in buffers[buffers[:, 1] >= 8] if _field(head, batch, 3) else ():
        (size,) = struct.unpack("<q", message.body[start : start + 8].to_pybytes())
        unpacked += max(size, length)
    return max(int(nodes[:, 0].sum()), unpacked / BYTES_PER_NUMBER)


def _follow(data: bytes, place: int) -> int:
    """Return the place to which an offset in a FlatBuffer leads."""
    return place + int.from_bytes(data[place : place + 4], "little")


def _field(data: bytes, table: int, index: int) -> int:
    """Return the place of a field in a table of a FlatBuffer, 0 where it lacks the field."""
    fields = table - int.from_bytes(data[table : table + 4], "little", signed=True)
    entry = fields + 4 + 2 * index
    if entry >= fields + int.from_bytes(data[fields : fields + 2], "little"):
        return 0
    offset = int.from_bytes(data[entry : entry + 2], "little")
    return table + offset if offset else 0


def _pairs(data: bytes, vector: int) -> np.ndarray:
    """Return a FlatBuffer's vector of pairs of long integers (N, 2)."""
    count = int.from_bytes(data[vector : vector + 4], "little")
    return np.frombuffer(data, "<i8", 2 * count, vector + 4).reshape(-1, 2)


def expect_mat_room(path: Path) -> None:
    """Raise InputError where a MAT file of version 5 contains more numbers than may be read."""
    with path.open("rb") as file:
        head = file.read(128)
        order = {b"IM": "<", b"MI": ">"}.get(head[126:])
        if order:  # version 4 compresses nothing
            room = most_bytes() / BYTES_PER_NUMBER
            for numbers in accumulate(_mat_numbers(file, order)):
                if numbers > room:
                    expect_room(path, numbers)


def _mat_numbers(file: BinaryIO, order: str) -> Iterator[float]:
    """Yield, for each element of a MAT file, how many numbers it takes, within arrays and
    structures, too.

    order: of bytes, "<" or ">". An element's content is skipped.
    """
    while len(tag := file.read(8)) == 8:
        yield NUMBERS_PER_ELEMENT
        kind, size = struct.unpack(f"{order}II", tag)
        if kind == COMPRESSED_ELEMENT:
            inflated = Inflated(file.read(size))
            yield from _mat_numbers(io.BufferedReader(inflated, PIECE_BYTES), order)
        elif kind != MATRIX_ELEMENT and kind < 1 << 16:  # what is larger has its content in its tag
            yield size / MAT_SIZES.get(kind, 1)
            for rest in range(size + -size % 8, 0, -PIECE_BYTES):
                file.read(min(rest, PIECE_BYTES))


class Inflated(io.RawIOBase):
    """A stream of compressed data that unpacks them as they are read."""

    def __init__(self, packed: bytes) -> None:
        self._packed = io.BytesIO(packed)
        self._inflate = zlib.decompressobj()

    def readable(self) -> bool:
        """Return True: `io` asks whether the stream can be read."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Put the next bytes into a buffer and return their number, 0 at the end."""
        piece = b""
        while not piece and (waiting := self._waiting()):
            piece = self._inflate.decompress(waiting, len(buffer))
        buffer[: len(piece)] = piece
        return len(piece)

    def _waiting(self) -> bytes:
        return self._inflate.unconsumed_tail or self._packed.read(PIECE_BYTES)
