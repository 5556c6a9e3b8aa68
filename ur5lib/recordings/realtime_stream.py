"""Reader of captures of the realtime port (30003): the bytes as received from the socket.

A message is an int32 size, then big-endian doubles, the first of them the controller's timestamp.
TCP keeps the bytes in order but does not separate messages, and a capture may have lost bytes or
contain foreign ones. A message is accepted when it is complete and is followed by another message
with a consecutive timestamp, or by the end of the data. A size word alone proves nothing: its bytes
also occur inside messages. Where bytes are missing or superfluous, the search continues byte by
byte, so that damage costs the messages it touches and at most one neighbour.

Lost bytes in whole multiples of the message size leave no trace in the sizes: then the head of one
message may be joined to the tail of a later one, unless a damaged line shows where bytes were lost.
"""

import binascii
import math
import re
from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv as pacsv

from ur5lib.errors import InputError
from ur5lib.recordings.quality import Finding
from ur5lib.robots.realtime_message import SOFTWARE, fields
from ur5lib.strict import expect_file
from ur5lib.tables import columns
from ur5lib.timeseries.arrays import Array, Labels, Mask

Integers = Labels

HEADER = b"received_s"
BLOCK = 1 << 22  # bytes of CSV parsed at a time; no line may be longer
AHEAD = 4  # blocks parsed ahead of their use
HEAD = 12  # bytes: size and timestamp
RUN = 1024  # messages processed together, so that they stay in the cache
EVIDENCE = 16  # messages whose timestamps decide between size words
MARGIN = (EVIDENCE + 2) * max(SOFTWARE)  # bytes that such a comparison may look at
SHORTEST, LONGEST = 1e-4, 60.0  # s, between consecutive messages, unless the timestamp is stale
SETTLED = 1.0  # s, longest step where no earlier message confirms the first
AGES = 1e9  # s; longer than any controller runs

SIZE_WORD = re.compile(b"|".join(re.escape(size.to_bytes(4, "big")) for size in SOFTWARE))


@dataclass(frozen=True)
class _Run:
    """Consecutive messages of one size [bytes], starting at an offset."""

    start: int
    count: int
    size: int

    @property
    def end(self) -> int:
        """Return the offset after the last byte."""
        return self.start + self.count * self.size


@dataclass(frozen=True)
class _Lines:
    """Lines of two cells: the bytes in each (L,), -1 where damaged, and when received [s]."""

    lengths: Integers
    received: Array

    @property
    def ends(self) -> Integers:
        """Return the offset after each line's bytes (L,)."""
        return np.cumsum(np.maximum(self.lengths, 0))


class _Messages:
    """The complete messages in a stream of bytes that arrives piece by piece.

    runs: where they lie; length: number of bytes so far; tables: by message size, a row for `time`,
    one for `received`, filled in later, and one per channel (2 + C, room for all messages).
    """

    def __init__(self, most: int) -> None:
        """Set up for at most this many bytes; unused memory is never allocated."""
        self.runs: list[_Run] = []
        self.tables: dict[int, Array] = {}
        self.counts: dict[int, int] = {}
        self.length = 0
        self._most = most
        self._rest = b""
        self._last = math.nan  # timestamp of the last message [s]

    def add(self, data: bytes, more: bool) -> None:
        """Process the next bytes; more: whether further bytes follow directly.

        Bytes that cannot be judged without their successors are kept for the next call.
        """
        stream = self._rest + data
        offset = self.length - len(self._rest)
        self.length += len(data)
        at, end = 0, len(stream)
        limit = end - MARGIN if more else end
        while at < limit:
            at = min(_seek(stream, at, end, self._last), limit)
            if at == limit:
                break
            count, size = _whole(stream, at, end)
            if count:
                self.runs.append(_Run(offset + at, count, size))
                self._keep(np.ndarray((count, size // 8), ">f8", stream, at + 4, (size, 8)), size)
            at += max(count * size, 1)
        self._rest = stream[at:]

    def _keep(self, doubles: Array, size: int) -> None:
        """Append messages, doubles as sent (N, D), to the table of their size."""
        layout = fields(size)
        if size not in self.tables:
            rows = 2 + sum(count for _, count in layout.values())
            # Channels first, as in pandas. Not np.empty: it requests huge pages, and clearing those
            # can take longer than everything else.
            room = pa.allocate_buffer(rows * (self._most // size) * 8)
            self.tables[size] = np.frombuffer(room, np.float64).reshape(rows, -1)
            self.counts[size] = 0
        first = self.counts[size]
        self.counts[size] += len(doubles)
        part = self.tables[size][:, first : self.counts[size]]
        part[0], row = doubles[:, 0], 2
        for byte, count in layout.values():
            column = (byte - 4) // 8
            part[row : row + count] = doubles[:, column : column + count].T
            row += count
        self._last = float(part[0, -1])


def read_stream(path: Path) -> tuple[pd.DataFrame, list[Finding]]:
    """Return the messages of a capture, a CSV of `received_s,payload_hex` with one line per recv.

    The frame has one row per message, float64: `time` [s], the controller's own timestamp;
    `received` [s], when the recv that completed the message returned; then the channels of the
    layout under RTDE names (joint_temperatures in °C, otherwise SI). Its attrs name the layout:
    `message_bytes`, and `software`, the controller versions that send it. When messages of
    several layouts occur, the most frequent layout is used.

    Raises InputError when the file cannot be read as lines or has no complete message of a known
    layout.
    """
    findings: list[Finding] = []
    expect_file(Path(path))
    try:
        lines, messages = _read(Path(path), findings)
    except OSError as error:
        raise InputError(
            f"{path} cannot be read ({error.strerror}); save the capture there"
        ) from error
    except pa.ArrowInvalid as error:
        raise InputError(
            f"{path} is not a CSV with one line `received_s,payload_hex` per recv; capture it again"
        ) from error
    if not messages.runs:
        raise InputError(
            f"{path} has no complete message of a known layout ({min(SOFTWARE)} to "
            f"{max(SOFTWARE)} bytes); capture port 30003 again, with one line "
            "`received_s,payload_hex` per recv"
        )
    size = _layout(messages.counts, findings)
    findings += _skipped(messages, lines, size)
    return _frame(messages, lines, size), findings


def _read(path: Path, findings: list[Finding]) -> tuple[_Lines, _Messages]:
    """Read the lines of a file and the messages in them; skip and report damaged lines."""
    try:
        return _go_through(path, None, findings)  # fast, but only for files without torn lines
    except pa.ArrowInvalid:
        return _go_through(path, [], findings)


def _go_through(
    path: Path, torn: list[int] | None, findings: list[Finding]
) -> tuple[_Lines, _Messages]:
    """Do the work of _read. torn: collects numbers of lines without two cells; None: none exist.

    Raises pyarrow.ArrowInvalid when lines cannot be separated, or one is torn and `torn` is None.
    """
    with path.open("rb") as file:
        skip = int(file.read(len(HEADER)) == HEADER)
    messages = _Messages(path.stat().st_size // 2)
    blocks, count = [_Lines(np.zeros(0, np.int64), np.zeros(0))], 0
    for batch in _batches(path, skip, torn):
        payload, block = _unhex(batch)
        start = 0
        for loss in _losses(block, _before(torn, skip) - count):
            messages.add(payload[start:loss], more=False)
            start = loss
        messages.add(payload[start:], more=True)
        blocks.append(block)
        count += len(block.lengths)
    messages.add(b"", more=False)
    lengths, received = zip(*((block.lengths, block.received) for block in blocks), strict=True)
    lines = _Lines(np.concatenate(lengths), np.concatenate(received))
    _find_damaged(lines, _before(torn, skip), skip, findings)
    return lines, messages


def _before(torn: list[int] | None, skip: int) -> Integers:
    """Return how many lines of two cells precede each torn line (T,), after `skip` header lines."""
    torn = torn or []
    return np.array(torn, np.int64) - 1 - skip - np.arange(len(torn))


def _losses(block: _Lines, before: Integers) -> list[int]:
    """Return the offsets in a block's bytes at which lines were skipped.

    before (T,): how many lines of the block precede each torn line.
    """
    ends = np.append(0, block.ends)
    here = before[(before >= 0) & (before < len(ends) - 1)]
    offsets: list[int] = np.union1d(ends[here], ends[:-1][block.lengths < 0]).tolist()
    return offsets


def _find_damaged(lines: _Lines, before: Integers, skip: int, findings: list[Finding]) -> None:
    """Report how many lines were skipped and which was the first; arguments as above."""
    damaged = np.flatnonzero(lines.lengths < 0)
    if count := len(damaged) + len(before):
        torn = before + np.arange(len(before))
        others = damaged + np.searchsorted(before, damaged, side="right")
        first = int(np.concatenate([torn, others]).min()) + 1 + skip
        place = {"line": first}
        findings.append(Finding("robot", "damaged lines", "warning", count, place, "no messages"))


def _batches(path: Path, skip: int, torn: list[int] | None) -> Iterator[pa.RecordBatch]:
    """Yield the lines of two cells, as bytes; the next blocks are parsed in the meantime."""

    def leave_out(row: pacsv.InvalidRow) -> str:
        assert torn is not None
        torn.append(row.number)
        return "skip"

    cells = ["received", "payload"]
    options = pacsv.ReadOptions(
        column_names=cells,
        skip_rows=skip,
        use_threads=False,  # otherwise lines are not numbered
        block_size=BLOCK,
        encoding="utf8" if torn is None else "latin1",  # a torn line may hold any byte
    )
    parsing = pacsv.ParseOptions(
        quote_char=False,
        ignore_empty_lines=False,
        invalid_row_handler=None if torn is None else leave_out,
    )
    converting = pacsv.ConvertOptions(column_types=dict.fromkeys(cells, pa.binary()))
    reader = pacsv.open_csv(pa.memory_map(str(path)), options, parsing, converting)
    with ThreadPoolExecutor(1) as ahead:
        coming = deque(ahead.submit(next, reader, None) for _ in range(AHEAD))
        while (batch := coming.popleft().result()) is not None:
            coming.append(ahead.submit(next, reader, None))
            yield batch


def _unhex(batch: pa.RecordBatch) -> tuple[bytes, _Lines]:
    """Return the bytes of all lines, joined, and how many each line holds.

    All lines are converted at once; only if that fails, one by one.
    """
    offsets = np.frombuffer(batch[1].buffers()[1], np.int32, len(batch) + 1, 4 * batch[1].offset)
    text = memoryview(batch[1].buffers()[2] or b"")[offsets[0] : offsets[-1]]
    digits = np.diff(offsets)
    try:
        received = batch[0].cast(pa.string()).cast(pa.float64()).to_numpy()
        if np.isfinite(received).all() and not (digits & 1).any():
            return binascii.unhexlify(text), _Lines(digits.astype(np.int64) // 2, received)
    except (pa.ArrowInvalid, binascii.Error):
        pass
    lines = [_unhex_line(*line) for line in zip(*batch.to_pydict().values(), strict=True)]
    lengths = [-1 if payload is None else len(payload) for _, payload in lines]
    received = np.array([received for received, _ in lines])
    return b"".join(payload or b"" for _, payload in lines), _Lines(
        np.array(lengths, np.int64), received
    )


def _unhex_line(received: bytes, payload: bytes) -> tuple[float, bytes | None]:
    """Return when a line was received [s] and its bytes; NaN and None if it is damaged."""
    if not received and not payload:  # an empty line means no loss
        return math.nan, b""
    try:
        seconds, data = float(received), binascii.unhexlify(payload)
    except ValueError:
        return math.nan, None
    return (seconds, data) if math.isfinite(seconds) else (math.nan, None)


def _seek(stream: bytes, at: int, end: int, last: float) -> int:
    """Return where the next message seems to begin, `at` or later; `end` if nowhere.

    Of the size words within one message length, the most plausible begins a message.
    """
    if _follows(np.array([last]), _stamps(stream, at, end, 1)[1]).any():
        return at
    while word := SIZE_WORD.search(stream, at, end):
        at = min(word.start() + max(SOFTWARE), end)
        words = [word.start() for word in SIZE_WORD.finditer(stream, word.start(), at)]
        trusts = [_trust(_stamps(stream, word, end, EVIDENCE)[1], last) for word in words]
        if max(trusts) > 0:
            return words[trusts.index(max(trusts))]
        at -= 3  # a size word may straddle this offset
    return end


def _stamps(stream: bytes, at: int, end: int, most: int) -> tuple[int, Array]:
    """Return the message size at an offset and the timestamps [s] (most,) from there on.

    Fewer where `end` comes first, size words disagree or timestamps are impossible; 0 and none if
    there is no size word.
    """
    size = int.from_bytes(stream[at : at + 4], "big")
    if size not in SOFTWARE or at + HEAD > end:
        return 0, np.zeros(0)
    count = min(most, (end - at - HEAD) // size + 1)
    agree = np.ndarray(count, ">i4", stream, at, (size,)) == size
    stamps = np.ndarray(count, ">f8", stream, at + 4, (size,)).astype(np.float64)
    possible = (stamps == 0) | ((stamps >= SHORTEST) & (stamps <= AGES))
    return size, stamps[: _leading(agree & possible)]


def _leading(flags: Mask) -> int:
    """Return how many flags (N,) are set before the first that is not."""
    return len(flags) if flags.all() else int(flags.argmin())


def _follows(before: Array, after: Array, longest: float = LONGEST) -> Mask:
    """Return whether timestamps [s] can be consecutive: advanced, or stale, as does occur."""
    step = after - before
    return ((step == 0) & (after > 0)) | ((step >= SHORTEST) & (step <= longest))


def _trust(stamps: Array, last: float) -> int:
    """Return how well timestamps [s] (N,) follow `last` (NaN: none); 0: not at all.

    The best continue from `last`; after a long gap or restart they must advance by themselves.
    """
    if not len(stamps):
        return 0
    count = _leading(_follows(stamps[:-1], stamps[1:], SETTLED))
    moved = int(np.count_nonzero(np.diff(stamps[: count + 1])))
    if _follows(np.array([last]), stamps[:1])[0]:
        return 2 * EVIDENCE + 1 + count + moved
    if len(stamps) == 1:
        return int(math.isnan(last))
    return count + moved if moved else 0


def _whole(stream: bytes, at: int, end: int) -> tuple[int, int]:
    """Return how many messages from an offset on are complete, at most RUN, and their size.

    A message is complete if its last byte is followed by another message or by the end.
    """
    size, stamps = _stamps(stream, at, end, RUN)
    count = _leading(_follows(stamps[:-1], stamps[1:]))
    if count:
        return count, size
    at += size
    if end - at < HEAD:  # too short for a timestamp: the end, or only a size word
        return int(at == end or SIZE_WORD.match(stream, at, end) is not None), size
    return int(_trust(_stamps(stream, at, end, EVIDENCE)[1], float(stamps[0])) > 0), size


def _layout(counts: dict[int, int], findings: list[Finding]) -> int:
    """Return the most frequent message size; messages of other sizes are reported."""
    size = max(counts, key=counts.__getitem__)
    if others := sorted(counts.keys() - {size}):
        count = sum(counts[other] for other in others)
        sizes = {"others": others, "bytes": size}
        findings.append(Finding("robot", "other layouts", "warning", count, sizes))
    return size


def _skipped(messages: _Messages, lines: _Lines, size: int) -> list[Finding]:
    """Report the bytes that belong to no complete message."""
    total = messages.length
    starts = [0, *(run.end for run in messages.runs)]
    ends = [*(run.start for run in messages.runs), total]
    gaps = [(start, end) for start, end in zip(starts, ends, strict=True) if start < end]
    partial = [gap for gap in gaps if gap[1] - gap[0] < size and (gap[0] == 0 or gap[1] == total)]
    skipped = [gap for gap in gaps if gap not in partial]
    findings = []
    if skipped:
        first = lines.received[np.searchsorted(lines.ends, skipped[0][0], side="right")]
        where = {"places": len(skipped), "seconds": float(first - lines.received[0])}
        count = sum(end - start for start, end in skipped)
        code = "bytes skipped" if len(skipped) == 1 else "bytes skipped often"
        findings.append(Finding("robot", "bytes skipped", "warning", count, where, code))
    if partial:
        findings.append(Finding("robot", "incomplete message", "note", len(partial)))
    return findings


def _frame(messages: _Messages, lines: _Lines, size: int) -> pd.DataFrame:
    """Return the messages of one size [bytes], one row each."""
    table = messages.tables[size][:, : messages.counts[size]]
    ends = [
        run.start + size * np.arange(1, run.count + 1) for run in messages.runs if run.size == size
    ]
    table[1] = lines.received[np.searchsorted(lines.ends, np.concatenate(ends))]
    names = ["time", "received"]
    for name, (_, count) in fields(size).items():
        names += columns(name, count) if count > 1 else [name]
    frame = pd.DataFrame(table.T, columns=names, copy=False)
    frame.attrs = {"message_bytes": size, "software": SOFTWARE[size]}
    return frame
