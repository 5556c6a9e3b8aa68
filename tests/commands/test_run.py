"""`ur5 run`, `report` and `status`: what they build, what they print, and how a study is named."""

import json
import signal
import sys
import webbrowser
from pathlib import Path

import pytest

from tests.command import Command
from ur5lib.commands import run
from ur5lib.errors import InputError
from ur5lib.study.address import results_folder, study_file
from ur5lib.study.turn import running, take_turn

LINES = [
    "Building DAG of jobs...",
    "Job stats:",
    "read_recording    1",
    "total             3",
    "[Thu Nov 26 18:32:25 2026]",
    "Finished jobid: 1 (Rule: read_recording)",
    "1 of 3 steps (33%) done",
    "pushed cannot be read: it is empty",
]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    recording = "{name: free, robot: ur5e, format: rtde-csv, folder: ., file: free.csv, role: fit}"
    study = f"study: mine\ntitle: My arm\nrecordings: [{recording}]\n"
    (tmp_path / "arm.yaml").write_text(study)
    (tmp_path / "other.yaml").write_text("some: other program's\n")
    (tmp_path / "results" / "mine" / "tables").mkdir(parents=True)
    return tmp_path


def snakemake_prints(monkeypatch: pytest.MonkeyPatch, lines: list[str], status: int) -> None:
    """Let a program stand for Snakemake that prints lines and ends with a status."""
    program = f"print({chr(10).join(lines)!r}); raise SystemExit({status})"
    monkeypatch.setattr(run, "_command", lambda *_: [sys.executable, "-c", program])


@pytest.mark.parametrize(
    "address", ["mine", "arm.yaml", "results/mine", "results/mine/report.html"]
)
def test_a_study_has_one_address_by_name_file_and_results(here: Path, address: str) -> None:
    assert study_file(address) == Path("arm.yaml")
    assert results_folder(address) == Path("results/mine")


def test_a_name_that_is_nearly_a_study_is_answered_with_it(here: Path, run_ur5: Command) -> None:
    assert "did you mean `mine`?" in run_ur5("status", "mien").line


def test_two_studies_of_a_name_are_told_apart_by_their_files(here: Path) -> None:
    (here / "again.yaml").write_text((here / "arm.yaml").read_text())
    with pytest.raises(InputError, match=r"again\.yaml and arm\.yaml"):
        study_file("mine")


def test_a_run_shows_progress_and_what_is_not_usual(
    here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    snakemake_prints(monkeypatch, LINES, 0)
    monkeypatch.setattr(run, "SECONDS_BETWEEN_LINES", 0.0)
    Path("results/mine/report.html").touch()
    answer = run_ur5("run", "mine")
    assert answer.err.splitlines() == ["1 of 3 steps are done", LINES[-1]]
    assert answer.out == "report: results/mine/report.html\n"


def test_a_run_that_fails_says_why(
    here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    snakemake_prints(monkeypatch, LINES, 1)
    answer = run_ur5("run", "mine")
    assert answer.status == 1
    assert LINES[-1] in answer.err
    assert LINES[0] not in answer.err


def test_options_of_snakemake_follow_after_two_dashes(
    here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    given = []

    def command(study: Path, options: list[str]) -> list[str]:
        given.append((study, options))
        return ["true"]

    monkeypatch.setattr(run, "_command", command)
    run_ur5("run", "mine", "--", "--cores", "1")
    assert given == [(Path("arm.yaml"), ["--cores", "1"])]


@pytest.mark.parametrize("options", ["-n", "--dry-run", "--quiet host -n", "-Fn"])
def test_a_dry_run_prints_what_a_run_would_do_and_names_no_report(
    options: str, here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    snakemake_prints(monkeypatch, LINES, 0)
    Path("results/mine/report.html").touch()
    answer = run_ur5("run", "mine", "--", *options.split())
    assert answer.out == ""
    assert "read_recording    1" in answer.err.splitlines()


@pytest.mark.usefixtures("on_a_terminal")
def test_a_run_that_is_stopped_waits_for_snakemake_and_says_what_is_kept(
    here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    """As of Ctrl-C, which reaches both."""
    program = "import os, pathlib, signal, time; os.kill(os.getppid(), signal.SIGINT); "
    program += "time.sleep(1); pathlib.Path('removed').touch()"
    monkeypatch.setattr(run, "_command", lambda *_: [sys.executable, "-c", program])
    answer = run_ur5("run", "mine")
    assert answer.status == 130
    assert Path("removed").exists()
    assert "the steps that are done are kept" in answer.err


KILLED = """
import os, pathlib, signal, sys, time
signal.signal(signal.SIGTERM, lambda *_: sys.exit(pathlib.Path("ended").touch()))
os.kill(os.getppid(), signal.{})
time.sleep({})
"""


@pytest.mark.usefixtures("on_a_terminal")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_run_that_is_told_to_end_ends_snakemake_and_says_what_is_kept(
    name: str, here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    """Such a signal reaches the run alone."""
    program = KILLED.format(name, 60)
    monkeypatch.setattr(run, "_command", lambda *_: [sys.executable, "-c", program])
    answer = run_ur5("run", "mine")
    assert answer.status == 130
    assert Path("ended").exists()
    assert "the steps that are done are kept" in answer.err


def test_a_run_under_nohup_outlives_its_terminal(
    here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    program = KILLED.format("SIGHUP", 0)
    monkeypatch.setattr(run, "_command", lambda *_: [sys.executable, "-c", program])
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        answer = run_ur5("run", "mine")
    finally:
        signal.signal(signal.SIGHUP, before)
    assert answer.status == 0


def test_recordings_do_not_overwrite_a_study(here: Path, run_ur5: Command) -> None:
    Path("raw/arm").mkdir(parents=True)
    Path("raw/arm/free.csv").write_text("time,actual_q_0\n")
    answer = run_ur5("run", "raw/arm/free.csv", "--robot", "ur5e")
    assert "arm.yaml exists" in answer.line


def test_a_status_names_the_run_that_builds_the_study(here: Path, run_ur5: Command) -> None:
    assert running(Path("results/mine")) == ""
    with take_turn(Path("results/mine")):
        answer = run_ur5("status", "mine")
    assert answer.out.startswith("being made by process ")


def test_a_status_counts_the_steps_of_a_run(
    here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    snakemake_prints(monkeypatch, LINES, 0)
    answer = run_ur5("status", "results/mine")
    assert answer.out.splitlines() == [
        "no report yet",
        "3 steps to run; next: ur5 run arm.yaml",
    ]


def test_a_report_that_is_not_built_is_answered_with_the_command(
    here: Path, run_ur5: Command
) -> None:
    assert "ur5 run mine" in run_ur5("report", "mine").err


@pytest.mark.parametrize("found", [True, False])
def test_a_report_is_named_whether_or_not_there_is_a_browser(
    found: bool, here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    report = here / "results" / "mine" / "report.html"
    report.parent.mkdir(parents=True, exist_ok=True)
    report.touch()
    opened = []

    def opens(address: str) -> bool:
        opened.append(address)
        return found

    monkeypatch.setattr(webbrowser, "open", opens)
    told = run_ur5("report", "mine", "--open")
    assert opened == [report.as_uri()]
    assert told.out.endswith("report: results/mine/report.html\n")
    assert ("no browser" in told.out) != found


def test_a_quiet_run_says_only_what_went_wrong(
    here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    snakemake_prints(monkeypatch, LINES, 0)
    monkeypatch.setattr(run, "SECONDS_BETWEEN_LINES", 0.0)
    Path("results/mine/report.html").touch()
    answer = run_ur5("run", "mine", "--quiet")
    assert answer.err.splitlines() == [LINES[-1]]
    assert answer.out == "report: results/mine/report.html\n"


def test_a_state_is_json_for_a_program(
    here: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    snakemake_prints(monkeypatch, LINES, 0)
    state = json.loads(run_ur5("status", "mine", "--json").out)
    assert state["report"] is None
    assert (state["steps_to_run"], state["why"]) == (3, [])
    assert "3 steps to run; next: ur5 run arm.yaml" in run_ur5("status", "mine").out
