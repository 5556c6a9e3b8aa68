"""Damaged bags, HDF5 and MAT files: what a disk, a network or a crash does to them.

    python -m tests.stored_corpus 3000

prints how many were refused, told, or right, and each that was none of these. Damage that nothing
in a file tells from good data is left out: a number that changed within what an arm may do, and
blocks that hold good data of another place.
"""

import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tests.stored_files import Made, made_up_channels, write
from tests.time_limit import time_limit
from ur5lib.errors import InputError
from ur5lib.recordings.intake import Intake, read_and_repair
from ur5lib.robots.description import Robot, load_robot, robot_path

SECONDS = 10  # for one file
KINDS = ("hdf5", "mat", "mat 7.3", "rosbag", "rosbag mcap")
JARGON = re.compile(r"Traceback|Error\b|Exception|numpy|NoneType|dtype|0x[0-9a-f]+|h5py|sqlite")
FLIPPED = 7  # bytes at most
TOLERANCE = 0.15  # share of a channel's span within which a value is interpolated or noise
Damage = Callable[[bytes, np.random.Generator], bytes]


def cut(data: bytes, random: np.random.Generator) -> bytes:
    """The end is missing."""
    return data[: int(random.integers(0, len(data)))]


def zeroed(data: bytes, random: np.random.Generator) -> bytes:
    """A block was never written."""
    size = int(random.choice([64, 512, 4096, 16384]))
    start = int(random.integers(0, len(data))) // size * size
    return data[:start] + b"\0" * min(size, len(data) - start) + data[start + size :]


def garbled(data: bytes, random: np.random.Generator) -> bytes:
    """A block holds random bytes."""
    size = int(random.choice([16, 512, 4096]))
    start = int(random.integers(0, len(data))) // size * size
    return data[:start] + random.bytes(min(size, len(data) - start)) + data[start + size :]


def flipped_head(data: bytes, random: np.random.Generator) -> bytes:
    """Bytes of the first kilobytes, where the structure is told, are others."""
    changed = bytearray(data)
    for place in random.integers(0, min(len(data), 3000), int(random.integers(1, FLIPPED + 1))):
        changed[place] = int(random.integers(256))
    return bytes(changed)


def lost(data: bytes, random: np.random.Generator) -> bytes:
    """Some bytes are missing inside."""
    start, size = int(random.integers(0, len(data))), int(random.integers(1, 5000))
    return data[:start] + data[start + size :]


def inserted(data: bytes, random: np.random.Generator) -> bytes:
    """Some bytes too many inside."""
    start = int(random.integers(0, len(data)))
    return data[:start] + random.bytes(int(random.integers(1, 5000))) + data[start:]


def text(data: bytes, random: np.random.Generator) -> bytes:
    """A page of text, as where a download failed."""
    return b"<html><body>404 not found</body></html>\n" * int(random.integers(1, 9))


def nothing(data: bytes, random: np.random.Generator) -> bytes:
    """An empty file."""
    return b""


def is_in_place(label: str) -> bool:
    """Whether a damage changed bytes and moved none."""
    return label.endswith((flipped_head.__name__, garbled.__name__))


DAMAGES: list[Damage] = [cut, zeroed, garbled, flipped_head, lost, inserted, text, nothing]
WEIGHTS = np.array([5, 5, 5, 5, 3, 3, 0.5, 0.3])


def damaged(
    folder: Path, made: Made, count: int, seed: int
) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield a format, a label and the entry of damaged files, each in the place of the last."""
    whole = {kind: write(kind, folder, *made) for kind in KINDS}
    contents = {kind: (folder / entry["file"]).read_bytes() for kind, entry in whole.items()}
    random = np.random.default_rng(seed)
    for index in range(count):
        kind = KINDS[index % len(KINDS)]
        damage = DAMAGES[int(random.choice(len(DAMAGES), p=WEIGHTS / WEIGHTS.sum()))]
        path = folder / f"damaged_{whole[kind]['file']}"
        path.write_bytes(damage(contents[kind], random))
        yield kind, f"{index}: {kind}, {damage.__name__}", whole[kind] | {"file": path.name}


def objection(entry: dict[str, Any], arm: Robot, whole: Intake, in_place: bool) -> tuple[str, str]:
    """What came of a damaged file, and what is dishonest about it.

    Refused, told, right, or possible: a few numbers that changed within what an arm
    may do, where bytes changed in place.
    """
    try:
        with time_limit(SECONDS):
            taken = read_and_repair(entry, arm, 0.1)
    except InputError as error:
        told = str(error)
        clear = "; " in told and entry["file"] in told and "\n" not in told
        return "refused", "" if clear and not JARGON.search(told) else f"unclear: {told}"
    except BaseException as error:
        return "failed", f"{type(error).__name__}: {error}"
    named = names_of(taken) - names_of(whole)
    lost, wrong = differences(taken, whole)
    if (wrong or lost) and not named:
        few = in_place and not lost and sum(wrong.values()) <= FLIPPED
        fault = f"silently wrong: {wrong}, {lost} frames fewer"
        return ("possible", "") if few else ("wrong", fault)
    return ("told" if named else "right"), ""


def names_of(taken: Intake) -> set[tuple[str, int]]:
    return {(finding["finding"], finding["count"]) for finding in taken.quality["findings"]}


def differences(taken: Intake, whole: Intake) -> tuple[int, dict[str, int]]:
    """How many frames are lost, and how many cells of each channel differ at their time."""
    mine, right = taken.robot, whole.robot
    lost = len(right) - len(mine) if len(mine) < len(right) - 1 else 0
    found = {}
    time = np.clip(mine["time"], right["time"].iloc[0], right["time"].iloc[-1])
    for name in right.columns.difference(["time", "segment", "interpolated"]):
        if name not in mine:
            found[name] = len(right)
            continue
        truth = np.interp(time, right["time"], right[name])
        bound = TOLERANCE * np.ptp(right[name])
        wrong = int((~(np.abs(mine[name] - truth) <= bound) & ~mine["interpolated"]).sum())
        found |= {name: wrong} if wrong else {}
    return lost, found


def main(count: int, seed: int) -> int:
    """Print the outcome of many damaged files; returns how many answers were dishonest."""
    arm, outcomes, faults = load_robot(robot_path("ur5")), Counter[str](), []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = made_up_channels(folder, seconds=4)
        wholes = {k: read_and_repair(write(k, folder, *made), arm, 0.1) for k in KINDS}
        for kind, label, entry in damaged(folder, made, count, seed):
            outcome, fault = objection(entry, arm, wholes[kind], is_in_place(label))
            outcomes[outcome] += 1
            faults += [f"{label}: {fault}"] if fault else []
    print(dict(outcomes), *faults, sep="\n")
    return len(faults)


if __name__ == "__main__":
    sys.exit(bool(main(int(sys.argv[1]), int((sys.argv[2:] or ["1"])[0]))))
