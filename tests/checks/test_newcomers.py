"""What a newcomer does wrong with a poor log, of q, q̇ and currents alone: `ur5 check` says it, or
says that it would not notice."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command import Command
from tests.synthetic import PERIOD, poor_log
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.tables import named

ARMS = ("ur3e", "ur5", "ur16e")
OTHER = {"ur3e": "ur5e", "ur5": "ur10e", "ur16e": "ur3"}
ENTRY = (
    "study: mine\ntitle: Mine\nrecordings:\n"
    "- {{name: run, robot: {robot}, format: table-csv, folder: ., file: {file}, role: {role}, "
    "columns: [{columns}]}}\n"
)
COLUMNS = "time, actual_q, actual_qd, actual_current"
Change = Callable[[pd.DataFrame], pd.DataFrame]


def six(name: str) -> list[str]:
    return [f"{name}_{joint}" for joint in range(6)]


def scaled(factor: float, *channels: str) -> Change:
    return lambda log: log.assign(
        **{name: factor * log[name] for one in channels for name in six(one)}
    )


def exchanged(one: int, other: int, *channels: str) -> Change:
    """Two joints, 1 to 6, with each other's columns."""

    def change(log: pd.DataFrame) -> pd.DataFrame:
        for channel in channels or ("actual_q", "actual_qd", "actual_current"):
            both = [f"{channel}_{one - 1}", f"{channel}_{other - 1}"]
            log[both] = log[both[::-1]].to_numpy()
        return log

    return change


def late(seconds: float) -> Change:
    rows = round(seconds / PERIOD)

    def change(log: pd.DataFrame) -> pd.DataFrame:
        log[six("actual_current")] = log[six("actual_current")].shift(rows)
        return log.iloc[rows:]

    return change


def pushed(start: float, joint: int, current: float) -> Change:
    """For 2 s, by what costs a motor so much current [A]."""

    def change(log: pd.DataFrame) -> pd.DataFrame:
        during = log["time"].between(start, start + 2)
        log.loc[during, f"actual_current_{joint - 1}"] += current
        return log

    return change


def without(*columns: str) -> Change:
    return lambda log: log.drop(columns=[*columns])


MISTAKES: dict[str, tuple[Change, int, str]] = {  # the status, and what is said
    "degrees": (scaled(180 / np.pi, "actual_q", "actual_qd"), 1, "`units: {actual_q: deg"),
    "degrees beside rad/s": (scaled(180 / np.pi, "actual_q"), 1, "is it in degrees?"),
    "mA": (scaled(1000, "actual_current"), 1, "is it in mA?"),
    "sign": (scaled(-1, "actual_current"), 1, "`actual_current: opposite`"),
    "exchanged joints": (exchanged(2, 3), 1, "joints 2 and 3 are exchanged"),
    "exchanged wrist": (exchanged(3, 4), 1, "joints 3 and 4 are exchanged"),
    "exchanged currents": (
        exchanged(1, 2, "actual_current"),
        1,
        "the currents of joints 1 and 2 are exchanged",
    ),
    "0.3 s": (late(0.3), 1, "s later than the motion"),
    "0.05 s": (late(0.05), 1, "s later than the motion"),
    "missing column": (without("actual_current_3"), 1, "expected 19 numbers (it has 18 cells)"),
    "push in motion": (pushed(8, 2, 4.0), 0, "torque of joint 2 differs by"),
    "push at rest": (pushed(27, 3, 4.0), 0, "torque of joint 3 differs by"),
}


def check(
    log: pd.DataFrame, folder: Path, run: Command, robot: str, **entry: str
) -> tuple[int, str]:
    """The status of `ur5 check` on a log, and what it prints."""
    log.to_csv(folder / "log.csv", index=False, float_format="%.6g")
    known = {"robot": robot, "file": "log.csv", "role": "fit", "columns": COLUMNS}
    (folder / "study.yaml").write_text(ENTRY.format(**known | entry))
    answer = run("check", folder / "study.yaml", *(() if entry else ("run",)))
    return answer.status, " ".join(answer.line.replace("│", " ").split())


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "500")
    return tmp_path


@pytest.fixture(
    scope="module", params=[pytest.param("ur3e", marks=pytest.mark.thorough), "ur5", "ur16e"]
)
def arm(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def log(arm: str) -> pd.DataFrame:
    return poor_log(load_robot(robot_path(arm)), 32.0, seed=5)


def test_a_right_log_has_neither_stop_signs_nor_warnings(
    log: pd.DataFrame, arm: str, folder: Path, run_ur5: Command
) -> None:
    status, printed = check(log, folder, run_ur5, arm)
    assert status == 0
    assert "(warning)" not in printed
    assert "(stop)" not in printed
    assert "(note)" in printed


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_said(
    log: pd.DataFrame, arm: str, folder: Path, run_ur5: Command, mistake: str
) -> None:
    change, status, said = MISTAKES[mistake]
    found, printed = check(change(log.copy()), folder, run_ur5, arm)
    assert said in printed
    assert found == status


def test_a_wrong_arm_is_said(log: pd.DataFrame, arm: str, folder: Path, run_ur5: Command) -> None:
    status, printed = check(log, folder, run_ur5, OTHER[arm])
    assert status == 1
    assert f"`robot: {arm}`" in printed


def test_a_typo_in_a_key_and_a_wrong_path_are_said(
    log: pd.DataFrame, arm: str, folder: Path, run_ur5: Command
) -> None:
    status, printed = check(log, folder, run_ur5, arm, role="fit, payloads: {mass: 2}")
    assert status == 1
    assert "`recordings[0].payloads` (did you mean `payload`?)" in printed
    status, printed = check(log, folder, run_ur5, arm, file="logs.csv")
    assert status == 1
    assert "logs.csv" in printed


def test_a_log_without_currents_is_warned_of(
    log: pd.DataFrame, arm: str, folder: Path, run_ur5: Command
) -> None:
    poor = log.drop(columns=six("actual_current"))
    _, printed = check(poor, folder, run_ur5, arm, columns="time, actual_q, actual_qd")
    assert "no currents (warning)" in printed


@pytest.mark.parametrize("speed", [0.0, 0.8])
def test_what_a_log_does_not_show_could_not_be_checked(
    arm: str, folder: Path, run_ur5: Command, speed: float
) -> None:
    """Base and last joint bear nothing, but may differ in inertia; at rest, nothing shows order,
    sign and clock.
    """
    log = exchanged(1, 6)(poor_log(load_robot(robot_path(arm)), 32.0, 5, speed))
    status, printed = check(log, folder, run_ur5, arm)
    told = speed > 0 and "joints 1 and 6 are exchanged" in printed
    assert status == int(told)
    assert told or "1-6" in printed
    rests = "order, sign and delay of actual_current could not be checked" in printed
    assert rests == (speed == 0.0)


def test_a_short_log_could_not_be_checked(
    log: pd.DataFrame, arm: str, folder: Path, run_ur5: Command
) -> None:
    status, printed = check(log.iloc[:250], folder, run_ur5, arm)
    assert status == 0
    assert "arm, columns, units and clocks could not be checked: 2.0 s are too short" in printed


def with_target(log: pd.DataFrame) -> pd.DataFrame:
    smooth = log[six("actual_current")].rolling(25, center=True, min_periods=1).mean()
    return log.assign(**named(smooth.to_numpy(), "target_current"))


def test_a_target_that_gravity_contradicts_stops_nothing(
    log: pd.DataFrame, arm: str, folder: Path, run_ur5: Command
) -> None:
    """The controller was given a payload that is not there: here, by a joint's factor."""
    known = with_target(log)
    odd = known.assign(target_current_1=known["target_current_1"] / 0.7)
    status, printed = check(odd, folder, run_ur5, arm, columns=f"{COLUMNS}, target_current")
    assert status == 0
    assert "target_current of joint 2 is 1.4" in printed


def test_a_current_that_gravity_contradicts_is_not_its_targets_fault(
    folder: Path, run_ur5: Command
) -> None:
    log = with_target(poor_log(load_robot(robot_path("ur16e")), 32.0, seed=5))
    scaled = log.assign(actual_current_1=0.6 * log["actual_current_1"])
    status, printed = check(scaled, folder, run_ur5, "ur16e", columns=f"{COLUMNS}, target_current")
    assert status == 1
    assert "the current of joint 2 is 0.60 times its target" in printed
