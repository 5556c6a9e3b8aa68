"""An hour of a robot at 500 Hz as CSV, side by side in one run: this reader and pyarrow alone."""

import statistics
import tempfile
from pathlib import Path

import numpy as np
import pyarrow.csv as pacsv

from benchmarks.harness.options import options_of
from benchmarks.harness.timing import seconds
from ur5lib.recordings.delimited import read_numbers
from ur5lib.recordings.quality import Finding, Log

RATE, SECONDS = 500, 3600
CHANNELS = ("target_q", "actual_q", "actual_qd", "actual_current", "target_moment")
BLOCK = 5000  # rows that are made once and written again and again
ROUNDS = 3


def write_recording(path: Path, count: int) -> None:
    """Write a synthetic recording: increasing stamps, channels that repeat every ten seconds."""
    random = np.random.default_rng(0)
    names = [f"{channel}_{joint}" for channel in CHANNELS for joint in range(6)]
    rows = [",".join(f"{value:.6f}" for value in row) for row in random.normal(size=(BLOCK, 30))]
    with path.open("w") as stream:
        stream.write(",".join(["timestamp", *names]) + "\n")
        for start in range(0, count, BLOCK):
            stream.writelines(
                f"{(start + index) / RATE:.3f},{row}\n" for index, row in enumerate(rows)
            )


def main() -> None:
    """Print both times and their ratio."""
    quick = options_of(__doc__).parse_args().quick
    count, repeats = (2 * BLOCK, 1) if quick else (RATE * SECONDS, ROUNDS)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hour.csv"
        write_recording(path, count)
        findings: list[Finding] = []
        rounds = [
            (
                seconds(lambda: pacsv.read_csv(path)),
                seconds(lambda: read_numbers(Log(path, "robot", findings), None)),
            )
            for _ in range(repeats + 1)
        ][1:]  # the first warms up
        size = path.stat().st_size / 1e6
    theirs, ours = (statistics.median(side) for side in zip(*rounds, strict=True))
    print(f"{count} rows of {1 + 6 * len(CHANNELS)} columns, {size:.0f} MB, median of {repeats}")
    print(f"pyarrow {theirs:.2f} s, read_numbers {ours:.2f} s, ratio {ours / theirs:.2f}")
    assert not findings


if __name__ == "__main__":
    main()
