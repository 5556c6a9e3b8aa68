"""RDT: what is decoded is what was sent, and nothing else, however a stream is damaged."""

import random
import struct
from itertools import pairwise

import pytest
from hypothesis import given

from tests.damage import DRAWS, damaged_stream, drawn
from ur5lab.recorder import net_ft
from ur5lab.recorder.device import Counter

RATE = 1000.0
STREAMS = 1000
RECORD = bytes.fromhex(
    "00000001 00000007 80020000 000f4240 fff0bdc0 00000000 7fffffff 80000000 00000002".replace(
        " ", ""
    )
)


@pytest.mark.parametrize(
    ("command", "sent"),
    [
        (net_ft.STREAM, "1234000200000000"),
        (net_ft.STOP, "1234000000000000"),
        (net_ft.SET_BIAS, "1234004200000000"),
    ],
)
def test_requests_are_those_of_the_manual(command: int, sent: str) -> None:
    assert net_ft.request(command).hex() == sent


def test_a_record_is_that_of_the_manual() -> None:
    sequence, internal, status, *counts = net_ft.decode(RECORD) or ()
    assert (sequence, internal) == (1, 7)
    assert status == net_ft.ERROR_BIT | net_ft.SATURATION_BIT
    assert counts == [1_000_000, -1_000_000, 0, 2**31 - 1, -(2**31), 2]


@pytest.mark.parametrize(
    ("bits", "numbers", "missing"),
    [
        (32, [5, 6, 9, 10], [0, 0, 2, 0]),
        (32, [2**32 - 2, 2**32 - 1, 0, 3], [0, 0, 0, 2]),  # wraps around
        (16, [2**16 - 2, 1], [0, 2]),
        (32, [5, 5, 8, 7, 6, 9], [0, None, 2, None, None, 0]),  # repeated or late
        (32, [5, 5 + 10_001, 6, 6 + 10_000], [0, None, 0, 9999]),  # a jump beyond ten seconds
        (16, [5, 5 + 10_001, 6], [0, None, 0]),
    ],
)
def test_a_counter_counts_what_is_lost(
    bits: int, numbers: list[int], missing: list[int | None]
) -> None:
    counter = Counter(bits, RATE)
    assert [counter.lost_before(number) for number in numbers] == missing


def spoilt(records: list[bytes], draw: random.Random) -> list[bytes]:
    """Datagrams after up to three faults: damaged, repeated, lost, or in another order."""
    for _ in range(draw.randint(1, 3)):
        at = draw.randrange(len(records))
        match draw.choice(["damage", "repeat", "lose", "swap"]):
            case "damage":
                records[at] = damaged_stream(records[at], draw)
            case "repeat":
                records.insert(draw.randint(at, len(records)), records[at])
            case "lose" if len(records) > 1:
                del records[at]
            case "swap":
                records.insert(draw.randrange(len(records)), records.pop(at))
    return records


@drawn(STREAMS)
@given(draw=DRAWS)
def test_damaged_streams_give_records_in_order_or_nothing(draw: random.Random) -> None:
    first = draw.choice([1, 2**32 - 3, draw.randrange(2**32)])
    sent = [
        struct.pack(">III6i", (first + k) % 2**32, 7 * k, 0, *draw.sample(range(-9, 9), 6))
        for k in range(8)
    ]
    arrived = spoilt(sent.copy(), draw)
    counter, accepted, missing = Counter(net_ft.SEQUENCE_BITS, net_ft.MAX_RECORD_RATE), [], 0
    for datagram in arrived:
        record = net_ft.decode(datagram)
        before = counter.lost_before(record[0]) if record else None
        if record and before is not None:
            accepted.append((record, datagram))
            missing += before
    steps = [
        (int.from_bytes(after[1][:4], "big") - int.from_bytes(before[1][:4], "big")) % 2**32
        for before, after in pairwise(accepted)
    ]
    assert all(0 < step <= 10 * net_ft.MAX_RECORD_RATE for step in steps)
    assert missing == sum(step - 1 for step in steps)
    for record, datagram in accepted:
        assert len(datagram) == 36
        assert b"".join((n % 2**32).to_bytes(4, "big") for n in record) == datagram
