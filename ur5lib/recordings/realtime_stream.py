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

import math
import re
from binascii import unhexlify
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.errors import InputError
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, add_finding
from ur5lib.robots.realtime_message import SOFTWARE_BY_SIZE, fields
from ur5lib.strict import expect_file
from ur5lib.tables import columns
from ur5lib.timeseries.arrays import Array, Labels, Mask

HEADER = b"received_s"
BLOCK_BYTES = 1 << 21  # bytes that are searched at a time; no line may be twice as long
HEAD_BYTES = 12  # bytes: size and timestamp
RUN_MESSAGES = 1024  # messages processed together, so that they stay in the cache
EVIDENCE_MESSAGES = 16  # timestamps of this many messages decide between size words
MARGIN_BYTES = (EVIDENCE_MESSAGES + 2) * max(
    SOFTWARE_BY_SIZE
)  # bytes that such a comparison may look at
MIN_STEP, MAX_STEP = 1e-4, 60.0  # s, between consecutive messages, unless the timestamp is stale
MAX_UNCONFIRMED_STEP = 1.0  # s, longest step where no earlier message confirms the first
MAX_TIMESTAMP = 1e9  # s; longer than any controller runs

SIZE_WORD = re.compile(b"|".join(re.escape(size.to_bytes(4, "big")) for size in SOFTWARE_BY_SIZE))


@dataclass(frozen=True)
class _Run:
    """Consecutive messages of one size. start: offset of the first [bytes]; count: number of
    messages; size: of each [bytes].
    """

    start: int
    count: int
    size: int

    @property
    def end(self) -> int:
        """Return the offset after the last byte."""
        return self.start + self.count * self.size


class _Messages:
    """The complete messages in a stream of bytes that arrives line by line.

    runs: their places; length: number of bytes so far; tables: by message size, with a row for
    `time`, one for `received`, filled in later, and one per channel (2 + C, room for all messages);
    counts: messages in each table; received, ends: when each line was received [s], and the offset
    after its bytes.
    """

    def __init__(self, most: int) -> None:
        """Set up for at most this many bytes; unused memory is never allocated."""
        self.runs: list[_Run] = []
        self.tables: dict[int, Array] = {}
        self.counts: dict[int, int] = {}
        self.length = 0
        self.received: list[float] = []
        self.ends: list[int] = []
        self._most = most
        self._waiting: list[bytes] = []
        self._searched = 0
        self._last = math.nan  # timestamp of the last message [s]

    def add(self, received: float, payload: bytes) -> None:
        """Add the bytes of a line, received at a time [s]."""
        self._waiting.append(payload)
        self.length += len(payload)
        self.received.append(received)
        self.ends.append(self.length)
        if self.length - self._searched > BLOCK_BYTES:
            self._search(more=True)

    def interrupt(self) -> None:
        """Search all bytes added so far; bytes that follow do not continue them."""
        self._search(more=False)
        self._waiting, self._searched = [], self.length

    def _search(self, more: bool) -> None:
        """Find the messages in the waiting bytes; more: whether further bytes may follow, so that
        the last ones have to wait for these.
        """
        stream = b"".join(self._waiting)
        offset = self.length - len(stream)
        at, end = 0, len(stream)
        limit = end - MARGIN_BYTES if more else end
        while at < limit:
            at = min(_seek(stream, at, end, self._last), limit)
            if at == limit:
                break
            count, size = _whole(stream, at, end)
            if count:
                self.runs.append(_Run(offset + at, count, size))
                self._keep(np.ndarray((count, size // 8), ">f8", stream, at + 4, (size, 8)), size)
            at += max(count * size, 1)
        self._waiting, self._searched = [stream[at:]], self.length

    def received_until(self, offsets: Labels | int) -> Array:
        """Return when all bytes before some offsets had been received [s]."""
        return np.asarray(np.array(self.received)[np.searchsorted(self.ends, offsets)])

    def _keep(self, doubles: Array, size: int) -> None:
        """Append messages to the table of their size; doubles: (N, D) as sent."""
        kept = np.r_[(*fields(size).values(),)]
        if size not in self.tables:  # channels first, as in pandas
            self.tables[size] = np.empty((2 + len(kept), self._most // size))
            self.counts[size] = 0
        first = self.counts[size]
        self.counts[size] += len(doubles)
        part = self.tables[size][:, first : self.counts[size]]
        part[0], part[2:] = doubles[:, 0], doubles[:, kept].T
        self._last = float(part[0, -1])


def read_stream(path: Path) -> tuple[pd.DataFrame, list[Finding]]:
    """Return the messages of a capture, a CSV of `received_s,payload_hex` with one line per recv.

    The frame has one row per message, float64: `time` [s], the controller's own timestamp;
    `received` [s], when the recv that completed the message returned; then the channels of the
    layout under RTDE names (joint_temperatures in °C, otherwise SI). Its attrs name the layout:
    `message_bytes`, and `software`, the controller versions that send it. When messages of
    several layouts occur, the most frequent layout is used.

    Raises InputError when the file cannot be read as lines or has no complete message of a layout
    that is read.
    """
    expect_file(path)
    try:
        messages, damaged = _read(path)
    except OSError as error:
        raise InputError(
            f"{path} cannot be read ({error.strerror}); save the capture there"
        ) from error
    findings: list[Finding] = []
    if damaged:
        detail = f"lines that are not “number,hex”; skipped, the first is line {damaged[0]}"
        findings.append(Finding("robot", Found.DAMAGED_LINES, "warning", len(damaged), detail))
    if not messages.runs:
        raise InputError(
            f"{path} has no complete message of a known layout ({min(SOFTWARE_BY_SIZE)} to "
            f"{max(SOFTWARE_BY_SIZE)} bytes); capture port 30003 again, with one line "
            "`received_s,payload_hex` per recv"
        )
    size = _layout(messages.counts, findings)
    findings += _skipped(messages, size)
    return _frame(messages, size), findings


def _read(path: Path) -> tuple[_Messages, list[int]]:
    """Return the messages of a file, and the numbers of its damaged lines, of which the bytes are
    lost.

    Raises InputError for a file without lines.
    """
    messages, damaged, number = _Messages(path.stat().st_size // 2), list[int](), 0
    with path.open("rb") as file:
        for number, line in enumerate(iter(partial(file.readline, 2 * BLOCK_BYTES), b""), 1):
            if len(line) == 2 * BLOCK_BYTES:
                raise _no_csv(path)
            if not line.strip() or (number == 1 and line.startswith(HEADER)):
                continue
            try:
                messages.add(*_unhex(line))
            except ValueError:
                damaged.append(number)
                messages.interrupt()
    if not number:
        raise _no_csv(path)
    messages.interrupt()
    return messages, damaged


def _no_csv(path: Path) -> InputError:
    return InputError(
        f"{path} is not a CSV with one line `received_s,payload_hex` per recv; capture it again"
    )


def _unhex(line: bytes) -> tuple[float, bytes]:
    """Return when a line was received [s] and its bytes. Raises ValueError if it is damaged."""
    received, payload = line.rstrip(b"\r\n").split(b",")
    seconds = float(received)
    if not math.isfinite(seconds):
        raise ValueError(received)
    return seconds, unhexlify(payload)


def _seek(stream: bytes, at: int, end: int, last: float) -> int:
    """Return the offset, `at` or later, at which the next message seems to begin; `end` if there is
    none.

    Of the size words within one message length, the most plausible begins a message. last:
    timestamp of the message before [s].
    """
    if _follows(np.array([last]), _stamps(stream, at, end, 1)[1]).any():
        return at
    while word := SIZE_WORD.search(stream, at, end):
        at = min(word.start() + max(SOFTWARE_BY_SIZE), end)
        words = [word.start() for word in SIZE_WORD.finditer(stream, word.start(), at)]
        trusts = [_trust(_stamps(stream, word, end, EVIDENCE_MESSAGES)[1], last) for word in words]
        if max(trusts) > 0:
            return words[trusts.index(max(trusts))]
        at -= 3  # a size word may straddle this offset
    return end


def _stamps(stream: bytes, at: int, end: int, most: int) -> tuple[int, Array]:
    """Return the message size at an offset, and the timestamps [s] of up to `most` messages from
    there on.

    There are fewer where `end` comes first, size words disagree or timestamps are impossible; 0 and
    an empty array without a size word.
    """
    size = int.from_bytes(stream[at : at + 4], "big")
    if size not in SOFTWARE_BY_SIZE or at + HEAD_BYTES > end:
        return 0, np.zeros(0)
    count = min(most, (end - at - HEAD_BYTES) // size + 1)
    agree = np.ndarray(count, ">i4", stream, at, (size,)) == size
    stamps = np.ndarray(count, ">f8", stream, at + 4, (size,)).astype(np.float64)
    possible = (stamps == 0) | ((stamps >= MIN_STEP) & (stamps <= MAX_TIMESTAMP))
    return size, stamps[: _leading(agree & possible)]


def _leading(flags: Mask) -> int:
    """Return how many flags (N,) are set before the first that is not."""
    return len(flags) if flags.all() else int(flags.argmin())


def _follows(before: Array, after: Array, longest: float = MAX_STEP) -> Mask:
    """Return whether timestamps [s] can be consecutive: the second is larger by at most `longest`,
    or equal, as a stale one.
    """
    step = after - before
    return ((step == 0) & (after > 0)) | ((step >= MIN_STEP) & (step <= longest))


def _trust(stamps: Array, last: float) -> int:
    """Return a score of how well timestamps [s] (N,) continue from `last` (NaN: none); 0: not at
    all.

    The best continue from `last`; after a long gap or restart they must advance by themselves.
    """
    if not len(stamps):
        return 0
    count = _leading(_follows(stamps[:-1], stamps[1:], MAX_UNCONFIRMED_STEP))
    moved = int(np.count_nonzero(np.diff(stamps[: count + 1])))
    if _follows(np.array([last]), stamps[:1])[0]:
        return 2 * EVIDENCE_MESSAGES + 1 + count + moved
    if len(stamps) == 1:
        return int(math.isnan(last))
    return count + moved if moved else 0


def _whole(stream: bytes, at: int, end: int) -> tuple[int, int]:
    """Return how many messages from an offset on are complete, RUN_MESSAGES at most, and their
    size.

    A message is complete if its last byte is followed by another message or by the end.
    """
    size, stamps = _stamps(stream, at, end, RUN_MESSAGES)
    count = _leading(_follows(stamps[:-1], stamps[1:]))
    if count:
        return count, size
    at += size
    if end - at < HEAD_BYTES:  # too short for a timestamp: the end, or only a size word
        return int(at == end or SIZE_WORD.match(stream, at, end) is not None), size
    return int(_trust(_stamps(stream, at, end, EVIDENCE_MESSAGES)[1], float(stamps[0])) > 0), size


def _layout(counts: dict[int, int], findings: list[Finding]) -> int:
    """Return the most frequent message size; messages of other sizes are reported."""
    size = max(counts, key=counts.__getitem__)
    if others := sorted(counts.keys() - {size}):
        count = sum(counts[other] for other in others)
        named = ", ".join(map(str, others))
        detail = f"messages of {named} bytes among those of {size} bytes; skipped"
        add_finding(findings, "robot", Found.OTHER_LAYOUTS, "warning", count, detail)
    return size


def _skipped(messages: _Messages, size: int) -> list[Finding]:
    """Return findings on the bytes that belong to no complete message."""
    total = messages.length
    starts = [0, *(run.end for run in messages.runs)]
    ends = [*(run.start for run in messages.runs), total]
    gaps = [(start, end) for start, end in zip(starts, ends, strict=True) if start < end]
    partial = [gap for gap in gaps if gap[1] - gap[0] < size and (gap[0] == 0 or gap[1] == total)]
    skipped = [gap for gap in gaps if gap not in partial]
    findings: list[Finding] = []
    if skipped:
        since = float(messages.received_until(skipped[0][0] + 1) - messages.received[0])
        count = sum(end - start for start, end in skipped)
        detail = _skipped_words(len(skipped), since)
        findings.append(Finding("robot", Found.BYTES_SKIPPED, "warning", count, detail))
    detail = "the capture begins or ends within a message; skipped"
    add_finding(findings, "robot", Found.INCOMPLETE_MESSAGE, "note", len(partial), detail)
    return findings


def _skipped_words(places: int, since: float) -> str:
    """Return the sentence on bytes outside messages; places: how many; since: time to the first,
    from the start [s].
    """
    where = "1 place," if places == 1 else f"{places} places, the first"
    return (
        f"bytes outside complete messages (lost, cut or foreign data) in {where} "
        f"{number(since, '.3g')} s after the start of the capture"
    )


def _frame(messages: _Messages, size: int) -> pd.DataFrame:
    """Return the messages of one size [bytes], one row each."""
    table = messages.tables[size][:, : messages.counts[size]]
    ends = [
        run.start + size * np.arange(1, run.count + 1) for run in messages.runs if run.size == size
    ]
    table[1] = messages.received_until(np.concatenate(ends))
    names = ["time", "received"]
    for name, place in fields(size).items():
        count = place.stop - place.start
        names += columns(name, count) if count > 1 else [name]
    frame = pd.DataFrame(table.T, columns=names, copy=False)
    frame.attrs = {"message_bytes": size, "software": SOFTWARE_BY_SIZE[size]}
    return frame
