"""The form of a maker's log is words and letters of one module, below whatever header it has."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.entries import read_recording
from tests.importing.test_import_cases import motion
from ur5lib.errors import InputError
from ur5lib.importing import spellings
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import ImportedRecording, import_files
from ur5lib.records.account import AccountRow
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

YASKAWA = "/JOB MOTION.JBI\n//TOOL 0\n///PULSE\n"
PULSES = np.array([76857.0, 76857.0, 76857.0, 57296.0, 57296.0, 35638.0])  # a radian


@pytest.fixture(scope="module")
def made() -> tuple[Array, Array, Array]:
    """Time (N,), angles and rates (N, 6) of an arm that swings its joints."""
    time = np.arange(0, 10, 0.02)
    arm = load_robot(robot_path("ur5e"))
    q, qd, _ = motion(arm, time, np.random.default_rng(5))
    return time, q, qd


def written(
    path: Path, made: tuple[Array, Array, Array], names: list[str], head: str
) -> pd.DataFrame:
    """A log of pulses and their rates; names: with a joint's letter each, by quantity."""
    time, q, qd = made
    columns = np.column_stack([np.round(q * PULSES), np.round(qd * PULSES), np.sin(2 * q) * 40])
    table = pd.DataFrame(np.column_stack([time, columns]), columns=["TIME", *names])
    path.write_text(head + table.to_csv(index=False))
    return table


def imported(path: Path, **units: str) -> ImportedRecording:
    (one,) = import_files([path], UserStatement("ur5e", units=units))
    return one


def marked(one: ImportedRecording) -> dict[str, AccountRow]:
    return {row.subject: row for row in one.account if row.confidence == "check"}


def expect_pulses_until_named(
    path: Path, made: tuple[Array, Array, Array], letters: str, stem: str
) -> None:
    """Positions are kept and marked, and what the mark names reads them, rates and all."""
    one = imported(path)
    title = f"{letters[0]}{stem} … {letters[-1]}{stem}"
    assert marked(one)[title].taken_for.startswith("actual_q")
    assert "--unit actual_q=" in marked(one)[title].reason
    assert "no angles" in marked(one)["columns"].reason
    named = imported(path, actual_q=",".join(f"{1 / each:.9g}" for each in PULSES))
    assert not {title, "columns"} & {*marked(named)}
    table = read_recording(named.entry).robot.table
    np.testing.assert_allclose(channel(table, "actual_q"), made[1], atol=1e-4)
    np.testing.assert_allclose(channel(table, "actual_qd"), made[2], atol=1e-3)


@pytest.mark.parametrize("unit", ["", " [pulse]"])
def test_yaskawas_pulses_are_kept_until_their_unit_is_named(
    tmp_path: Path, made: tuple[Array, Array, Array], unit: str
) -> None:
    rate = unit.replace("]", "/s]")
    names = [f"{letter}_{q}" for q in (f"POS{unit}", f"SPD{rate}", "TRQ") for letter in "SLURBT"]
    written(tmp_path / "log.csv", made, names, YASKAWA)
    expect_pulses_until_named(tmp_path / "log.csv", made, "SLURBT", f"_POS{unit}")


def test_a_new_makers_form_is_an_entry_of_one_module(
    tmp_path: Path, made: tuple[Array, Array, Array], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of letters and words that nobody has yet."""
    words = {
        "q": {*spellings.JOINT_QUANTITY_WORDS["q"], "stellung"},
        "qd": {*spellings.JOINT_QUANTITY_WORDS["qd"], "tempo"},
        "torque": {*spellings.JOINT_QUANTITY_WORDS["torque"], "drehkraft"},
    }
    names = [f"{letter} {q}" for q in ("Stellung", "Tempo", "Drehkraft") for letter in "GHKMVW"]
    written(tmp_path / "log.csv", made, names, "LOG OF CELL 4\n;no tool\n")
    with pytest.raises(InputError):
        imported(tmp_path / "log.csv")
    monkeypatch.setattr(spellings, "LETTERED_JOINTS", (*spellings.LETTERED_JOINTS, "GHKMVW"))
    for kind, its in words.items():
        monkeypatch.setitem(spellings.JOINT_QUANTITY_WORDS, kind, its)
    expect_pulses_until_named(tmp_path / "log.csv", made, "GHKMVW", " Stellung")


def test_values_are_one_or_one_of_each_column(
    tmp_path: Path, made: tuple[Array, Array, Array]
) -> None:
    names = [f"{letter}_{q}" for q in ("POS", "SPD", "TRQ") for letter in "SLURBT"]
    written(tmp_path / "log.csv", made, names, YASKAWA)
    with pytest.raises(InputError, match=r"--unit actual_q has 2 values.* 6 columns"):
        imported(tmp_path / "log.csv", actual_q="1e-5,2e-5")
