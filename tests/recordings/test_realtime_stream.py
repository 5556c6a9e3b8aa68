"""The reader of realtime captures: every frame back bit for bit, and nothing that was not sent."""

import random
import struct
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import said
from ur5lib.errors import InputError
from ur5lib.recordings.realtime_stream import read_stream
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding

SIZE = 756
SIZES = [756, 764, 812, 1044, 1060, 1108, 1116, 1140, 1220]
WORD = struct.pack(">i", SIZE)
FRAMES = 12

# Where a channel begins, by the maker's tables [bytes], for messages before 3.0 and from then on.
OLD = {
    "target_q_0": 12, "target_qd_5": 100, "target_qdd_0": 108, "target_current_1": 164,
    "target_moment_5": 244, "actual_q_0": 252, "actual_qd_2": 316, "actual_current_5": 388,
    "actual_TCP_force_0": 540, "actual_TCP_pose_0": 588, "actual_TCP_speed_5": 676,
    "joint_temperatures_5": 732,
}  # fmt: skip
LATER_OLD = {"actual_tool_accelerometer_2": 412, "robot_mode": 756, "joint_mode_5": 804}
NEW = {
    "target_q_0": 12, "target_moment_5": 244, "actual_q_0": 252, "actual_current_5": 388,
    "joint_control_output_0": 396, "actual_TCP_pose_0": 444, "actual_TCP_speed_5": 532,
    "actual_TCP_force_0": 540, "target_TCP_pose_0": 588, "target_TCP_speed_5": 676,
    "joint_temperatures_0": 692, "robot_mode": 756, "joint_mode_0": 764, "safety_mode": 812,
    "actual_tool_accelerometer_0": 868, "speed_scaling": 940, "actual_momentum": 948,
    "actual_main_voltage": 972, "actual_robot_voltage": 980, "actual_robot_current": 988,
    "actual_joint_voltage_5": 1036, "elbow_position_0": 1060, "elbow_velocity_2": 1100,
    "safety_status": 1108, "payload": 1140, "payload_cog_2": 1164, "payload_inertia_5": 1212,
}  # fmt: skip


def message(stamp: float, chance: random.Random, size: int = SIZE) -> bytes:
    """One message: doubles of any bits but the stamp, the size word in the midst of some."""
    body = bytearray(chance.randbytes(size - 12))
    if chance.random() < 0.3:
        at = chance.randrange(len(body) - 4)
        body[at : at + 4] = struct.pack(">i", size)
    return struct.pack(">id", size, stamp) + body


def messages(count: int = FRAMES, seed: int = 0, size: int = SIZE, start: float = 0.0) -> list:
    chance = random.Random(seed)
    return [message(start + 0.008 * k, chance, size) for k in range(count)]


def chunked(stream: bytes, cuts: Iterable[int]) -> list[bytes]:
    bounds = [0, *sorted(cuts), len(stream)]
    return [stream[a:b] for a, b in pairwise(bounds)]


def write(path: Path, chunks: Iterable[bytes]) -> Path:
    path.write_text("".join(f"{k}.5,{chunk.hex()}\n" for k, chunk in enumerate(chunks)))
    return path


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("stream") / "capture.csv"


def rows(sent: list[bytes], columns: pd.Index, places: dict[str, int]) -> np.ndarray:
    """What was sent of these channels, as bits (N, C)."""
    doubles = [[struct.unpack_from(">d", m, places[name])[0] for name in columns] for m in sent]
    return np.array(doubles, np.float64).reshape(len(sent), len(columns)).view(np.uint64)


def bits(frame: pd.DataFrame, places: dict[str, int]) -> np.ndarray:
    return np.ascontiguousarray(frame[list(places)].to_numpy(np.float64)).view(np.uint64)


PLACES = {"time": 4} | OLD


def received_of(
    frame: pd.DataFrame, sent: list[bytes], places: dict[str, int] = PLACES
) -> list[int]:
    """Which message each row is; fails where a row is none of those sent."""
    known = {bytes(row): k for k, row in enumerate(rows(sent, pd.Index(places), places))}
    return [known[bytes(row)] for row in bits(frame, places)]


def named(findings: list[Finding]) -> dict[str, Finding]:
    return {finding.code: finding for finding in findings}


@settings(derandomize=True, max_examples=60)
@given(cuts=st.lists(st.integers(0, FRAMES * SIZE), max_size=40), seed=st.integers(0, 99))
def test_any_chunking_gives_every_frame(capture: Path, cuts: list[int], seed: int) -> None:
    sent = messages(seed=seed)
    frame, findings = read_stream(write(capture, chunked(b"".join(sent), cuts)))
    assert received_of(frame, sent) == list(range(FRAMES))
    assert not findings
    ends = [sum(cut < (k + 1) * SIZE for cut in cuts) + 0.5 for k in range(FRAMES)]
    assert frame["received"].tolist() == ends


@settings(derandomize=True, max_examples=300)
@given(
    size=st.one_of(st.just(SIZE), st.sampled_from(SIZES)),
    at=st.integers(0, FRAMES * SIZES[-1]),
    count=st.integers(1, 5 * SIZE),
    seed=st.integers(0, 99),
    start=st.sampled_from([0.0, 3.2, 1234.5]),
)
def test_bytes_cut_out(
    capture: Path, size: int, at: int, count: int, seed: int, start: float
) -> None:
    """Any number but whole messages' lengths, which leave no trace (see below)."""
    sent = messages(seed=seed, size=size, start=start)
    stream = b"".join(sent)
    at, count = at % len(stream), count + (count % size == 0)
    count = min(count, len(stream) - at)
    frame, findings = read_stream(write(capture, [stream[:at] + stream[at + count :]]))
    touched = (at + count - 1) // size - at // size + 1
    back = received_of(frame, sent, PLACES if size == SIZE else {"time": 4})
    assert back == sorted(set(back))
    assert len(back) >= FRAMES - touched - 1
    assert findings or (at + count == len(stream) and at % size == 0)


def randbytes(seed: int, count: int) -> bytes:
    return random.Random(seed).randbytes(count)


seeds, counts = st.integers(0, 999), st.integers(0, 999)
foreign = st.one_of(
    st.binary(min_size=1, max_size=40),
    st.builds(randbytes, seeds, st.integers(1, 3000)),
    st.builds(lambda n, cut: (WORD * n)[cut:], st.integers(1, 700), st.integers(0, 3)),
    st.builds(lambda n, more: bytes(n) + WORD + bytes(more), counts, counts),
    st.builds(lambda seed, n: WORD + randbytes(seed, n), seeds, counts),
    # Whole messages by their sizes, and no other sign of them.
    st.builds(lambda seed, n: (WORD + randbytes(seed, 752)) * n, seeds, st.integers(1, 3)),
    st.builds(lambda n: (WORD + bytes(752)) * n + WORD, st.integers(1, 3)),
    st.sampled_from([a + b for a in SIZES for b in SIZES]).map(lambda n: WORD * (n // 4)),
)


@settings(derandomize=True, max_examples=400)
@given(
    at=st.one_of(
        st.integers(0, FRAMES * SIZE), st.integers(0, FRAMES).map(lambda frame: frame * SIZE)
    ),
    extra=foreign,
    seed=st.integers(0, 99),
    start=st.sampled_from([3.2, 1234.5]),
)
def test_bytes_put_in(capture: Path, at: int, extra: bytes, seed: int, start: float) -> None:
    sent = messages(seed=seed, start=start)
    stream = b"".join(sent)
    frame, findings = read_stream(write(capture, [stream[:at] + extra + stream[at:]]))
    back = received_of(frame, sent)
    assert back == sorted(set(back))
    assert len(back) >= FRAMES - bool(at % SIZE) - 1
    assert findings


@pytest.mark.parametrize("size", SIZES)
def test_channels_lie_where_the_maker_says(capture: Path, size: int) -> None:
    sent = messages(5, size=size)
    frame, findings = read_stream(write(capture, sent))
    own = NEW if size >= 1044 else OLD if size == SIZE else OLD | LATER_OLD
    places = {"time": 4} | {name: at for name, at in own.items() if at < size}
    np.testing.assert_array_equal(bits(frame, places), rows(sent, pd.Index(places), places))
    assert not set(own) - set(places) & set(frame.columns)
    assert set(frame.dtypes) == {np.dtype("f8")}
    assert frame.attrs["message_bytes"] == size
    assert not findings


def test_every_frame_split_in_other_blocks(capture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks of CSV smaller than a stretch of messages end anywhere within them."""
    monkeypatch.setattr("ur5lib.recordings.realtime_stream.BLOCK_BYTES", 4096)
    sent = messages(400)
    chance = random.Random(1)
    cuts = [chance.randrange(400 * SIZE) for _ in range(900)]
    stream = b"".join(sent)
    frame, findings = read_stream(write(capture, chunked(stream, cuts)))
    assert received_of(frame, sent) == list(range(400))
    assert not findings
    holes = sorted(chance.sample(range(0, len(stream), 10_000), 12))
    parts = [stream[a + 77 : b] for a, b in zip([0, *holes], [*holes, len(stream)], strict=True)]
    chunks = [piece for part in parts for piece in chunked(part, range(500, len(part), 500))]
    frame, findings = read_stream(write(capture, chunks))
    assert len(received_of(frame, sent)) >= 400 - 13 * 3
    assert Found.BYTES_SKIPPED in named(findings)


def test_a_constant_size_word_in_every_message(capture: Path) -> None:
    """A capture that begins within a message finds the true beginnings all the same."""
    sent = [m[:424] + WORD + struct.pack(">d", 0.7) + m[436:] for m in messages(40, start=9.0)]
    frame, _ = read_stream(write(capture, [b"".join(sent)[300:]]))
    assert received_of(frame, sent) == list(range(1, 40))


def test_a_size_word_whose_stamp_never_advances_begins_no_message(capture: Path) -> None:
    """After damage, though 0.7 s may follow the last message as well as the true stamps do."""
    sent = [m[:424] + WORD + struct.pack(">d", 0.7) + m[436:] for m in messages(40)]
    frame, _ = read_stream(write(capture, [b"".join(sent[:5]), b"".join(sent[5:])[100:]]))
    assert received_of(frame, sent) == [0, 1, 2, 3, *range(6, 40)]


def test_a_restart_of_the_controller_and_stale_stamps(capture: Path) -> None:
    chance = random.Random(0)
    stamps = [700.0, 700.0, 700.008, 700.016, 700.016, 900.0, 900.008, 0.0, 0.008, 0.016]
    sent = [message(stamp, chance) for stamp in stamps]
    frame, findings = read_stream(write(capture, sent))
    assert frame["time"].tolist() == stamps
    assert received_of(frame, sent) == list(range(len(sent)))
    assert not findings


def test_begins_and_ends_within_messages(capture: Path) -> None:
    sent = messages(5)
    frame, findings = read_stream(write(capture, [b"".join(sent)[100:-200]]))
    assert received_of(frame, sent) == [1, 2, 3]
    assert [(f.code, f.severity, f.count) for f in findings] == [
        (Found.INCOMPLETE_MESSAGE, "note", 2)
    ]


@pytest.mark.parametrize(
    "line",
    [
        b"3.5,abc",
        b"3.5,zz",
        b"x,00ff",
        b",00ff",
        b"nan,00",
        b"3.5",
        b"3,0,1",
        b'3.5,"00',
        b"\xff\x00",
    ],
)
def test_damaged_lines(capture: Path, line: bytes) -> None:
    """Each is bytes lost: nothing is joined over it, not even where the length would fit."""
    sent = messages(6)
    head, tail = sent[2][:300], sent[3][300:]
    chunks = [sent[0], sent[1], head, None, tail, sent[4], sent[5]]
    lines = [
        line if c is None else b"%d.5,%s" % (k, c.hex().encode()) for k, c in enumerate(chunks)
    ]
    capture.write_bytes(b"received_s,payload_hex\n\n" + b"\n".join([*lines, line]))
    frame, findings = read_stream(capture)
    assert received_of(frame, sent) == [0, 1, 4, 5]
    assert frame["received"].tolist() == [0.5, 1.5, 5.5, 6.5]
    damaged = named(findings)[Found.DAMAGED_LINES]
    assert (damaged.severity, damaged.count) == ("warning", 2)
    assert said(damaged).endswith("the first is line 6")
    assert named(findings)[Found.BYTES_SKIPPED].count == SIZE


def test_two_layouts_in_one_capture(capture: Path) -> None:
    """The more frequent one is taken."""
    sent, others = messages(6), messages(3, size=1108, start=70.0)
    frame, findings = read_stream(write(capture, [*others, *sent]))
    assert received_of(frame, sent) == list(range(6))
    finding = named(findings)[Found.OTHER_LAYOUTS]
    assert (finding.severity, finding.count) == ("warning", 3)
    assert "1108" in said(finding)


def test_whole_multiples_cut_out_leave_no_trace(capture: Path) -> None:
    """Known limit: no damaged line, sizes that agree, one frame of two halves."""
    sent = messages(6)
    stream = b"".join(sent)
    frame, findings = read_stream(write(capture, [stream[: SIZE + 300], stream[2 * SIZE + 300 :]]))
    assert len(frame) == 5
    assert not findings


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not a CSV"),
        (b"received_s,payload_hex\n", "no complete message"),
        (b"0.5,00ff\n", "no complete message"),
        (
            b"0.5," + struct.pack(">id", 700, 1.0).hex().encode() + b"00" * 688,
            "no complete message",
        ),
        (b"a;b;c\n" * 5, "no complete message"),
        (b"0" * (1 << 24), "not a CSV"),
    ],
)
def test_what_is_no_capture_is_reported(capture: Path, content: bytes, words: str) -> None:
    capture.write_bytes(content)
    with pytest.raises(InputError, match=words) as error:
        read_stream(capture)
    assert str(capture) in str(error.value)
    assert "capture" in str(error.value).split(";")[1]
