"""Examples in documents: where they stand, what kind they are, and whether they hold."""

import ast
import functools
import re
import shlex
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent
from typing import Any

import typer
import yaml
from markdown_it import MarkdownIt
from snakemake.cli import get_argument_parser

from tests.conftest import PROJECT
from ur5lib.cli import app
from ur5lib.errors import InputError
from ur5lib.study.model import Study
from ur5lib.study.reading import parse_study

MARKDOWN = MarkdownIt("commonmark").enable("table")
COMMANDS = ("make", "snakemake", "ur5", "git", "python", "pip", "cp", "rm", "sbatch", "cd", ".")
INLINE = re.compile(rf"(?:\.venv/bin/)?(?:{'|'.join(COMMANDS[:-1])})(?= )")
FIRST = {  # what the first line of a block begins with
    "python": re.compile(r"(?:import|from|def|class|>>>) "),
    "yaml": re.compile(r"(?:- )?\{?[a-z_]+:(?: |\n|$)"),
    "way-points": re.compile(r"-?\d+\.\d+,"),
    "moves": re.compile(r"move[jl]\("),
    "listing": re.compile(r"[\w./-]+/?(?:,? [\w./-]+/\S*)? {2,}\S"),
}
ENTRY = {"name": "run", "robot": "ur5", "role": "fit", "folder": "raw/mine"}
FORMATS: list[dict[str, Any]] = [
    {"format": "thesis-csv"},
    {"format": "rtde-csv", "file": "robot.csv"},
    {"format": "realtime-stream", "file": "robot.csv"},
    {"format": "table-csv", "file": "robot.csv", "columns": ["time", "actual_q"]},
]
LAB: dict[str, dict[str, Any]] = {
    "robot": {"address": "arm"},
    "force_sensor": {"address": "box"},
    "imu": {"port": "/dev/ttyUSB0"},
}
SENSOR = {"file": "force.csv", "columns": ["time", "ft"]}
CALIBRATION = "\n".join(
    f"delta_{name} = [0, 0, 0, 0, 0, 0]" for name in ("theta", "d", "a", "alpha")
)


@dataclass(frozen=True)
class Example:
    """A block of a document, or a span in a line of it."""

    page: str
    line: int
    text: str
    kind: str

    def __str__(self) -> str:
        """Where it stands."""
        return f"{self.page}:{self.line}"


def examples(page: Path) -> list[Example]:
    """All blocks of a page, and the spans that are commands or parts of a study."""
    text = page.read_text()
    if page.suffix == ".py":
        text = ast.get_docstring(ast.parse(text)) or ""
    name = str(page.relative_to(PROJECT))
    return [Example(name, line, part, kind) for line, part, kind in parts(text)]


def parts(text: str) -> Iterator[tuple[int, str, str]]:
    """The line, text and kind of each example."""
    for token in MARKDOWN.parse(text):
        line = token.map[0] + 1 if token.map else 0
        if token.type in ("fence", "code_block"):
            block = dedent(token.content)
            yield line, block, kind_of(block)
        for child in token.children or []:
            span = child.content
            if child.type != "code_inline":
                continue
            if INLINE.match(span):
                yield line, span, "shell"
            elif re.match(r"[a-z_]+: ", span) and span.split(":")[0] in study_keys():
                yield line, span, "yaml"


@functools.cache
def study_keys() -> set[str]:
    """All keys that a study and its parts may have."""
    schema = Study.model_json_schema()
    parts = [schema, *schema["$defs"].values()]
    return {key for part in parts for key in part.get("properties", {})}


def kind_of(block: str) -> str:
    """What a block is: shell, equation, one of FIRST, or unknown."""
    lines = [line for line in block.splitlines() if line.strip()]
    if all(line.split()[0].removeprefix(".venv/bin/") in COMMANDS for line in lines):
        return "shell"
    kinds = [kind for kind, first in FIRST.items() if first.match(lines[0])]
    equation = all(re.search(" [=∝] ", line) for line in lines)
    return next(iter(kinds), "equation" if equation else "unknown")


# Shell


def shell_faults(text: str) -> list[str]:
    """What is wrong with the commands of an example."""
    return [
        f"`{line}`: {fault}"
        for line in text.splitlines()
        if (words := words_of(line)) and (fault := command_fault(words))
    ]


def words_of(line: str) -> list[str]:
    """A command's words: placeholders filled in, less brackets of what may be left out."""
    filled = re.sub(r"<[\w ]+>", "thing", line).replace("[", "").replace("]", "")
    words = shlex.split(filled, comments=True)
    return words[: words.index(">")] if ">" in words else words


def command_fault(words: list[str]) -> str | None:
    """Why a command cannot be run as it stands."""
    check = SHELL[words[0].removeprefix(".venv/bin/")]
    try:
        return check(words[1:])
    except (Exception, SystemExit) as error:  # each parser has its own
        return str(getattr(error, "message", error))


def check_make(words: list[str]) -> str | None:
    makefile = (PROJECT / "Makefile").read_text()
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    variables = set(re.findall(r"^([A-Z]+) [?:]?=", makefile, re.MULTILINE))
    given = {word.split("=")[0] for word in words if "=" in word}
    wrong = ({word for word in words if "=" not in word} - targets) | (given - variables)
    return f"the Makefile has no {', '.join(sorted(wrong))}" if wrong else None


def check_snakemake(words: list[str]) -> str | None:
    """Its options; a cluster's executor is a plugin that may not be installed here."""
    words = ["local" if word == "slurm" else word for word in words]
    parser = get_argument_parser()
    parser.exit_on_error = False
    known = parser.parse_args(words)
    named = [str(path) for path in known.configfile or []] if known.configfile else []
    wrong = [name for name in named if "/" in name and not (PROJECT / name).exists()]
    return f"there is no {', '.join(wrong)}" if wrong else None


def check_ur5(words: list[str]) -> str | None:
    group = typer.main.get_command(app)
    command = group.commands.get(words[0])  # type: ignore[attr-defined]
    if command is None:
        return f"there is no command {words[0]}"
    if words[1:]:  # else the text names the command
        command.make_context(words[0], list(words[1:]))
    return None


def check_python(words: list[str]) -> str | None:
    if words[0] == "-m":
        words = [words[1].replace(".", "/") + ".py", *words[2:]]
    script = PROJECT / words[0]
    if not script.is_file():
        return f"there is no {words[0]}"
    options = [word for word in words if word.startswith("--")]
    text = script.read_text()
    if "benchmarks.harness.options" in text:
        text += (PROJECT / "benchmarks/harness/options.py").read_text()
    missing = [option for option in options if f'"{option}"' not in text]
    return f"{words[0]} knows no {', '.join(missing)}" if missing else None


def check_files(words: list[str]) -> str | None:
    """Of cp and rm: what is not made by a run is there."""
    made = ("results/", ".venv", "raw/")
    named = [word for word in words if not word.startswith(("-", *made))]
    wrong = [word for word in named if not (PROJECT / word).exists()]
    return f"there is no {', '.join(wrong)}" if wrong else None


def check_sbatch(words: list[str]) -> str | None:
    """The command that it is to run."""
    return command_fault(shlex.split(words[words.index("--wrap") + 1]))


def check_cd(words: list[str]) -> str | None:
    """The command that follows."""
    return command_fault(words[2:]) if words[1:2] == ["&&"] else None


SHELL: dict[str, Callable[[list[str]], str | None]] = {
    "make": check_make,
    "snakemake": check_snakemake,
    "ur5": check_ur5,
    "python": check_python,
    "cp": check_files,
    "rm": check_files,
    "sbatch": check_sbatch,
    "cd": check_cd,
    "git": lambda words: None if words[0] in {"clone", "describe", "status"} else "unknown",
    "pip": lambda words: None if words[0] == "install" else "unknown",
    ".": lambda words: None if words == [".venv/bin/activate"] else "no such environment",
}


# Studies


def yaml_faults(text: str, folder: Path) -> list[str]:
    """What is wrong with a study or a part of one, completed by as little as there may be.

    folder: where the files that it names are made.
    """
    part = yaml.safe_load(text)
    found = [faults_of(study, folder) for study in completed(part)]
    return min(found, key=len)


def completed(part: Any) -> list[dict[str, Any]]:
    """All studies that a part may be of: its recordings, settings, an entry, a sensor, a device."""
    head = {"study": "mine", "title": "Mine"}
    entries = [ENTRY | form for form in FORMATS]
    if isinstance(part, list):
        return [head | {"recordings": part}]
    if "simulate" in part:
        entries = [ENTRY | form for form in FORMATS[:1]]
    parts: list[dict[str, Any]] = [{"recordings": entries[:1]} | part]
    parts += [{"recordings": [entry | part]} for entry in entries]
    parts += [{"recordings": [entries[1] | {"force_sensor": SENSOR | part}]}]
    parts += [
        {"recordings": entries[:1], "devices": LAB | {name: LAB[name] | part}} for name in LAB
    ]
    return [head | part for part in parts]


def faults_of(study: dict[str, Any], folder: Path) -> list[str]:
    for entry in study["recordings"]:
        make_files(entry, folder)
    if isinstance(arm := study.get("robot"), dict) and "calibration" in arm:
        (folder / arm["calibration"]).write_text(CALIBRATION)
    try:
        parse_study(study, "the example")
    except InputError as error:
        return str(error).splitlines()
    return []


def make_files(entry: dict[str, Any], folder: Path) -> None:
    """Make what an entry names: its folder, a file of its pattern, its file of way-points."""
    (folder / str(entry.get("folder", ""))).mkdir(parents=True, exist_ok=True)
    if "*" in (pattern := entry.get("file", "")):
        found = folder / str(entry.get("folder", "")) / pattern.replace("*", "1")
        found.parent.mkdir(parents=True, exist_ok=True)
        found.touch()
    way_points = entry.get("simulate", {}).get("trajectory", {}).get("way_points")
    if isinstance(way_points, str):
        (folder / way_points).write_text("movej([0, -1, 1, 0, 0, 0])\n" * 2)


# Listings


def listing_faults(text: str) -> list[str]:
    """The files of a listing that do not exist; a line may name two, or go on with a text."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith(" ")]
    named = [re.split(r" {2,}", line)[0] for line in lines]
    paths = [path for names in named for path in names.split(", ")]
    return [f"there is no {path}" for path in paths if not (PROJECT / path).exists()]
