"""Evidence for what efforts are: rows that add up, and units that nobody can name."""

import re
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
from ur5lib.report.stated import remedy
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.timeseries.arrays import Array

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


def test_what_is_to_be_checked_names_the_second_candidate() -> None:
    random = np.random.default_rng(11)
    for _ in range(100):
        odds = [dict(zip(CANDIDATES, 6 * random.normal(size=6), strict=True)) for _ in SOURCES]
        rows = [Row(*pair) for pair in zip(SOURCES, odds, strict=True)]
        verdict = decide(rows, [*CANDIDATES], surest="check")
        assert verdict.confidence == "check"
        assert verdict.reason(CANDIDATES).endswith(f"before {CANDIDATES[verdict.rival]}")


def test_what_contradicts_is_said_first() -> None:
    verdict = decide([ROWS[0], WITHOUT_GRAVITY], [*CANDIDATES])
    assert verdict.confidence == "check"
    assert verdict.reason(CANDIDATES).startswith(
        "but its name is read as actual_current; less gravity"
    )


FACTORS = 40 * np.linspace(1, 3, 6)


def log(folder: Path, made: Made, factors: Array = FACTORS, name: str = "effort") -> Path:
    """A log of an arm's currents, times a factor a joint."""
    time, channels = made
    parts = {"q": channels["actual_q"], "qd": channels["actual_qd"]}
    parts[name] = factors * channels["actual_current"]
    columns = {f"{name}_{k}": rows[:, k] for name, rows in parts.items() for k in range(6)}
    pd.DataFrame({"time": time} | columns).to_csv(folder / "run.csv", index=False)
    return folder / "run.csv"


@pytest.mark.parametrize("name", ["effort", "current", "torque"])
@pytest.mark.parametrize("factor", [0.37, 1.0])
def test_only_a_named_arm_proves_a_unit(
    name: str, factor: float, tmp_path: Path, made: Made
) -> None:
    """By gravity alone, currents times a factor are those of another arm."""
    file = log(tmp_path, made, factor * np.ones(6), name)
    (guessed,) = imported_files([file], UserStatement())
    sure = {row.subject: row.confidence for row in reversed(guessed.account)}
    assert (sure["robot"], sure[f"{name}_0 … {name}_5"]) == ("check", "check")
    (told,) = imported_files([file], UserStatement("ur5"))
    sure = {row.subject: row.confidence for row in reversed(told.account)}
    assert (sure[f"{name}_0 … {name}_5"] == "proven") == (factor == 1 and name != "torque")


def test_a_joint_that_bears_half_its_gravity_is_not_less_gravity(
    tmp_path: Path, made: Made, ur5: Robot
) -> None:
    """As of an arm with a coupled axis: one joint shows gravity, by no constant of the arm."""
    time, channels = made
    q = channels["actual_q"]
    torque = gravity_torque(ur5, ur5.chosen_model, q) * [0, 0.45, 0, 0, 0, 0]
    torque += 0.2 * np.random.default_rng(3).normal(size=q.shape)
    names = [f"{name}{k}" for name in ("q", "torque") for k in range(6)]
    table = pd.DataFrame(np.column_stack([time, q, torque]), columns=["time", *names])
    table.to_csv(tmp_path / "run.csv", index=False)
    (one,) = imported_files([tmp_path / "run.csv"], UserStatement("ur5"))
    (row, *_) = (row for row in one.account if row.subject == "torque0 … torque5")
    assert (row.taken_for, row.confidence) == ("actual_current_as_torque", "check")


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
    assert re.search(r"--unit actual_current=A, mA .* `units`", remedy(sign.detail))  # to do next
    assert np.abs(intake.robot["actual_current_1"]).max() > 60
