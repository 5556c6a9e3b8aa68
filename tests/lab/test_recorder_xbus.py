"""Xbus and its data: what is decoded is what was sent, however a stream is damaged."""

import math
import os
import random
import re
import struct
import sys
import tty

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tests.damage import DRAWS, damaged_stream, drawn
from ur5lab.recorder.xbus import (
    Decoder,
    Message,
    XbusPort,
    decode_mtdata,
    decode_mtdata2,
    encode,
)
from ur5lib.errors import InputError

STREAMS = 1000

# An MTData2 message with the checksum that its device sent.
SAMPLE = bytes.fromhex(
    "FAFF3631 102002DFC5 106004 00459DA0 40200C BEDC9AFA3F549F37411CBB70"
    "80200C BBAA5C803B8C5501BB813300 E0200400000081 45"
)
COMMANDS = {"FAFF3000D1": 0x30, "FAFF1000F1": 0x10, "FAFF000001": 0x00, "FAFF3E00C3": 0x3E}


def frame(identifier: int, data: bytes) -> bytes:
    """A message put together without the module that is tested."""
    head = bytes([0xFF, identifier])
    head += struct.pack(">B", len(data)) if len(data) < 255 else struct.pack(">BH", 255, len(data))
    checksum = 0
    for byte in head + data:
        checksum = (checksum - byte) & 0xFF
    return b"\xfa" + head + data + bytes([checksum])


# Frames


@pytest.mark.parametrize(("packet", "identifier"), COMMANDS.items())
def test_commands_are_those_of_the_manual(packet: str, identifier: int) -> None:
    assert encode(identifier).hex().upper() == packet
    assert Decoder().feed(bytes.fromhex(packet)) == [Message(identifier, b"")]


@example(0x36, bytes(254))
@example(0x36, bytes(255))
@example(0x36, bytes(2048))
@given(st.integers(0, 255), st.binary(max_size=400))
def test_what_is_decoded_is_what_was_encoded(identifier: int, data: bytes) -> None:
    """Long messages have an extended length."""
    packet = encode(identifier, data)
    assert packet == frame(identifier, data)
    assert Decoder().feed(packet) == [Message(identifier, data)]


def test_a_short_message_with_an_extended_length_is_none() -> None:
    wrong = b"\xff\x36\xff\x00\x10" + bytes(16)
    packet = b"\xfa" + wrong + bytes([-sum(wrong) % 256])
    assert Decoder().feed(packet + encode(0x31)) == [Message(0x31, b"")]


@given(st.lists(st.binary(max_size=30), max_size=5), st.data())
def test_pieces_give_the_same_messages_as_the_whole(
    parts: list[bytes], data: st.DataObject
) -> None:
    stream = b"\xfa".join(encode(0x36, part) for part in parts)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=6)))
    decoder = Decoder()
    pieces = zip([0, *cuts], [*cuts, len(stream)], strict=True)
    found = [message for start, end in pieces for message in decoder.feed(stream[start:end])]
    assert found == Decoder().feed(stream)


@drawn(STREAMS)
@given(draw=DRAWS)
def test_damaged_streams_give_no_message_with_a_wrong_checksum(draw: random.Random) -> None:
    """Each accepted message stands in the stream with its checksum, after the one before it."""
    sizes = [draw.choice([0, 4, 49, 57, draw.randint(250, 260)]) for _ in range(6)]
    sent = [frame(draw.randrange(256), draw.randbytes(size)) for size in sizes]
    stream = b"".join(sent)
    for _ in range(draw.randint(1, 3)):
        stream = damaged_stream(stream, draw)
    decoder, found, at = Decoder(), [], 0
    while at < len(stream):
        step = draw.randint(1, 200)
        found += decoder.feed(stream[at : at + step])
        at += step
    end = 0
    for message in found:
        packet = frame(*message)
        start = stream.find(packet, end)
        assert start >= end
        end = start + len(packet)
    assert len(found) <= len(sent) + 3


def test_damage_costs_the_messages_that_it_touches() -> None:
    sent = [frame(0x36, bytes([number] * 40)) for number in range(20)]
    for at in range(4, 45):  # behind the length, which may reach into the next messages
        spoilt = sent[10][:at] + b"\x77" + sent[10][at:]
        found = Decoder().feed(b"".join([*sent[:10], spoilt, *sent[11:]]))
        numbers = {message.data[0] for message in found if len(message.data) == 40}
        assert numbers >= {*range(10), *range(11, 20)}


# A port


def test_an_answer_is_found_among_data_and_those_after_it_are_kept() -> None:
    """All have arrived at once; the data before the answer are skipped."""
    device, line = os.openpty()
    tty.setraw(line)
    port = XbusPort(os.ttyname(line), 115200)
    before, answer, after = (0x36, b"before"), (0x31, b"yes"), [(0x36, b"1"), (0x36, b"2")]
    os.write(device, b"".join(encode(*one) for one in (before, answer, *after)))
    assert port.ask(0x30) == b"yes"
    assert port.receive() == after
    port.close()
    os.close(device)
    os.close(line)


# Samples


def test_a_sample_of_the_manual() -> None:
    [message] = Decoder().feed(SAMPLE)
    sample = decode_mtdata2(message.data)
    assert sample is not None
    assert (sample.counter, sample.time_fine) == (0xDFC5, 0x00459DA0)
    assert sample.vectors[:3] == pytest.approx((-0.43087, 0.83055, 9.79576), abs=1e-5)
    assert sample.vectors[3:6] == pytest.approx((-0.00520, 0.00428, -0.00394), abs=1e-5)
    assert all(math.isnan(number) for number in sample.vectors[6:])


def test_golden_bytes_of_each_precision() -> None:
    """1.5, −1.5 and 0."""
    for precision, item in {
        0: "3FC00000 BFC00000 00000000",
        1: "00180000 FFE80000 00000000",
        2: "800000000001 80000000FFFE 000000000000",
        3: "3FF8000000000000 BFF8000000000000 0000000000000000",
    }.items():
        numbers = bytes.fromhex(item)
        name = struct.pack(">HB", 0x8020 | precision, len(numbers))
        sample = decode_mtdata2(b"\x10\x20\x02\x00\x07" + name + numbers)
        assert sample is not None
        assert sample.vectors[3:6] == (1.5, -1.5, 0.0)


@pytest.mark.parametrize(
    "data", ["", "10", "102002", "10200200", "40200C" + 12 * "00", "102002000740200B" + 11 * "00"]
)
def test_an_inconsistent_sample_is_none(data: str) -> None:
    assert decode_mtdata2(bytes.fromhex(data)) is None


def test_mtdata_of_the_first_generation() -> None:
    numbers = [0.5, -1.0, 9.75, 0.25, 0.0, -0.125, 0.5, 0.25, -0.75]
    sample = decode_mtdata(struct.pack(">9fH", *numbers, 65535))
    assert sample is not None
    assert sample.counter == 65535
    assert [*sample.vectors] == numbers


def test_mtdata_of_other_settings_is_none() -> None:
    assert decode_mtdata(struct.pack(">10fH", *range(10), 0)) is None
    assert decode_mtdata(struct.pack(">6fH", *range(6), 0)) is None


@drawn(STREAMS)
@given(data=st.binary(max_size=80), draw=DRAWS)
def test_random_data_never_raises(data: bytes, draw: random.Random) -> None:
    decode_mtdata2(data)
    decode_mtdata(data)
    decode_mtdata2(damaged_stream(SAMPLE[4:-1], draw))


def test_a_missing_package_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(
        InputError, match="reading the IMU needs the extra `record`; install it"
    ) as told:
        XbusPort("/dev/null", 115200)
    assert re.search(r": pip install 'pyserial>=[\d.]+' 'ur-rtde>=[\d.]+'$", str(told.value))
