"""Evidence for what efforts are: rows that add up, and units that nobody can name."""

from itertools import permutations
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.stored_files import Made, made_up_channels
from ur5lib.checks.checked import Checked
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.effort_sources import CANDIDATES
from ur5lib.importing.evidence import SOURCES, Row, decide
from ur5lib.importing.written import imported_files
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.intake import read_and_repair
from ur5lib.records.codes import CauseCode
from ur5lib.robots.description import Robot

ROWS = (
    Row("name", {"A": 7.0, "mA": 5.0}, "named", {"name": "actual_current"}),
    Row("gravity", {"A": -90.0, "Nm": -95.0}),
    Row("bounds", {"mA": -12.0}),
    Row("kind", {"mA": -1.0, "unknown": -8.0}),
)
WITHOUT_GRAVITY = Row("gravity absent", {"neither": 8.0}, "gravity absent", {"share": 0.97})


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"))


def test_the_order_of_rows_decides_nothing() -> None:
    verdicts = {decide(rows, [*CANDIDATES])[:5] for rows in permutations(ROWS)}
    assert len(verdicts) == 1


@pytest.mark.parametrize("source", SOURCES)
def test_no_source_counts_for_more_than_its_cap(source: str) -> None:
    """However large its log-odds are."""
    odds = Row(source, {"A": 1e6}).capped([*CANDIDATES])
    assert odds == {"A": 0.0} | dict.fromkeys([*CANDIDATES][1:], -SOURCES[source].cap)


@pytest.mark.parametrize("source", SOURCES)
def test_habit_alone_tells_nothing(source: str) -> None:
    verdict = decide([Row(source, {"Nm": 90.0})], [*CANDIDATES])
    assert verdict.candidate == "Nm"
    assert verdict.told == SOURCES[source].telling
    assert (verdict.confidence == "check") == (not verdict.told)


def test_what_contradicts_is_said_first() -> None:
    verdict = decide([ROWS[0], WITHOUT_GRAVITY], [*CANDIDATES])
    assert verdict.confidence == "check"
    assert verdict.reason(CANDIDATES).startswith("but named actual_current; less gravity")


def log(folder: Path, made: Made) -> Path:
    """A log of efforts that no name tells: an arm's currents, times a factor a joint."""
    time, channels = made
    parts = {"q": channels["actual_q"], "qd": channels["actual_qd"]}
    parts["effort"] = 40 * np.linspace(1, 3, 6) * channels["actual_current"]
    columns = {f"{name}_{k}": rows[:, k] for name, rows in parts.items() for k in range(6)}
    pd.DataFrame({"time": time} | columns).to_csv(folder / "run.csv", index=False)
    return folder / "run.csv"


def test_an_effort_in_an_unknown_unit_is_kept_until_it_is_named(tmp_path: Path, made: Made) -> None:
    file = log(tmp_path, made)
    (one,) = imported_files([file], UserStatement("ur5"))
    assert one.entry["units"] == {"actual_current": "unknown"}
    assert "the unit of actual_current is unknown" in one.account[0].reason
    assert any(row.confidence == "evidence" for row in one.account)
    for channel, unit in (
        ("actual_current", "A"), ("actual_torque", "Nm"), ("actual_current_as_torque", "Nm"),
    ):  # fmt: skip
        (told,) = imported_files([file], UserStatement("ur5", units={channel: unit}))
        assert "units" not in told.entry
        assert ("actual_current_as_torque" in told.entry["columns"]) == (unit == "Nm")


def test_no_force_follows_from_an_unknown_unit(tmp_path: Path, made: Made, ur5: Robot) -> None:
    """The stop sign says what gravity shows, cannot be overruled, and no number is cut."""
    (one,) = imported_files([log(tmp_path, made)], UserStatement("ur5"))
    entry = {key: one.entry[key] for key in ("format", "folder", "file", "columns", "units")}
    intake = read_and_repair(ENTRY.validate_python(entry), ur5, 0.1)
    (sign,) = stop_signs(Checked(intake.robot, ur5, None, None, fitted=True, cutoff=2.0))
    assert (sign.cause, sign.kind, sign.severity) == (CauseCode.UNKNOWN_UNIT, "", "stop")
    assert "--unit actual_current=A" in sign.detail
    assert np.abs(intake.robot["actual_current_1"]).max() > 60
