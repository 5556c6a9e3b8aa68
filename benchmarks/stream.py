"""An hour of the realtime port, side by side in one run: this reader against struct in a loop."""

import csv
import multiprocessing
import resource
import statistics
import struct
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.harness.options import options_of
from benchmarks.harness.timing import timed
from ur5lib.lab.stand.device_files import MESSAGE_BYTES
from ur5lib.lab.stand.faults import FIRST_PART_BYTES
from ur5lib.recordings.realtime_stream import read_stream
from ur5lib.robots.realtime_message import fields

FRAMES, PERIOD = 450_000, 0.008  # an hour at 125 Hz
# Bytes a recv gives, as the thesis's Figure 4.4 shows them.
PACKETS = (
    *(MESSAGE_BYTES, MESSAGE_BYTES),
    *(MESSAGE_BYTES + FIRST_PART_BYTES, MESSAGE_BYTES - FIRST_PART_BYTES),
)
ARRIVALS = (0.0, 0.008, 0.024, 0.025)  # s
ROUNDS = 5
CHANNELS = {name: place.start for name, place in fields(MESSAGE_BYTES).items()}


def write_capture(path: Path, count: int) -> None:
    """Write a capture: frames of random doubles, four in 32 ms, in the packets of Figure 4.4."""
    random = np.random.default_rng(0)
    frames = np.zeros(10_000, [("size", ">i4"), ("doubles", ">f8", 94)])
    frames["size"] = MESSAGE_BYTES
    with path.open("w") as file:
        file.write("received_s,payload_hex\n")
        for first in range(0, count, len(frames)):
            frames["doubles"] = random.normal(size=(len(frames), 94))
            frames["doubles"][:, 0] = 100 + PERIOD * (first + np.arange(len(frames)))
            text, at = frames.tobytes().hex(), 0
            for group in range(first, first + len(frames), 4):
                for packet, arrival in zip(PACKETS, ARRIVALS, strict=True):
                    hexadecimal = text[at : at + 2 * packet]
                    file.write(f"{PERIOD * group + arrival:.6f},{hexadecimal}\n")
                    at += 2 * packet


def read_by_struct(path: Path) -> pd.DataFrame:
    """Read message by message with struct."""
    buffer, rows = bytearray(), []
    with path.open(newline="") as file:
        lines = csv.reader(file)
        next(lines)
        for received, payload in lines:
            buffer += bytes.fromhex(payload)
            while len(buffer) >= MESSAGE_BYTES:
                size, *doubles = struct.unpack(">i94d", buffer[:MESSAGE_BYTES])
                assert size == MESSAGE_BYTES
                row = [doubles[0], float(received)]
                for first in CHANNELS.values():
                    row += doubles[first : first + 6]
                rows.append(tuple(row))
                del buffer[:MESSAGE_BYTES]
    names = [f"{name}_{joint}" for name in CHANNELS for joint in range(6)]
    return pd.DataFrame(rows, columns=["time", "received", *names])


def read_by_library(path: Path) -> pd.DataFrame:
    """Read all messages at once."""
    return read_stream(path)[0]


def measure(read: Callable[[Path], pd.DataFrame], path: Path) -> tuple[float, float, float]:
    """Return seconds, peak memory of the process [GB], and a checksum of the data."""
    seconds, frames = timed(lambda: read(path))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9
    return seconds, peak, float(frames.sum().sum())


def main() -> None:
    """Print the table; each reader has a process of its own."""
    quick = options_of(__doc__).parse_args().quick
    count, repeats = (10_000, 1) if quick else (FRAMES, ROUNDS)
    readers = {"ours": read_by_library, "struct": read_by_struct}
    rounds: dict[str, list[tuple[float, float, float]]] = {name: [] for name in readers}
    spawn = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory() as folder, spawn.Pool(1) as ours, spawn.Pool(1) as theirs:
        path = Path(folder) / "capture.csv"
        write_capture(path, count)
        print(f"{count} frames, {path.stat().st_size / 1e6:.0f} MB; {repeats} rounds in turn")
        for _ in range(repeats + 1):  # the first warms up
            for process, (name, read) in zip((ours, theirs), readers.items(), strict=True):
                rounds[name].append(process.apply(measure, (read, path)))
    assert len({run[2] for runs in rounds.values() for run in runs}) == 1, "they do not agree"
    seconds = {name: [run[0] for run in runs[1:]] for name, runs in rounds.items()}
    print(f"{'reader':>8} {'fastest s':>10} {'median s':>10} {'peak GB':>10}")
    for name, times in seconds.items():
        peak = max(run[1] for run in rounds[name])
        print(f"{name:>8} {min(times):>10.2f} {statistics.median(times):>10.2f} {peak:>10.2f}")
    fastest = min(seconds["struct"]) / min(seconds["ours"])
    median = statistics.median(seconds["struct"]) / statistics.median(seconds["ours"])
    print(f"ratio of the fastest {fastest:.1f}, of the medians {median:.1f}")


if __name__ == "__main__":
    main()
