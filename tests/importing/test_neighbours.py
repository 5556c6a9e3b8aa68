"""What a file proves hangs on no file beside it, and no stop sign comes or goes with one."""

from collections.abc import Callable
from itertools import permutations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.stored_files import made_up_channels
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import TO_BE_CORRECTED, ImportedRecording, import_files
from ur5lib.timeseries.arrays import Array

Spoil = Callable[[Array], Array]
EFFORTS: dict[str, Spoil] = {  # of the second file
    "as in the first": lambda current: current,
    "in mA": lambda current: 1e3 * current,
    "of opposite sign": lambda current: -current,
    "of one joint turned": lambda current: current * [1, -1, 1, 1, 1, 1],
    "in no unit": lambda current: current * np.linspace(40, 120, 6),
}


def log(folder: Path, name: str, seed: int, spoil: Spoil) -> Path:
    (folder / f"made_{name}").mkdir()
    time, channels = made_up_channels(folder / f"made_{name}", 10, seed)
    parts = {"q": channels["actual_q"], "qd": channels["actual_qd"]}
    parts["effort"] = spoil(channels["actual_current"])
    columns = {f"{part}_{k}": rows[:, k] for part, rows in parts.items() for k in range(6)}
    pd.DataFrame({"time": time} | columns).to_csv(folder / f"{name}.csv", index=False)
    return folder / f"{name}.csv"


def shown(one: ImportedRecording) -> tuple[dict[str, object], list[str], list[str]]:
    """The entry without its neighbours' place, what is proven, and the stop signs."""
    entry = {key: value for key, value in one.entry.items() if key not in ("name", "after")}
    proven = [r.reason for r in one.account if r.confidence == "proven" and r.subject != "after"]
    return entry, proven, [r.reason for r in one.account if r.taken_for == TO_BE_CORRECTED]


@pytest.mark.parametrize("efforts", EFFORTS)
@pytest.mark.parametrize("stated", [UserStatement(), UserStatement("ur5")])
def test_a_file_is_the_same_alone_and_with_a_neighbour(
    tmp_path: Path, efforts: str, stated: UserStatement
) -> None:
    files = [log(tmp_path, "first", 5, EFFORTS["as in the first"])]
    files += [log(tmp_path, "second", 6, EFFORTS[efforts])]
    alone = {file: shown(import_files([file], stated)[0]) for file in files}
    for both in permutations(files):
        for file, one in zip(both, import_files(both, stated), strict=True):
            entry, proven, stops = shown(one)
            assert {*alone[file][1]} <= {*proven}
            assert stops == alone[file][2]
            if alone[file][1]:
                assert entry == alone[file][0]
