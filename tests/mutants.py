"""Mutants: changes of one operator, sign, number or axis, each of which tests should notice.

`python -m tests.mutants force -n 60 --seed 1` draws them in `ur5lib/force`, or in one file there;
`--since main` in the lines that a branch changed. Each is tried on a copy of the project, by the
tests that reach its line, the fastest first (tests/reached_lines.py); what no test notices is
printed. Studies in other processes, and tests marked slow, take no part.
"""

import argparse
import ast
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from itertools import accumulate
from math import ceil, log2
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.reached_lines import MAPPED, Recorder, near, read_map
from tests.warm_snakemake import OF_STEPS

for library in (*OF_STEPS, "cvxpy", "hypothesis", "pinocchio", "torch"):
    import_module(library)  # once, not by each run

PROJECT = Path(__file__).parents[1]

SWAPPED = {"+": "-", "-": "+", "*": "/", "/": "*", "//": "*", "**": "*", "%": "*"}
SWAPPED |= {"<": ">=", ">": "<=", "<=": ">", ">=": "<", "==": "!=", "!=": "=="}
SWAPPED |= {"and": "or", "or": "and"}
OPERATOR = re.compile(r"\*\*|//|[<>=!]=|\band\b|\bor\b|[-+*/%<>]")
IN_CPP = re.compile(r"(?<= )(?:[-+*/<>]|[<>=!]=)(?= )|(?<![\w.])\d+(?:\.\d*)?(?:e-?\d+)?(?![\w.])")
ENOUGH = 60.0  # s of processor, as maps have them, for a mutant: what lives longer counts as alive
LEAST_LIMIT = 20.0
MAPPING_LIMIT = 1800.0
WAITING = 20  # seconds on the clock for one of the processor


class Mutant(NamedTuple):
    """Another text between two places (in bytes) of a file."""

    file: Path
    start: int
    end: int
    text: str

    def source(self, content: bytes) -> bytes:
        """Return the file's content with the change."""
        return content[: self.start] + self.text.encode() + content[self.end :]

    def number(self, content: bytes) -> int:
        """Return its line, from 1 on."""
        return content.count(b"\n", 0, self.start) + 1

    def statement(self, content: bytes) -> frozenset[int]:
        """Return the lines of the statement that it is in, but for those of a block below."""
        number, lines = self.number(content), frozenset[int]()
        for node in ast.walk(ast.parse(content)):  # outer ones first
            if isinstance(node, ast.stmt) and node.lineno <= number <= (node.end_lineno or 0):
                first = [one.lineno for one in getattr(node, "body", [])][:1]
                last = first[0] - 1 if first else node.end_lineno or 0
                lines = frozenset(range(node.lineno, last + 1))
        return lines

    def line(self, content: bytes) -> str:
        """Return where it is, and the line before and after."""
        number = self.number(content) - 1
        before, after = (
            text.split(b"\n")[number].decode().strip() for text in (content, self.source(content))
        )
        return f"{self.file}:{number + 1}\n    - {before}\n    + {after}"


def other_number(value: complex | bool, axis: bool) -> str:
    """Return another number, by which an axis stays one."""
    if isinstance(value, bool):
        return str(not value)
    if axis:
        return "1" if value == 0 else "0"
    return repr(value + 1) if isinstance(value, int) else repr(1.5 * value if value else 1.0)


def mutants_of_python(file: Path, content: bytes) -> Iterator[Mutant]:
    """Yield the mutants of a module."""
    starts = [0, *(match.end() for match in re.finditer(b"\n", content))]
    tree = ast.parse(content)
    axes = {
        id(node)
        for call in ast.walk(tree)
        if isinstance(call, ast.keyword) and call.arg == "axis"
        for node in ast.walk(call.value)
    }

    def place(node: ast.expr) -> tuple[int, int]:
        assert node.end_lineno
        assert node.end_col_offset is not None
        start = starts[node.lineno - 1] + node.col_offset
        return start, starts[node.end_lineno - 1] + node.end_col_offset

    def between(left: ast.expr, right: ast.expr) -> Iterator[Mutant]:
        start, end = place(left)[1], place(right)[0]
        if (found := OPERATOR.search(content[start:end].decode())) and found[0] in SWAPPED:
            yield Mutant(file, start + found.start(), start + found.end(), SWAPPED[found[0]])

    for node in code_of(tree):
        match node:
            case ast.BinOp(left=left, right=right):
                yield from between(left, right)
            case ast.Compare(left=left, comparators=others):
                for one, other in zip([left, *others], others, strict=False):
                    yield from between(one, other)
            case ast.BoolOp(values=[first, second, *_]):
                yield from between(first, second)
            case ast.UnaryOp(op=ast.USub() | ast.Not() as sign):
                start = place(node)[0]
                yield Mutant(file, start, start + (3 if isinstance(sign, ast.Not) else 1), "")
            case ast.Constant(value=bool() | int() | float() as value):
                yield Mutant(file, *place(node), other_number(value, id(node) in axes))


def code_of(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a tree, but for annotations and decorators."""
    yield node
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns", "decorator_list"):
            for one in value if isinstance(value, list) else [value]:
                if isinstance(one, ast.AST):
                    yield from code_of(one)


def mutants_of_cpp(file: Path, content: bytes) -> Iterator[Mutant]:
    """Yield the mutants of a header, by its text without comments, strings and templates."""
    text = content.decode("latin-1")  # a letter a byte
    bare = re.sub(r'//.*|#.*|"[^"\n]*"|/\*.*?\*/|<[^<>\n;]*>', lambda m: " " * len(m[0]), text)
    for found in IN_CPP.finditer(bare):
        number = re.match(r"\d", found[0])
        other = other_number(ast.literal_eval(found[0]), False) if number else SWAPPED[found[0]]
        yield Mutant(file, *found.span(), other)


def mutants_of(file: Path, content: bytes) -> Iterator[Mutant]:
    """Yield the mutants of a file."""
    return (mutants_of_cpp if file.suffix == ".hpp" else mutants_of_python)(file, content)


class Copy:
    """A copy of the project's own files, in which tests are mapped and mutants tried."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / PROJECT.name
        listed = subprocess.check_output(["git", "ls-files", "-z"], cwd=PROJECT, text=True)
        for name in filter(None, listed.split("\0")):
            if (source := PROJECT / name).is_file():
                (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(source, self.folder / name)
        if (shared := PROJECT.parent / "shared").exists():
            (folder / "shared").symlink_to(shared.resolve())

    def tests(self, mutant: Mutant, files: Iterable[str]) -> dict[str, float]:
        """Return the processor seconds of the tests that reach a mutant, the fastest first."""
        name, content = str(mutant.file), (PROJECT / mutant.file).read_bytes()
        if mutant.file.suffix == ".hpp":  # which tests compile
            return {own: LEAST_LIMIT for own in files if "g++" in (PROJECT / own).read_text()}
        found: dict[str, float] = {}
        for test in files:
            if not (known := read_map(test)).holds_for(name):
                if failed := self.failure([test], MAPPING_LIMIT, Recorder(test)):
                    print(f"without any change, {failed} fails: it is left out", flush=True)
                known = read_map(test)
            found |= known.tests(name, mutant.statement(content))
        # in steps of twice the time; within one by file, of which fixtures are then made once
        order = sorted(found, key=lambda test: (int(log2(found[test] + 0.01)), test))
        spent = accumulate(found[test] for test in order)
        pairs = zip(order, spent, strict=True)
        return {test: found[test] for test, until in pairs if until - found[test] < ENOUGH}

    def killer(self, mutant: Mutant) -> str:
        """Return what notices a mutant, "" if nothing does: first of its room, then of others."""
        for files in near(str(mutant.file)):
            if tests := self.tests(mutant, files):
                with self.changed(mutant):
                    failed = self.failure(tests, LEAST_LIMIT + 4 * sum(tests.values()))
                if failed:
                    return failed
        return ""

    @contextmanager
    def changed(self, mutant: Mutant) -> Iterator[None]:
        """Have a mutant in the copy."""
        file = self.folder / mutant.file
        content = file.read_bytes()
        file.write_bytes(mutant.source(content))
        try:
            yield
        finally:
            file.write_bytes(content)

    def failure(self, tests: Iterable[str], seconds: float, *plugins: object) -> str:
        """Return which test fails first, "" if none does; seconds: of processor, then it hangs."""
        log = self.folder / "mutants.log"
        given = (self.folder, [*tests], log, ceil(seconds), plugins)
        process = get_context("fork").Process(target=_try, args=given)
        process.start()
        process.join(WAITING * seconds)  # for what sleeps
        if process.exitcode is None or process.exitcode in (-signal.SIGXCPU, -signal.SIGKILL):
            with suppress(ProcessLookupError):
                os.killpg(process.pid or 0, signal.SIGKILL)
            process.join()
            return f"no end within {seconds:.0f} s"
        said = log.read_text(errors="replace")
        failed = re.search(r"^(?:FAILED|ERROR) (\S+)", said, re.MULTILINE)
        none = pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED
        return "" if process.exitcode in none else failed[1] if failed else said[-500:]


def _try(
    folder: Path, tests: list[str], log: Path, seconds: int, plugins: Sequence[object]
) -> None:
    """Run tests in a copy of the project, in a process that has loaded the libraries before."""
    os.setsid()
    os.chdir(folder)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    sys.dont_write_bytecode = not plugins  # a mutant's is not the code
    os.environ |= {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    sys.path.insert(0, str(folder))
    for name in [name for name in sys.modules if name.partition(".")[0] in ("tests", "ur5lib")]:
        del sys.modules[name]
    with log.open("w") as said:
        os.dup2(said.fileno(), 1)
        os.dup2(said.fileno(), 2)
    options = ["-q", "-n", "0", "-p", "no:cacheprovider", "--tb", "short", "-m", MAPPED]
    sys.exit(pytest.main([*options, *([] if plugins else ["-x"]), *tests], [*plugins]))


def changed_lines(since: str) -> dict[Path, set[int]]:
    """Return the lines of files in ur5lib that are new since a revision."""
    given = ["git", "diff", "--unified=0", "--no-renames", since, "--", "ur5lib"]
    said, found = subprocess.check_output(given, cwd=PROJECT, text=True), {}
    for name, hunks in re.findall(
        r"^\+\+\+ b/(\S+\.(?:py|hpp))\n((?:[^d].*\n)*)", said, re.MULTILINE
    ):
        starts = re.findall(r"^@@ .*\+(\d+)(?:,(\d+))? @@", hunks, re.MULTILINE)
        found[Path(name)] = {
            int(start) + k for start, count in starts for k in range(int(count or 1))
        }
    return found


def drawn(part: Path, lines: dict[Path, set[int]], count: int, seed: int) -> list[Mutant]:
    """Return mutants of a folder's files, or of one file, of which all are as likely.

    lines: of files of which these alone are meant; {} means all files and lines.
    """
    kinds = ("*.py", "*.hpp")
    files = [part] if (PROJECT / part).is_file() else [
        file.relative_to(PROJECT) for kind in kinds for file in sorted((PROJECT / part).rglob(kind))
    ]  # fmt: skip
    if not files:
        sys.exit(f"{part} has no file; name a folder or file in ur5lib, e.g. topics/live/live.hpp")
    texts = {file: (PROJECT / file).read_bytes() for file in files if not lines or file in lines}
    every = [
        mutant
        for file, text in texts.items()
        for mutant in mutants_of(file, text)
        if not lines or mutant.number(text) in lines[file]
    ]
    return random.Random(seed).sample(every, min(count, len(every)))


def main() -> None:
    """Try mutants of a room or a branch, and print those that no test notices."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("room", type=Path, nargs="?", default="", help="in ur5lib, e.g. force")
    options.add_argument("-n", "--number", type=int, default=60)
    options.add_argument("--seed", type=int, default=random.randrange(10_000))
    options.add_argument("--since", help="only of lines that are new since a revision, e.g. main")
    given = options.parse_args()
    lines = changed_lines(given.since) if given.since else {}
    if given.since and not lines:
        sys.exit(f"no line of ur5lib is new since {given.since}")
    chosen = drawn("ur5lib" / given.room, lines, given.number, given.seed)
    print(f"{len(chosen)} mutants of ur5lib/{given.room}, seed {given.seed}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        copy, survivors, killers = Copy(Path(folder)), [], set()
        for number, mutant in enumerate(chosen, 1):
            killer = copy.killer(mutant)
            line = mutant.line((PROJECT / mutant.file).read_bytes())
            print(f"{number}: {killer or 'SURVIVES'}: {line}", flush=True)
            survivors += [] if killer else [line]
            killers |= {killer.partition("[")[0]} if killer.startswith("tests/") else set()
        if failed := killers and copy.failure(sorted(killers), MAPPING_LIMIT):
            sys.exit(f"without any change, {failed} fails, too; mend it first")
    killed = len(chosen) - len(survivors)
    print(f"{killed} of {len(chosen)} killed ({killed / len(chosen):.0%}); these survive:")
    print("\n".join(survivors))


if __name__ == "__main__":
    main()
