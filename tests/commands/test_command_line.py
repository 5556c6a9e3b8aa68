"""`ur5` itself: its help, its version, completion, and names that are nearly right."""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Literal, get_args, get_origin, get_type_hints

import pytest
from typer.testing import CliRunner

import ur5lib
from tests.command import Command, printed
from tests.conftest import PROJECT
from tests.examples import check_command
from ur5lib import cli
from ur5lib.cli import app
from ur5lib.commands import convert, exported, listed
from ur5lib.commands.arguments import ADDRESS_HELP
from ur5lib.datasets import fetching
from ur5lib.errors import InputError
from ur5lib.study.address import results_folder, study_file
from ur5lib.workspace import origin

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


def test_help_is_there_in_an_instant() -> None:
    command = "import resource, ur5lib.cli as c\ntry: c.main()\nfinally: "
    command += "print(sum(resource.getrusage(resource.RUSAGE_SELF)[:2]))"
    spent = printed([sys.executable, "-c", command, "--help"], PROJECT, os.environ)
    assert float(spent.splitlines()[-1]) < 0.5  # s of processor time


def test_each_command_is_told_in_a_whole_sentence() -> None:
    listed = told("-h")
    assert not re.search(r"\w\.\.\.", listed)
    assert listed == told("--help") == told()
    assert all(f" {command} " in listed for command in COMMANDS)


def test_help_fits_a_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = CliRunner().invoke(app, ["--help"]).output.splitlines()
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_s_example_is_one_that_it_takes(command: str) -> None:
    example = re.search(r"Example: (ur5 .*)$", str(COMMANDS[command].__doc__).strip())
    assert example
    assert example[1].split()[:2] == ["ur5", command]
    check_command(example[1])


def literals(command: str, parameter: str) -> set[str]:
    hint = get_type_hints(COMMANDS[command])[parameter]
    kinds = [hint, *get_args(hint)]
    return {name for kind in kinds if get_origin(kind) is Literal for name in get_args(kind)}


def test_choices_are_those_that_there_are() -> None:
    """Help and completion list them."""
    assert [*cli.EXPORTED] == [*exported.FORMATS]
    assert literals("convert", "format") == {*convert.WRITERS}
    assert all(name in told("export", "-h") for name in exported.FORMATS)


# What a user may write, and what the answer names; the status is 2 where it is no command's
WRONG_CALLS = [
    ("import a.csv --write mine.yaml", 2, "ur5 import a.csv --output mine.yaml"),
    ("import a.csv --write=mine.yaml", 2, "ur5 import a.csv --output=mine.yaml"),
    ("convert mine --to csv", 2, "ur5 convert mine --format csv"),
    ("export --robot ur5 --to mjcf", 2, "ur5 export --robot ur5 --format mjcf"),
    ("fetch ur10-bag --to raw/x", 2, "ur5 fetch ur10-bag --output raw/x"),
    ("export --robot ur5 --format urfd", 1, "did you mean `urdf`"),
    ("convert . --format matlab", 1, "did you mean `mat`"),
    ("export --robto ur5", 2, "Possible options: --robot"),
    ("chek mine", 2, "Did you mean 'check'"),
    ("run", 2, "Missing argument 'STUDY | RECORDINGS...'; as in: ur5 run raw/mine/*.csv"),
    ("status", 2, "Missing argument 'STUDY'; as in: ur5 status mine"),
    ("record lba.yaml free --seconds 2", 1, "lba.yaml"),
    ("import a.csv --add mien", 1, "did you mean `mine`"),
    ("status nothing", 1, "this folder has no study; make one by `ur5 new .`"),
    ("run a.csv", 1, "a.csv"),
    ("run mine --cores 2", 2, "ur5 run mine -- --cores 4"),
    ("run recordings", 1, "ur5 import recordings/* --output recordings.yaml"),
    ("check recordings", 1, "recordings is a folder of recordings"),
    ("status mine.yml", 1, "did you mean `mine.yaml`"),
    ("run mine.yaml other.yaml", 1, "build it: ur5 run mine.yaml"),
    ("import mine.yaml", 1, "mine.yaml is a study, no recording"),
    ("report results/built/report.html", 1, "report.html does not exist; build it: ur5 run built"),
    ("check results/no/report.html", 1, "unknown study 'no'; available: mine, other"),
    ("export ur5e", 2, "Missing option '--robot'; as in: ur5 export --robot ur5e"),
    ("import", 2, "as in: ur5 import raw/mine/*.csv"),
    ("import a.csv --rate fast", 2, "valid number"),
    ("import a.csv --robot", 2, "requires an argument; as in: ur5 import"),
    ("import a.csv --unit mA", 1, "as actual_current=mA"),
    ("check mine.yaml --al", 2, "--all"),
    ("fetch ur10bag", 1, "did you mean `ur10-bag`"),
    ("fetch --list", 2, "as in: ur5 fetch ur10-bag"),
    ("open mine", 2, "`ur5 -h` lists the commands"),
]


@pytest.mark.parametrize(("words", "status", "answer"), WRONG_CALLS)
def test_a_wrong_call_is_answered_with_the_right_one(
    words: str,
    status: int,
    answer: str,
    run_ur5: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    (tmp_path / "recordings").mkdir()  # so that . is a folder of results
    if "has no study" not in answer:
        for name in ("mine", "other"):
            (tmp_path / f"{name}.yaml").write_text(f"study: {name}\n")
    told = run_ur5(*words.split())
    assert told.status == status
    assert answer in told.err
    assert len(told.err.replace("files to read: 1\n", "").splitlines()) == 1


def test_the_version_names_commit_and_lock() -> None:
    commit = re.escape(origin.commit())
    assert re.fullmatch(
        rf"ur5lib {ur5lib.__version__}, commit {commit}, lock [0-9a-f]{{12}}", told("--version")
    )


def test_an_archive_states_the_commit_that_it_was_made_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`git archive` writes it in place of the mark, as .gitattributes asks for."""
    attributes = (PROJECT / ".gitattributes").read_text().split()
    assert attributes == [str(origin.STAMP.relative_to(PROJECT)), "export-subst"]
    assert origin.STAMP.read_text() == "$Format:%H$\n"
    monkeypatch.setattr(origin, "STAMP", tmp_path / "commit.txt")
    origin.STAMP.write_text(f"{'0123456789' * 4}\n")
    assert origin.commit() == "012345678901"


def test_the_last_group_of_the_help_has_what_is_seldom_used() -> None:
    panel = CliRunner().invoke(app, ["--help"]).output.split("\nOthers:\n")[1]
    listed = re.findall(r"^  (\w+) ", panel, re.MULTILINE)
    seldom = ("schema", "settings", "leaderboard", "replay")
    assert listed == [name for name in seldom if name in COMMANDS]


def test_help_names_arguments_without_their_types_in_python() -> None:
    assert "Usage: root import [OPTIONS] FILES... Write" in told("import", "-h")
    assert [name for name in COMMANDS if "<list[" in told(name, "-h")] == []


@pytest.mark.parametrize("command", COMMANDS)
def test_a_study_is_named_in_one_way(command: str) -> None:
    for name, hint in COMMANDS[command].__annotations__.items():
        for own in getattr(hint, "__metadata__", ()):
            if own.parser in (study_file, results_folder) or name in ("study", "results"):
                assert own.metavar == "STUDY"
                assert ADDRESS_HELP in own.help


def test_a_command_without_its_study_lists_those_that_there_are(
    run_ur5: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert (
        run_ur5("list").out == "this folder has no study; make one by `ur5 new .`, or name a file\n"
    )
    for name in ("mine", "other"):
        Path(f"{name}.yaml").write_text(f"study: {name}\n")
    report = Path("results/mine/report.html")
    report.parent.mkdir(parents=True)
    report.touch()
    os.utime(report, (0, 86400 * 366))
    answer = run_ur5("list")
    assert re.fullmatch(
        r"mine   mine.yaml   report of 1971-01-0\d \d\d:00\nother  other.yaml  not built\n",
        answer.out,
    )
    assert [run_ur5(name).out for name in ("run", "report", "status")] == [answer.out] * 3


@pytest.mark.parametrize(
    ("words", "kept"),
    [("fetch ur10-bag", "the files that are complete are kept"), ("list", "no file is left")],
)
def test_a_command_that_is_stopped_says_what_is_kept(
    words: str, kept: str, run_ur5: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(fetching, "fetch", stop)
    monkeypatch.setattr(listed, "studies_here", stop)
    answer = run_ur5(*words.split())
    assert answer.status == 130
    assert answer.err.startswith(f"ur5: stopped; {kept}")


def test_a_shell_completes_commands() -> None:
    typed = {"_UR5_COMPLETE": "complete_bash", "COMP_WORDS": "ur5 che", "COMP_CWORD": "1"}
    done = CliRunner().invoke(app, [], prog_name="ur5", env=typed)
    assert done.output.split() == ["check"]


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        ("chek x.yaml", "check"),
        ("export --robot ur5ee", "ur5e"),
        ("export --robot ur5 --format urfd", "urdf"),
        ("export --robot ur5 --model C+rotor", "C+rotors"),
        ("fetch tesis", "thesis"),
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
    [("convert .", "recordings/run/signals.parquet")],
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


@pytest.mark.parametrize(
    ("redirected", "sentence"),
    [(">/dev/full", "no room to write to (No space left on device)"), (">&-", "output is closed")],
)
@pytest.mark.parametrize("command", ["--version", "settings", "check config.yaml"])
def test_a_full_or_closed_output_is_told_in_a_sentence(
    command: str, redirected: str, sentence: str
) -> None:
    main = "-c 'from ur5lib.cli import main; main()'"
    line = f"{sys.executable} {main} {command} {redirected}"
    done = subprocess.run(line, shell=True, capture_output=True, text=True, cwd=PROJECT)
    assert done.returncode == 1
    assert done.stderr.startswith("ur5: ")
    assert sentence in done.stderr
    assert done.stderr.count("\n") == 1


LITTLE = """
import resource, sys
from ur5lib import cli
pages = int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + 20_000_000,) * 2)
sys.argv = ["ur5", "check", "config.yaml"]
cli.main()
"""


def test_a_lack_of_memory_is_told_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a package that cannot be loaded, too."""
    done = subprocess.run(
        [sys.executable, "-c", LITTLE], capture_output=True, text=True, cwd=PROJECT
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("ur5: the memory is full; ")

    def lack(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(cli, "app", lack)
    with pytest.raises(SystemExit, match="1"):
        cli.main()
