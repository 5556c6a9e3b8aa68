"""`ur5 import` on logs of random form: an entry for each, right or marked `check`."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.entries import read_recording
from tests.library.test_import_cases import driven, motion
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import ImportedRecording, import_files
from ur5lib.robots.description import load_robot, robot_names, robot_path
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

MOVED = ("actual_q", "actual_qd", "actual_current")
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
NAMES = {  # of a column of positions, velocities and currents
    "rtde": ("actual_q_{k}", "actual_qd_{k}", "actual_current_{k}"),
    "wrapper": ("Act_q{k}", "Act_qd{k}", "Act_I{k}"),
    "lower": ("act_q{k}", "act_qd{k}", "act_current{k}"),
    "numbered": ("q{n}", "dq{n}", "i{n}"),
    "joint_pos": ("joint_{n}_pos", "joint_{n}_vel", "joint_{n}_cur"),
    "panel": ("J{n} Position", "J{n} Speed", "J{n} Current"),
    "brackets": ("q[{k}]", "qd[{k}]", "current[{k}]"),
    "ros": ("{joint}_position", "{joint}_velocity", "{joint}_current"),
    "unit": ("q_{n} [{angle}]", "qd_{n} [{angle}/s]", "current_{n} [{ampere}]"),
    "none": ("", "", ""),
}
CLOCKS = {"s": 1.0, "ms": 1e3, "us": 1e6, "epoch": 1.0, "none": 0.0}
SEPARATORS = {",": ".csv", ";": ".csv", "\t": ".tsv", " ": ".txt"}


def written(seed: int, folder: Path) -> tuple[Path, str, dict[str, Array], UserStatement]:
    """A log of a random arm and form, its form in words, its channels, what the user says."""
    random = np.random.default_rng(seed)
    arm = load_robot(robot_path(str(random.choice(robot_names()))))
    rate = float(random.choice([43.5, 100.0, 125.0, 500.0]))
    time = np.arange(0, 12, 1 / rate)
    q, qd, qdd = motion(arm, time, random)
    current = driven(arm, q, qd, qdd, None, random)["actual_current"]
    names, clock = str(random.choice([*NAMES])), str(random.choice([*CLOCKS]))
    mark = str(random.choice([*SEPARATORS][: 3 if " " in NAMES[names][0] else 4]))
    angle, ampere = str(random.choice(["rad", "deg"])), str(random.choice(["A", "mA"]))
    turn, milli = 180 / np.pi if angle == "deg" else 1.0, 1e3 if ampere == "mA" else 1.0
    columns = dict[str, Array]()
    if clock != "none":
        columns["time"] = (1.7e9 if clock == "epoch" else 0.0) + time * CLOCKS[clock]
    for name, rows in zip(NAMES[names], (turn * q, turn * qd, milli * current), strict=True):
        for k in range(6):
            words = {"k": k, "n": k + 1, "joint": JOINTS[k], "angle": angle, "ampere": ampere}
            columns[name.format(**words) or f"{len(columns)}"] = rows[:, k]
    path = folder / f"run{seed}{SEPARATORS[mark]}"
    text = pd.DataFrame(columns).round(9)
    text.to_csv(path, sep=mark, index=False, header=names != "none")
    told = UserStatement(arm.name, rate=rate if clock == "none" and random.random() < 0.5 else None)
    form = f"{arm.name} {names} {mark!r} {clock} {rate:g} Hz {angle} {ampere} rate {told.rate}"
    return path, form, dict(zip(MOVED, (q, qd, current), strict=True)), told


def wrong(found: ImportedRecording, truth: dict[str, Array]) -> list[str]:
    """The channels of an entry that are not as they were, or missing."""
    table = read_recording(found.entry).robot.table
    there = {name: channel(table, name) for name in MOVED if f"{name}_0" in table}
    wrong = [name for name in MOVED if name not in there]
    return wrong + [n for n, rows in there.items() if not np.allclose(rows, truth[n], atol=1e-5)]


def outcome(seed: int, folder: Path) -> dict[str, Any]:
    """What import made of a log: nothing wrong, or marked `check`, or left out with a reason."""
    path, form, truth, stated = written(seed, folder)
    try:
        (found,) = import_files([path], stated)
    except InputError as error:  # without names and at rest
        asked = "--columns" in str(error)
        return {"form": form, "wrong": [*MOVED], "marked": asked, "said": [str(error)]}
    marked = any(row.confidence in ("check", "left out") for row in found.account)
    return {"form": form, "wrong": wrong(found, truth), "marked": marked, "said": found.account}


@pytest.mark.parametrize("seed", range(12))
def test_no_form_is_silently_wrong(seed: int, tmp_path: Path) -> None:
    made = outcome(seed, tmp_path)
    assert made["marked"] or not made["wrong"], made


@pytest.mark.slow
@pytest.mark.thorough
def test_none_of_two_hundred_forms_is_silently_wrong(tmp_path: Path) -> None:
    made = [outcome(seed, tmp_path) for seed in range(200)]
    assert [one for one in made if one["wrong"] and not one["marked"]] == []
    assert sum(not one["wrong"] for one in made) > 150
