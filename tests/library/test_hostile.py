"""Files, names and text from outside that would hang a program, fill it, or steer a terminal."""

import json
import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.corpus import rtde
from tests.time_limit import time_limit
from ur5lib import cli
from ur5lib.errors import InputError, printable
from ur5lib.recordings.quality import Finding
from ur5lib.report.reference import read_reference
from ur5lib.stand.trajectories import read_way_points
from ur5lib.study.reading import parse_study

MARKUP = ["[/x]", "[red]", ":x:", "[link=http://x]", "\\[/x]"]
CONTROLS = ["\x1b[31m", "\x1b]0;title\x07", "\x9b31m", "\x00", "\x08", "\u202e", "\udcff", "\x7f"]
SECONDS = 10
ENTRY = """\
- name: run
  robot: ur5
  role: fit
  format: rtde-csv
  folder: rtde
  file: robot.csv
"""
SENSOR = "  force_sensor: {file: force.csv, columns: [time, ft], start_file: start.txt}\n"


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A study of one recording, in the folder where the test runs."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    rtde(tmp_path, "rtde", b",")
    (tmp_path / "rtde/start.txt").write_text("0\n")
    path = tmp_path / "study.yaml"
    path.write_text(f"study: mine\ntitle: Mine\nrecordings:\n{ENTRY}{SENSOR}")
    return path


def run(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    """Run `ur5`, and return how it ended."""
    monkeypatch.setattr("sys.argv", ["ur5", *map(str, arguments)])
    with pytest.raises(SystemExit) as stop, time_limit(SECONDS):
        cli.main()
    return int(stop.value.code or 0)


# Text that a terminal or rich would obey


@pytest.mark.parametrize("text", CONTROLS)
def test_control_characters_become_visible(text: str) -> None:
    for shown in (
        printable(text),
        str(InputError(f"a {text} b")),
        Finding("robot", "torn", "note", 1, text).detail,
    ):
        assert shown.isprintable()
        assert "\\" in shown


def test_other_text_stays_as_it_is() -> None:
    text = "F̂ᵐᵃᵖ 5 N ± 1, 日本, “é”;\na second line\tafter a tab"
    assert printable(text) == text


@pytest.mark.parametrize("name", MARKUP)
def test_what_looks_like_markup_is_printed_as_it_is(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture, name: str
) -> None:
    """As a header, as a cell, and as a file's name."""
    robot = study.parent / "rtde/robot.csv"
    head, first, *rows = robot.read_text().splitlines()
    cells = [name, *first.split(",")[1:]]
    robot.write_text(
        "\n".join([f"{head},{name}", ",".join([*cells, "1"]), *(f"{row},1" for row in rows)])
    )
    force = robot.with_name(f"{name.replace('/', '')}.csv")
    robot.with_name("force.csv").rename(force)
    study.write_text(study.read_text().replace("force.csv", json.dumps(force.name)))
    force.write_text("0\n" + force.read_text())
    run(monkeypatch, "check", study)
    printed = " ".join(capsys.readouterr().out.split())
    assert f"{name}: " in printed
    assert repr(name) in printed
    assert f"{force.name}, line 1" in printed


@pytest.mark.parametrize("text", CONTROLS)
def test_control_characters_do_not_reach_the_terminal(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture, text: str
) -> None:
    robot = study.parent / "rtde/robot.csv"
    head, *rows = robot.read_bytes().splitlines(keepends=True)
    data = os.fsencode(text) if text == "\udcff" else text.encode()
    robot.write_bytes(head.rstrip() + b",a" + data + b"b\n" + b"".join(rows))
    run(monkeypatch, "check", study)
    study.write_text(study.read_text().replace("robot.csv", "robot.csv\\u001b[31m"))
    run(monkeypatch, "check", study)
    run(monkeypatch, "check", text.replace("\0", ""))
    run(monkeypatch, text)
    run(monkeypatch, "fetch", text)
    captured = capsys.readouterr()
    assert (captured.out + captured.err).replace("\n", "").isprintable()


# Files that are none


def pipe(path: Path) -> None:
    os.mkfifo(path)


def bound_socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(path))


def endless_device(path: Path) -> None:
    path.symlink_to("/dev/zero")


Make = Callable[[Path], None]
SPECIAL = {"a named pipe": pipe, "a socket": bound_socket, "a device": endless_device}
special = pytest.mark.parametrize(("kind", "make"), SPECIAL.items(), ids=SPECIAL)


@special
@pytest.mark.parametrize("name", ["rtde/robot.csv", "rtde/force.csv", "rtde/start.txt"])
def test_what_is_no_file_is_told_at_once(
    study: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture,
    name: str,
    kind: str,
    make: Make,
) -> None:
    monkeypatch.chdir(study.parent)
    Path(name).unlink()
    make(Path(name))
    assert run(monkeypatch, "check", study) == 1
    assert f"{name} is {kind}, " in " ".join(capsys.readouterr().out.split())


@special
def test_a_capture_or_channel_that_is_no_file_is_told(
    study: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture,
    kind: str,
    make: Make,
) -> None:
    make(Path("rtde/capture.csv"))
    text = study.read_text().replace("rtde-csv", "realtime-stream")
    study.write_text(text.replace("robot.csv", "capture.csv"))
    assert run(monkeypatch, "check", study) == 1
    assert f"rtde/capture.csv is {kind}, " in " ".join(capsys.readouterr().out.split())


@special
def test_a_study_that_is_no_file_is_told(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture,
    kind: str,
    make: Make,
) -> None:
    monkeypatch.chdir(tmp_path)
    make(Path("study.yaml"))
    assert run(monkeypatch, "check", "study.yaml") == 1
    assert f"study.yaml is {kind}, " in capsys.readouterr().err


@special
@pytest.mark.parametrize("read", [read_way_points, read_reference])
def test_way_points_and_references_that_are_no_files_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, make: Make, read: Callable
) -> None:
    monkeypatch.chdir(tmp_path)
    make(Path("file"))
    with time_limit(SECONDS), pytest.raises(InputError, match=f"^file is {kind}, "):
        read("file")


@special
def test_a_study_that_names_such_a_file_is_told(
    study: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture,
    kind: str,
    make: Make,
) -> None:
    make(study.with_name("way_points"))
    plan = "{trajectory: {kind: movej, way_points: way_points}}"
    entry = f"- {{name: made, robot: ur5, format: thesis-csv, role: fit, simulate: {plan}}}\n"
    study.write_text(f"reference: way_points\n{study.read_text()}{entry}")
    assert run(monkeypatch, "check", study) == 1
    told = capsys.readouterr().err
    assert told.count(f"is 'way_points'; give a file, not {kind}") == 2


# Few lines that mean many


LAUGHS = [f"l{k}: &l{k} [{', '.join([f'*l{k - 1}'] * 9)}]" for k in range(1, 10)]
MERGED = [f"l{k}: &l{k} {{<<: [{', '.join([f'*l{k - 1}'] * 9)}]}}" for k in range(1, 10)]
BOMBS = {
    "lists": "\n".join(["l0: &l0 [lol]", *LAUGHS, "recordings: *l9"]),
    "mappings": "\n".join(["l0: &l0 {a: b}", *MERGED, "recordings: [*l9]"]),
    "a circle": "recordings: &all [*all, *all]",
    "a deep nest": "recordings: " + "[" * 5000 + "]" * 5000,
    "a nest too deep for compiled code": "recordings: " + "[" * 100_000,
    "a nest of aliases": "\n".join(
        ["l0: &l0 [0]", *(f"l{k}: &l{k} [*l{k - 1}]" for k in range(1, 3000))]
    ),
}


@pytest.mark.parametrize("bomb", BOMBS.values(), ids=BOMBS)
def test_a_study_that_expands_beyond_measure_is_told_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture, bomb: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.yaml").write_text(f"study: mine\ntitle: Mine\n{bomb}\n")
    assert run(monkeypatch, "check", "study.yaml") == 1
    told = capsys.readouterr().err
    assert told.startswith("ur5: study.yaml ")
    assert told.count("\n") == 1
    with time_limit(SECONDS), pytest.raises(InputError, match=r"study\.yaml "):
        read_reference("study.yaml")


def test_aliases_in_good_measure_are_fine(tmp_path: Path) -> None:
    posture = [0.1] * 6
    plan = {"trajectory": {"kind": "movej", "way_points": [posture] * 300}}
    entry = {"robot": "ur5", "format": "thesis-csv", "role": "fit", "simulate": plan}
    entries = [{"name": f"run_{k}"} | entry for k in range(30)]
    study = parse_study({"study": "mine", "title": "Mine", "recordings": entries}, "study.yaml")
    assert len(study.recordings) == 30
