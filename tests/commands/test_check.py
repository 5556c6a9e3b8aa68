"""`ur5 check`: a study looked through in seconds, without the workflow."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.command import Command, words
from tests.conftest import PROJECT, said
from tests.made_tables import record, table
from tests.synthetic import write_recording
from ur5lib.checks import files
from ur5lib.checks.channels import unfiltered
from ur5lib.checks.files import name_copies
from ur5lib.commands.check import (
    FOLDED,
    MAX_NAMED,
    Form,
    concerned,
    print_tables,
    unusable,
)
from ur5lib.commands.console import announced, text_console
from ur5lib.errors import InputError, Remark, printable
from ur5lib.records.account import NOTHING, UNKNOWN_NAME, AccountRow
from ur5lib.records.clocks import SettledClock
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.force_errors import Compared
from ur5lib.records.judgement import QualityRow
from ur5lib.records.quality import UNCHECKED, Finding, Log, Quality
from ur5lib.report.page.findings import by_finding, group_findings
from ur5lib.robots.description import Robot, robot_yaml
from ur5lib.robots.statics import gravity_torque
from ur5lib.study.model import Settings
from ur5lib.tables import named


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")
    write_recording(tmp_path / "raw" / "good", seconds=2, seed=0, force_sensor=True)
    write_recording(tmp_path / "raw" / "bad", seconds=2, seed=1)
    path = tmp_path / "study.yaml"
    path.write_text(
        "study: mine\ntitle: Mine\nrecordings:\n"
        "- {name: good, robot: ur5, format: thesis-csv, folder: raw/good, role: fit}\n"
        "- {name: bad, robot: ur5, format: thesis-csv, folder: raw/bad, role: fit}\n"
    )
    return path


def test_findings_and_clocks_are_printed(study: Path, run_ur5: Command) -> None:
    result = run_ur5("check", study)
    assert result.status == 0
    assert "no sensor (note)" in result.out
    assert "0.0050 ± 0.0058" in result.out
    assert not (study.parent / "results").exists()


@pytest.mark.parametrize(
    ("described", "accept", "refused"),
    [
        ({}, "", True),
        ({"effort": "joint_torque"}, "", False),
        ({"weight": 20.0}, "", False),
        ({}, "accept: {side: the driver's manual says so}\n", False),
    ],
)
def test_a_fit_that_the_description_forbids_is_an_error(
    study: Path, ur5: Robot, run_ur5: Command, described: Any, accept: str, refused: bool
) -> None:
    """A run would refuse it after minutes."""
    unknown = {"name": "mine", "effort": "torque", "links": "unknown"}
    (study.parent / "robots").mkdir()
    (study.parent / "robots" / "mine.yaml").write_text(
        robot_yaml(ur5.model_copy(update=unknown | described))
    )
    study.write_text(accept + study.read_text().replace("robot: ur5", "robot: mine"))
    told = run_ur5("check", str(study))
    assert ("write `effort: joint_torque`" in " ".join(told.out.split())) == refused
    assert "all recordings" in told.out or "both recordings" in told.out
    assert told.status == 1 or not refused


@pytest.mark.parametrize("terminal", [False, True])
def test_each_file_is_announced_before_it_is_read(
    terminal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    for name in announced(["one.csv", "two\x1b.csv"]):
        shown = capsys.readouterr()
        assert terminal or f"reading {printable(name)} (" in shown.err
        assert shown.out == ""


def test_a_command_says_at_once_how_many_files_it_reads(tmp_path: Path) -> None:
    """In a pipe, before packages are loaded that take seconds."""
    command = "import sys, ur5lib.cli; sys.modules['pandas'] = None; ur5lib.cli.main()"
    files = ["a.csv", "b.csv"]
    done = subprocess.run(
        [sys.executable, "-c", command, "import", *files],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.stderr.startswith("files to read: 2\n")


def test_a_recording_is_shown_in_detail(study: Path, run_ur5: Command) -> None:
    (study.parent / "raw/bad/csv_files/log_q_actual.csv").write_text("nothing\n")
    assert run_ur5("check", study, "bad").status == 1
    result = run_ur5("check", study, "good")
    assert (result.status, "bad" in result.out) == (0, False)
    assert words("force_sensor no sensor") & words(result.out)
    result = run_ur5("check", study, "goood")
    assert result.status == 1
    assert words("'goood' good") <= words(result.err)


@pytest.mark.parametrize(
    ("some", "named"),
    [(41, "all 41 recordings"), (40, "40 of 41 recordings: all but 40"), (1, "0"),
     (3, "3 of 41 recordings: 0, 1, 2"), (30, "30 of 41 recordings: 0, 1, 2 and 27 more")],
)  # fmt: skip
def test_recordings_are_counted_and_few_are_named(some: int, named: str) -> None:
    names = [str(number) for number in range(41)]
    assert concerned(names[:some], names) == named


def noted(count: int, code: Found = Found.IRREGULAR_STEPS, **changes: str) -> pd.DataFrame:
    """One finding of some recordings."""
    finding = {"device": "robot", "code": code, "finding": code.words, "place": ""}
    finding |= {"severity": "note"} | changes
    rows = [{"recording": str(k), "count": k, "detail": "10 ms"} | finding for k in range(count)]
    return pd.DataFrame(rows)


def test_a_finding_of_many_recordings_is_one_row() -> None:
    quality = pd.concat([noted(41), noted(2, Found.LOST_FRAMES, severity="warning")])
    quality.loc[(quality["severity"] == "warning") & (quality["count"] == 1), "detail"] = "worst"
    lost, steps = by_finding(quality).itertuples()
    assert (lost.code, lost.recordings, lost.alike) == (Found.LOST_FRAMES, ["1", "0"], False)
    assert lost.detail == "worst"
    assert (len(steps.recordings), steps.detail, steps.alike) == (41, "10 ms", True)


def test_each_error_keeps_its_reason() -> None:
    """Whatever its numbers and files: of many recordings, every kind of reason is named."""
    details = ["a.csv: 12.5 rad", "raw/b.csv: 1e3 rad", "no time", "no file", "joint 2", "joint 3"]
    quality = noted(6, severity="error").assign(detail=details)
    named = by_finding(quality)
    assert [*map(len, named["recordings"])] == [1, 1, 1, 1, 2]
    assert {*named["detail"]} == {*details} - {"a.csv: 12.5 rad"}  # the larger count of two stands


def test_fourteen_recordings_with_one_note_fill_one_screen() -> None:
    console = text_console(file=(screen := StringIO()), width=80)
    note = Finding("robot", Found.IRREGULAR_STEPS, "note", 1, "time steps vary by 2 ms")
    print_tables(console, {f"run_{k}": Quality(findings=[note]) for k in range(14)}, {})
    assert len(screen.getvalue().splitlines()) < 24


def printed(form: Form) -> str:
    """What is printed of four recordings, in all of which much could not be checked."""
    console = text_console(file=(screen := StringIO()), width=200)
    told = {
        Found.CLOCK_NOT_CHECKED: "delays of up to 0.50 s could not be noticed",
        Found.ARM_NOT_CHECKED: "`robot: ur5` could not be told from ur5e",
        Found.IRREGULAR_STEPS: "time steps vary by 2 ms",
    }
    notes = [Finding("robot", name, "note", 1, detail) for name, detail in told.items()]
    print_tables(console, {f"run_{k}": Quality(findings=notes) for k in range(4)}, {}, form=form)
    return screen.getvalue()


def test_what_could_not_be_checked_is_one_line_with_the_riskiest_named() -> None:
    folded = printed(FOLDED)
    [line] = [line for line in folded.splitlines() if "could not be checked" in line]
    assert "arm, clock" in line
    assert "in all 4 recordings" in folded
    assert "could not be told from ur5e" in folded
    assert "delays of up to" not in folded
    assert "--all" in folded
    whole = printed(Form(everything=True))
    assert "delays of up to 0.50 s" in whole
    assert "arm not checked (note) in all 4 recordings" in whole


def test_columns_that_are_not_used_are_one_line_with_the_riskiest_named() -> None:
    """That is the one whose name may mean a channel."""
    zero = [AccountRow(f"out_{k}", NOTHING, "numbers", "left out", "zero") for k in range(40)]
    unknown = AccountRow("motor_amps, i_shunt", NOTHING, "name", "left out", UNKNOWN_NAME)
    qualities = {name: Quality(account=[*zero, unknown]) for name in "ab"}

    def shown(named: list[str], form: Form) -> str:
        console = text_console(file=(screen := StringIO()), width=200)
        print_tables(console, qualities, {}, named, form=form)
        return screen.getvalue()

    folded = shown([], FOLDED)
    assert len(folded.splitlines()) < 5
    assert f"motor_amps; i_shunt: {UNKNOWN_NAME}" in folded
    for whole in (shown([], Form(everything=True)), shown(["a"], FOLDED)):
        assert {"motor_amps", *(f"out_{k}" for k in range(40))} <= words(whole)


def test_the_riskiest_is_known_of_all_that_may_not_be_checked() -> None:
    checks = "".join(path.read_text() for path in (PROJECT / "ur5lib" / "checks").glob("*.py"))
    open_ones = re.findall(r"Found\.(\w+_NOT_CHECKED|NOTHING_CHECKED)", checks)
    assert {*UNCHECKED} == {Found[name] for name in open_ones}


def test_findings_are_json_for_a_program(study: Path, run_ur5: Command) -> None:
    answer = run_ur5("check", study, "--json")
    rows = json.loads(answer.out)
    assert {row["recording"] for row in rows} == {"good", "bad"}
    assert {"severity", "finding", "code", "detail"} <= {*rows[0]}


def test_many_damaged_files_fill_one_screen() -> None:
    """Each for a reason of its own: all are counted, few are stated."""
    console, count, bad = text_console(file=(screen := StringIO()), width=120), 2443, 24
    qualities = {
        f"run_{k}": unusable(InputError(f"run_{k}.csv is empty")) if k < bad else Quality()
        for k in range(count)
    }
    assert print_tables(console, qualities, {}) == bad
    lines = screen.getvalue().splitlines()
    assert len(lines) < 12
    assert f"{bad} of {count} recordings: run_0, run_1, run_2 and {bad - MAX_NAMED} more" in (
        screen.getvalue()
    )


SIMULATED = (
    "- {name: made, robot: ur5, format: thesis-csv, role: fit, "
    "simulate: {trajectory: {kind: fourier}}}\n"
)


@pytest.mark.parametrize(
    ("file", "change", "status", "printed"),
    [
        ("raw/bad/csv_files/log_q_actual.csv", lambda _: "nothing\n", 1, "robot unusable error"),
        (
            "raw/good/csv_files/log_force_sensor.csv",
            lambda text: text.replace("\n", ", 0\n"),
            1,
            "force unusable sensor error",
        ),
        ("study.yaml", lambda text: text + SIMULATED, 0, "simulated yet made `ur5"),
        ("study.yaml", lambda text: text.replace("role: fit", "role: contact"), 0, "ur5 `fit`"),
    ],
)
def test_a_fault_is_named_beside_the_other_recordings(
    study: Path,
    run_ur5: Command,
    file: str,
    change: Callable[[str], str],
    status: int,
    printed: str,
) -> None:
    """What is not simulated yet, or cannot be fitted, is no fault."""
    path = study.parent / file
    path.write_text(change(path.read_text()))
    result = run_ur5("check", study)
    assert result.status == status
    assert words(f"good {printed}") <= words(result.out)


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ("study: mine\ntitle: [", "line 2 YAML"),
        ("a letter", "`study` `title` `recordings`"),
        ("study: mine", "`title` missing"),
        ("study: \udcff", "YAML 'utf-8'"),
        (None, "No such file"),
    ],
)
def test_a_wrong_study_is_named(
    study: Path, run_ur5: Command, content: str | None, named: str
) -> None:
    if content is None:
        study.unlink()
    else:
        study.write_text(content, errors="surrogateescape")
    result = run_ur5("check", study)
    assert result.status == 1
    assert words(f"{study} {named}") <= words(result.err)


REST = asdict(Remark(CauseCode.OTHER_REASON, "the arm rests"))


def torn_line(file: Path, line: str) -> Finding:
    log = Log(file, "robot", [])
    log.add(Found.TORN_LAST_LINE, "note", 1, "last line is cut off, skipped", line)
    return log.findings[0]


def test_copies_and_poor_clocks_are_findings() -> None:
    torn = [asdict(torn_line(Path(name), "3")) for name in "ab"]
    fresh = {"devices": ["robot", "imu"], "files": {"imu": "x"}, "findings": torn}
    stale = {"devices": ["robot"], "files": {"imu": "x"}, "findings": []}
    fair = {"warning": None, "offset_std": 0.006, "end_std": 0.1, "drift": None}
    poor = fair | {"warning": REST, "offset_std": 0.1, "end_std": 0.2}
    clocks = {"one": {"imu": poor}, "two": {"force": fair, "imu": fair | {"drift": -0.003}}}
    forces = {"one": {"mounting_doubt": None}, "two": {"mounting_doubt": REST}}
    forces["two"]["offset_doubt"] = REST
    qualities = {"one": fresh, "two": stale}
    found = {
        name: files.findings(
            record(Quality, own),
            None,
            record(dict[str, SettledClock], clocks[name]),
        )
        + record(Compared, forces[name]).findings()
        for name, own in qualities.items()
    }
    rows = table(QualityRow, {name: map(files.quality_row, own) for name, own in found.items()})
    grouped = group_findings(name_copies(rows))
    assert {*grouped.loc[grouped["severity"] == "warning", "count"]} == {1}
    reported = grouped.set_index(["recording", "code"])["detail"].to_dict()
    assert reported["one", Found.TORN_LAST_LINE].startswith("a, line 3; b, line 3: ")
    assert words("two used here") <= words(reported["one", Found.SAME_FILE])
    assert words("one not used here") <= words(reported["two", Found.SAME_FILE])
    assert reported["two", "mounting"] == "the arm rests"
    assert reported["two", "offset"].startswith("the arm rests: ")
    assert ("one", "mounting") not in reported
    assert words("the arm rests 0.1 0.2") <= words(reported["one", Found.CLOCK_BY_STAMPS_ALONE])
    assert {"0.006", "0.1"} <= words(reported["two", Found.UNKNOWN_DRIFT])
    assert list(grouped["code"]).count(Found.UNKNOWN_DRIFT) == 1


def test_findings_of_two_meanings_keep_both() -> None:
    finding = {"recording": "one", "device": "robot", "severity": "warning"}
    finding |= {"code": Found.SILENT_CHANNEL, "finding": "apart"}
    details = ["a: b lie apart", "actual_current and target_current lie apart"]
    rows = [finding | {"count": 1, "detail": detail, "place": ""} for detail in details]
    (reported,) = group_findings(pd.DataFrame(rows))["detail"]
    assert reported == "a: b lie apart; actual_current and target_current lie apart"


def test_a_long_sentence_keeps_its_start() -> None:
    """Only files are left out of a list, no part of what a finding says."""
    ratios = ", ".join(f"joint {joint}: 0.0172" for joint in range(1, 7))
    wrong = f"actual_qd is not the derivative of actual_q ({ratios}); check columns and units"
    names = ", ".join(f"actual_robot_voltage_of_{k}" for k in range(5))
    sentences = [
        Finding("robot", Found.INCONSISTENT_CHANNELS, "warning", 6, wrong),
        Finding("robot", Found.UNUSED_CHANNELS, "note", 5, f"{names}: left out"),
    ]
    places = [torn_line(Path(f"log_{k}.csv"), "2857") for k in range(9)]
    console = text_console(file=(screen := StringIO()), width=400)
    print_tables(console, {"one": Quality(findings=[*sentences, *places]), "two": Quality()}, {})
    printed = screen.getvalue()
    assert all(said(finding) in printed for finding in sentences)
    cut = "log_0.csv, line 2857; log_1.csv, line 2857; log_2.csv, line 2857; 6 others: last line is"
    assert cut in printed


@pytest.mark.parametrize(("frames", "told"), [(2, True), (10, True), (62, True), (63, False)])
def test_a_recording_too_short_for_any_force_is_reported(
    study: Path, run_ur5: Command, frames: int, told: bool
) -> None:
    """Half a second is lost to the low-pass."""
    for path in (study.parent / "raw/bad/csv_files").glob("log_*.csv"):
        path.write_text("".join(path.read_text().splitlines(keepends=True)[:frames]))
    result = run_ur5("check", study)
    assert ("robot: too short (warning) in bad" in result.out) == told
    assert (f"{frames} samples, {0.008 * frames:.2g} s" in result.line) == told
    assert result.err.splitlines() == ["reading good (1 of 2)", "reading bad (2 of 2)"]


def test_a_recording_at_1_hz_is_checked(study: Path, run_ur5: Command, ur5: Robot) -> None:
    """No delay of its currents is as long as its steps."""
    time = np.arange(90.0)
    phase = 0.3 * time[:, None] + np.arange(6)
    q, qd = np.sin(phase), 0.3 * np.cos(phase)
    current = gravity_torque(ur5, "C", q) / ur5.maker_torque_constants() + np.tanh(20 * qd)
    current += 0.02 * np.random.default_rng(3).normal(size=q.shape)
    channels = named(q, "actual_q") | named(qd, "actual_qd") | named(current, "actual_current")
    slow = pd.DataFrame({"timestamp": time, **channels})
    slow.to_csv(study.parent / "raw/slow.csv", index=False)
    entry = "- {name: slow, robot: ur5, format: rtde-csv, folder: raw, file: slow.csv, role: fit}\n"
    study.write_text(study.read_text() + entry)
    assert words("`cutoff_hz` 0.5") <= words(run_ur5("check", study, "slow").line)


def test_a_recording_that_a_filter_leaves_as_it_is_is_reported() -> None:
    cutoffs = Settings.model_validate(
        {"lowpass": {"motion": {"cutoff_hz": 80}}}
    ).lowpass.cutoffs_hz()
    assert not any(unfiltered(cutoffs, 0.002))
    (note,) = unfiltered(cutoffs, 0.008)
    assert {"`cutoff_hz`", "motion", "62.5"} <= words(said(note))
