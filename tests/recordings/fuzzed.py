"""Damaged recordings: read through their entries, and imported."""

import random
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.corpus import made_up as thesis
from tests.corpus import rtde, table
from tests.damage import damaged_file
from tests.entries import read_and_check
from tests.fuzz import Attempt
from tests.stored_files import WRITERS, made_up_channels, write
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
