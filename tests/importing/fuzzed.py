"""Damaged logs that several files, or other words, make up: folders, traces, a sensor's file."""

import random
import shutil
from pathlib import Path

import numpy as np
import pandas as pd

from tests.damage import damaged_file
from tests.fuzz import Attempt
from tests.importing.test_import_account import lerobot
from tests.importing.test_two_files import write as write_two
from tests.stored_files import made_up_channels
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.importing.parted_runs import runs_of

TRACE = {"actual_q": "Ist [Grad]", "actual_current": "Motormoment [Nm]"}
KINDS = {"trace": "kuka-kr300", "two files": "ur5e", "lerobot": "ur5e"}  # and their arms


def write_trace(folder: Path) -> None:
    """A KUKA controller's own trace: semicolons, decimal commas, degrees."""
    time, channels = made_up_channels(folder.parent / "channels", seconds=4)
    columns = {"Zeit [s]": time}
    for name, words in TRACE.items():
        values = np.degrees(channels[name]) if name == "actual_q" else channels[name]
        columns |= {f"A{k + 1} {words}": own for k, own in enumerate(values.T)}
    text = pd.DataFrame(columns).to_csv(sep=";", decimal=",", index=False, float_format="%.5f")
    (folder / "trace.csv").write_text(text)


def folders(folder: Path) -> Attempt:
    """Return what imports a folder with one damaged file, by an arm and a sensor as named."""
    for kind in KINDS:
        (folder / kind).mkdir()
    write_trace(folder / "trace")
    write_two(folder / "two files")
    lerobot(folder / "lerobot", named=True)

    def attempt(draw: random.Random, place: Path) -> None:
        kind = draw.choice([*KINDS])
        copy = Path(shutil.copytree(folder / kind, place / "run"))
        files = sorted(path for path in copy.rglob("*") if path.is_file())
        file = draw.choice(files)
        file.write_bytes(damaged_file(file.read_bytes(), draw).data)
        stated = UserStatement(draw.choice([KINDS[kind], ""]))
        if kind == "two files" and draw.random() < 0.5:
            robot, sensor = files
            import_files([robot], UserStatement(stated.robot, sensor=sensor))
        else:
            import_files([*runs_of(files)], stated)

    return attempt


TARGETS = {"folders": folders}
