"""Files, names and text from outside that would hang a program, fill it, or steer a terminal."""

import json
import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from tests.command import SECONDS, Command, time_limit
from tests.conftest import said
from tests.corpus import rtde
from tests.stored_files import frame, made_up_channels, write_hdf5
from ur5lib.errors import InputError, Remark, printable
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.quality import Finding
from ur5lib.report.stated import Step
from ur5lib.robots.description import load_robot, read_description, robot_path
from ur5lib.stand.trajectories import read_way_points
from ur5lib.study.reading import parse_study

MARKUP = ["[/x]", "[red]", ":x:", "[link=http://x]", "\\[/x]"]
CONTROLS = ["\x1b[31m", "\x1b]0;title\x07", "\x9b31m", "\x00", "\x08", "\u202e", "\udcff", "\x7f"]
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


# Text that a terminal or rich would obey


@pytest.mark.parametrize("text", CONTROLS)
def test_control_characters_become_visible(text: str) -> None:
    for shown in (
        printable(text),
        str(InputError(f"a {text} b")),
        said(Finding("robot", Found.TORN_LAST_LINE, "note", 1, text)),
        Finding("robot", Found.TORN_LAST_LINE, "note", 1, "", place=text).place,
        Remark(CauseCode.OTHER_REASON, text).sentence(),
        Step(text).sentence,
    ):
        assert shown.isprintable()
        assert "\\" in shown


def test_other_text_stays_as_it_is() -> None:
    text = "F̂ᵐᵃᵖ 5 N ± 1, 日本, “é”;\na second line\tafter a tab"
    assert printable(text) == text


@pytest.mark.parametrize("name", MARKUP)
def test_what_looks_like_markup_is_printed_as_it_is(
    study: Path, run_ur5: Command, name: str
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
    printed = run_ur5("check", study).line
    assert f"{name}: " in printed
    assert repr(name) in printed
    assert f"{force.name}, line 1" in printed


@pytest.mark.parametrize("text", CONTROLS)
def test_control_characters_do_not_reach_the_terminal(
    study: Path, run_ur5: Command, text: str
) -> None:
    robot = study.parent / "rtde/robot.csv"
    head, *rows = robot.read_bytes().splitlines(keepends=True)
    data = os.fsencode(text) if text == "\udcff" else text.encode()
    robot.write_bytes(head.rstrip() + b",a" + data + b"b\n" + b"".join(rows))
    said = [run_ur5("check", study)]
    study.write_text(study.read_text().replace("robot.csv", "robot.csv\\u001b[31m"))
    for arguments in (["check", study], ["check", text.replace("\0", "")], [text], ["fetch", text]):
        said.append(run_ur5(*arguments))
    assert all(one.line.isprintable() for one in said)


NAMES = ["\x1b[31m", "\u202e", "\u2028", "\x85", "\n  role: fit", "\t"]


# In a CSV file, a break ends the line, and a tab the cell.
NAMED = [(kind, text) for kind in ("hdf5", "parquet") for text in NAMES]
NAMED += [("csv", text) for text in NAMES[:-2]]


@pytest.mark.parametrize(("kind", "text"), NAMED)
def test_a_control_character_in_a_name_of_a_file_is_refused(
    run_ur5: Command, tmp_path: Path, kind: str, text: str
) -> None:
    """By `ur5 import`, whose tables and entries would hand it on."""
    time, channels = made_up_channels(tmp_path / "made", seconds=1)
    named = {f"{name}{text}": values for name, values in channels.items()}
    path = tmp_path / f"run.{kind}"
    if kind == "hdf5":
        write_hdf5(path, time, named)
    elif kind == "parquet":
        frame(time, channels).rename(columns=lambda name: name + text).to_parquet(path)
    else:
        frame(time, channels).rename(columns=lambda name: name + text + "x").to_csv(path)
    said = run_ur5("import", path, "--robot", "ur5")
    assert said.status == 1
    assert said.out == ""
    assert "has a control character; rename it there" in said.line
    assert said.line.isprintable()


@pytest.mark.parametrize("text", NAMES)
def test_a_control_character_in_an_arm_s_names_is_refused(tmp_path: Path, text: str) -> None:
    plain = read_description(robot_path("ur5"))
    first, *others = plain["joints"]
    plain["joints"] = [first + text, *others]
    plain["motors"][first + text] = plain["motors"][first]
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(plain))
    with pytest.raises(InputError, match="has a control character; give another"):
        load_robot(path)


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
@pytest.mark.parametrize("name", ["robot.csv", "force.csv", "start.txt", "capture.csv"])
def test_a_recording_s_file_that_is_none_is_named_at_once(
    study: Path, run_ur5: Command, name: str, kind: str, make: Make
) -> None:
    path = Path("rtde", name)
    path.unlink(missing_ok=True)
    make(path)
    if name == "capture.csv":
        text = study.read_text().replace("rtde-csv", "realtime-stream")
        study.write_text(text.replace("robot.csv", name))
    said = run_ur5("check", study)
    assert said.status == 1
    assert f"{path} is {kind}" in said.line


@special
def test_a_study_that_is_no_file_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command, kind: str, make: Make
) -> None:
    monkeypatch.chdir(tmp_path)
    make(Path("study.yaml"))
    said = run_ur5("check", "study.yaml")
    assert said.status == 1
    assert f"study.yaml is {kind}" in said.err


@special
def test_way_points_that_are_no_file_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, make: Make
) -> None:
    monkeypatch.chdir(tmp_path)
    make(Path("file"))
    with time_limit(SECONDS), pytest.raises(InputError, match=f"^file is {kind}"):
        read_way_points("file")


@special
def test_a_study_that_names_such_a_file_says_so(
    study: Path, run_ur5: Command, kind: str, make: Make
) -> None:
    make(study.with_name("way_points"))
    plan = "{trajectory: {kind: movej, way_points: way_points}}"
    entry = f"- {{name: made, robot: ur5, format: thesis-csv, role: fit, simulate: {plan}}}\n"
    study.write_text(f"reference: way_points\n{study.read_text()}{entry}")
    said = run_ur5("check", study)
    assert said.status == 1
    assert said.line.count("'way_points'") == said.line.count(f"not {kind}") == 2


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
def test_a_study_that_expands_beyond_measure_is_refused_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command, bomb: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.yaml").write_text(f"study: mine\ntitle: Mine\n{bomb}\n")
    said = run_ur5("check", "study.yaml")
    assert said.status == 1
    assert said.err.startswith("ur5: study.yaml ")
    assert said.err.count("\n") == 1


def test_aliases_in_good_measure_are_fine(tmp_path: Path) -> None:
    posture = [0.1] * 6
    plan = {"trajectory": {"kind": "movej", "way_points": [posture] * 300}}
    entry = {"robot": "ur5", "format": "thesis-csv", "role": "fit", "simulate": plan}
    entries = [{"name": f"run_{k}"} | entry for k in range(30)]
    study = parse_study({"study": "mine", "title": "Mine", "recordings": entries}, "study.yaml")
    assert len(study.recordings) == 30
