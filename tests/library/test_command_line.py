"""`ur5` itself: its help, its version, completion, and names that are nearly right."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import ur5lib
from tests.commands import Command
from ur5lib.cli import app
from ur5lib.errors import InputError

COMMANDS = {one.name or one.callback.__name__: one.callback for one in app.registered_commands}


def told(*words: str) -> str:
    """What a command prints, as one line without the breaks of a narrow terminal."""
    done = CliRunner().invoke(app, words)
    error = done.exception if isinstance(done.exception, InputError) else ""
    return " ".join(f"{done.output} {error}".split())


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_every_unit_and_placeholder(command: str) -> None:
    """As written: no markup takes `[s]` or `<study>` for its own."""
    hints = COMMANDS[command].__annotations__.values()
    helps = [own.help or "" for hint in hints for own in getattr(hint, "__metadata__", ())]
    shown = told(command, "-h")
    assert [text for text in helps if " ".join(text.split()) not in shown] == []


def test_each_command_is_told_in_a_whole_sentence() -> None:
    listed = told("-h")
    assert not re.search(r"\w\.\.\.", listed)
    assert listed == told("--help") == told()
    assert all(f" {command} " in listed for command in COMMANDS)


def test_the_version_is_told() -> None:
    assert told("--version") == f"ur5lib {ur5lib.__version__}"


def test_a_shell_completes_commands() -> None:
    typed = {"_UR5_COMPLETE": "complete_bash", "COMP_WORDS": "ur5 che", "COMP_CWORD": "1"}
    done = CliRunner().invoke(app, [], prog_name="ur5", env=typed)
    assert done.output.split() == ["check"]


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("chek x.yaml", "check"),
        ("export --robot ur5ee", "ur5e"),
        ("export --robot ur5 --to urfd", "urdf"),
        ("export --robot ur5 --model C+rotor", "C+rotors"),
        ("fetch tesis", "thesis"),
        ("compare . . --fail-on forse", "force"),
    ],
)
def test_a_name_that_is_nearly_right_is_named(words: str, meant: str) -> None:
    found = told(*words.split())
    assert re.search(rf"[Dd]id you mean .?{re.escape(meant)}['`]", found), found


def test_a_study_names_the_arm_that_may_be_meant(tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    entry = f"{{name: a, robot: ur5ee, format: rtde-csv, folder: {tmp_path}, file: a, role: fit}}"
    study.write_text(f"study: a\ntitle: A\nrecordings: [{entry}]\n")
    assert "`ur5ee` (did you mean `ur5e`?)" in told("check", str(study))


LONG = "a" * 300


@pytest.mark.parametrize(
    "words",
    [
        f"figure {LONG} torques",
        f"compare {LONG} .",
        f"convert {LONG}",
        f"export --robot ur5 --results {LONG}",
        f"new {LONG}",
        f"describe {LONG}",
    ],
)
def test_a_name_that_no_file_can_have_is_told_in_a_sentence(
    words: str, run_ur5: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = run_ur5(*words.split())
    assert answer.status == 1
    assert answer.err.startswith(f"ur5: {LONG}")
    assert answer.err.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "damaged"),
    [("compare . .", "tables/quality.csv"), ("convert .", "recordings/run/signals.parquet")],
)
def test_a_damaged_result_is_told_in_a_sentence(
    words: str, damaged: str, run_ur5: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path(damaged)
    path.parent.mkdir(parents=True)
    path.write_text("PAR1")
    answer = run_ur5(*words.split())
    assert answer.status == 1
    assert answer.err.startswith(f"ur5: {path} is damaged")
    assert answer.err.count("\n") == 1
