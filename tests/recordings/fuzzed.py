"""Damaged recordings: read through their entries, and imported."""

import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tests.corpus import made_up as thesis
from tests.corpus import rtde, table
from tests.damage import damaged_file
from tests.entries import read_and_check
from tests.fuzz import Attempt
from tests.stored_files import WRITERS, Made, made_up_channels, write
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.importing.parted_runs import runs_of
from ur5lib.robots.description import load_robot, robot_path

Damage = Callable[[random.Random, Path], dict[str, Any]]


def damage_of(folder: Path) -> Damage:
    """Write a recording of each format; return what damages one, and returns its entry."""
    made = made_up_channels(folder / "channels", seconds=4)
    entries = [
        base.recording for base in (rtde(folder, "rtde", b","), table(folder), thesis(folder))
    ]
    entries.append(npy_entry(folder, made))
    for kind in WRITERS:
        (folder / kind).mkdir()
        entries.append(write(kind, folder / kind, *made))

    def damaged(draw: random.Random, place: Path) -> dict[str, Any]:
        entry = draw.choice(entries)
        copy = Path(shutil.copytree(entry["folder"], place / "run"))
        file = draw.choice(sorted(path for path in copy.rglob("*") if path.is_file()))
        file.write_bytes(damaged_file(file.read_bytes(), draw).data)
        return entry | {"folder": str(copy)}

    return damaged


def npy_entry(folder: Path, made: Made) -> dict[str, Any]:
    """Write a NumPy file of positions and currents; return its entry."""
    names = ["actual_q", "actual_current"]
    (folder / "npy").mkdir()
    np.save(folder / "npy" / "run.npy", np.column_stack([made[0], *(made[1][n] for n in names)]))
    place = {"format": "table-csv", "folder": str(folder / "npy"), "file": "run.npy"}
    return place | {"columns": ["time", *names]}


def recordings(folder: Path) -> Attempt:
    """Return what reads a damaged recording through its entry, and checks it."""
    damaged, arm = damage_of(folder), load_robot(robot_path("ur5"))

    def attempt(draw: random.Random, place: Path) -> None:
        read_and_check(damaged(draw, place), arm, 0.1)

    return attempt


def imports(folder: Path) -> Attempt:
    """Return what imports the files of a damaged recording, of an arm that may be named."""
    damaged = damage_of(folder)

    def attempt(draw: random.Random, place: Path) -> None:
        copy = Path(damaged(draw, place)["folder"])
        files = sorted(path for path in copy.rglob("*") if path.is_file())
        import_files([*runs_of(files)], UserStatement(draw.choice(["ur5", ""])))

    return attempt


TARGETS = {"recordings": recordings, "imports": imports}
