"""Examples in documents: where they stand, what kind they are, and whether they hold."""

import ast
import functools
import re
import shlex
from collections.abc import Iterator
from contextlib import suppress
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
from ur5lib.workspace.beside import entry_points

MARKDOWN = MarkdownIt("commonmark").enable("table")
COMMANDS = ("make", "snakemake", "ur5", "python", "git", "pip", "docker")
COMMANDS += ("cp", "rm", "sbatch", "cd", "source", "ros2", ".")
INLINE = re.compile(rf"(?:\.venv/bin/)?(?:{'|'.join(COMMANDS[:-1])})(?= )")
FIRST = {  # what the first line of a block begins with
    "python": re.compile(r"(?:import|from|def|class|>>>) "),
    "yaml": re.compile(r"(?:- )?\{?[a-z_]+:(?: |\n|$)"),
    "cpp": re.compile(r"#include "),
    "toml": re.compile(r"\[\w+[.\]]"),
    "way-points": re.compile(r"-?\d+\.\d+,"),
    "moves": re.compile(r"move[jl]\("),
    "listing": re.compile(r"[\w./-]+/?(?:,? [\w./-]+/\S*)? {2,}\S"),
    "equation": re.compile(r".* [=∝] "),
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
CALIBRATION = "".join(f"delta_{n} = [0, 0, 0, 0, 0, 0]\n" for n in ("theta", "d", "a", "alpha"))


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
            yield line, dedent(token.content), kind_of(dedent(token.content))
        for span in (one.content for one in token.children or [] if one.type == "code_inline"):
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
    """What a block is: shell, one of FIRST, or unknown."""
    lines = [line for line in block.splitlines() if line.strip()]
    if all(line.split()[0].removeprefix(".venv/bin/") in COMMANDS for line in lines):
        return "shell"
    return next((kind for kind, first in FIRST.items() if first.match(lines[0])), "unknown")


def words_of(line: str) -> list[str]:
    """A command's words: placeholders filled in, less brackets of what may be left out."""
    filled = re.sub(r"<[\w ]+>", "thing", line).replace("[", "").replace("]", "")
    words = shlex.split(filled, comments=True)
    return words[: words.index(">")] if ">" in words else words


def check_command(line: str) -> None:
    """Assert that a command, and one inside it, is known with its options."""
    words = words_of(line)
    if "&&" in words or "--wrap" in words:  # of cd and sbatch
        return check_command(words[-1] if "--wrap" in words else line.partition("&&")[2])
    name, *words = words or [""]
    match name.removeprefix(".venv/bin/"):
        case "ur5" if words and words[0].startswith("-"):
            own = typer.main.get_command(app).params
            assert words[0] in [option for each in own for option in each.opts], words
        case "ur5" if words:
            known = dict.fromkeys(entry_points())  # the package of one may be deleted
            known |= typer.main.get_command(app).commands  # type: ignore[attr-defined]
            command = known[words[0]]
            if command and words[1:]:  # else the text names the command
                with suppress(InputError):  # a study that is not here
                    command.make_context(words[0], words[1:])
        case "make":
            makefile = (PROJECT / "Makefile").read_text()
            for word in words:
                known = rf"^{word.split('=')[0]} [?:]?=" if "=" in word else f"^{word}:"
                assert re.search(known, makefile, re.MULTILINE), f"no {word} in the Makefile"
        case "snakemake":  # a cluster's executor is a plugin that may not be installed here
            parser = get_argument_parser()
            known = parser.parse_args(["local" if word == "slurm" else word for word in words])
            named = [str(path) for path in known.configfile or [] if "/" in str(path)]
            assert all((PROJECT / path).exists() for path in named), named
        case "python":
            script = PROJECT / (words[1].replace(".", "/") + ".py")
            text = script.read_text() + (PROJECT / "benchmarks/harness/options.py").read_text()
            assert all(f'"{word}"' in text for word in words if word.startswith("--")), words
        case "ros2":
            known_file = words[0] == "launch" and Path(words[1]).name == "ur5_force.launch.py"
            assert known_file or words == ["topic", "echo"], words
        case "cp" | "rm":  # what no run makes is there
            named = [word for word in words if not word.startswith(("-", "results/", ".venv"))]
            assert all((PROJECT / word).exists() for word in named), named
    return None


# Studies


def yaml_faults(text: str, folder: Path) -> list[str]:
    """What is wrong with a study or a part of one, completed by as little as there may be.

    folder: where the files that it names are made.
    """
    return min((faults_of(study, folder) for study in completed(yaml.safe_load(text))), key=len)


def completed(part: Any) -> list[dict[str, Any]]:
    """All studies that a part may be of: its recordings, settings, an entry, a sensor, a device."""
    head = {"study": "mine", "title": "Mine"}
    if isinstance(part, list):
        return [head | {"recordings": part}]
    entries = [ENTRY | form for form in FORMATS[: 1 if "simulate" in part else None]]
    parts: list[dict[str, Any]] = [{"recordings": entries[:1]} | part]
    parts += [{"recordings": [entry | part]} for entry in entries]
    parts += [{"recordings": [ENTRY | FORMATS[1] | {"role": "contact"} | part]}]
    parts += [{"recordings": [ENTRY | FORMATS[1] | {"force_sensor": SENSOR | part}]}]
    parts += [
        {"recordings": entries[:1], "devices": LAB | {name: LAB[name] | part}} for name in LAB
    ]
    return [head | part for part in parts]


def faults_of(study: dict[str, Any], folder: Path) -> list[str]:
    """The lines of a study's error, none if it is valid; the files that it names are made."""
    for entry in study["recordings"]:
        own, pattern = folder / str(entry.get("folder", "")), str(entry.get("file", ""))
        own.mkdir(parents=True, exist_ok=True)
        if "*" in pattern:
            found = own / pattern.replace("*", "1")
            found.parent.mkdir(parents=True, exist_ok=True)
            found.touch()
        way_points = entry.get("simulate", {}).get("trajectory", {}).get("way_points")
        if isinstance(way_points, str):
            (folder / way_points).write_text("movej([0, -1, 1, 0, 0, 0])\n" * 2)
    if isinstance(arm := study.get("robot"), dict) and "calibration" in arm:
        (folder / arm["calibration"]).write_text(CALIBRATION)
    try:
        parse_study(study, "the example")
    except InputError as error:
        return str(error).splitlines()
    return []
