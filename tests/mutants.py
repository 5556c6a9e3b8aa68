"""Mutants: changes of one operator, sign, number or axis, each of which tests should notice.

`python -m tests.mutants force -n 60 --seed 1` draws them in `ur5lib/force`, or in one file there,
and runs the tests of the room's folder on each, those first that import what was changed. It works
on a copy of the project, and prints what no test noticed.
"""

import argparse
import ast
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import pandas  # noqa: F401 - loaded once, not by each run
import pytest
import scipy.signal  # noqa: F401
import torch  # noqa: F401

PROJECT = Path(__file__).parents[1]

SWAPPED = {"+": "-", "-": "+", "*": "/", "/": "*", "//": "*", "**": "*", "%": "*"}
SWAPPED |= {"<": ">=", ">": "<=", "<=": ">", ">=": "<", "==": "!=", "!=": "=="}
SWAPPED |= {"and": "or", "or": "and"}
OPERATOR = re.compile(r"\*\*|//|[<>=!]=|\band\b|\bor\b|[-+*/%<>]")
IN_CPP = re.compile(r"(?<= )(?:[-+*/<>]|[<>=!]=)(?= )|(?<![\w.])\d+(?:\.\d*)?(?:e-?\d+)?(?![\w.])")
LEAST_TIMEOUT = 60.0  # s


class Mutant(NamedTuple):
    """Another text between two places (in bytes) of a file."""

    file: Path
    start: int
    end: int
    text: str

    def source(self, content: bytes) -> bytes:
        """Return the file's content with the change."""
        return content[: self.start] + self.text.encode() + content[self.end :]

    def line(self, content: bytes) -> str:
        """Return where it is, and the line before and after."""
        number = content.count(b"\n", 0, self.start)
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
            case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
                yield Mutant(file, place(node)[0], place(operand)[0], "")
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
    """A copy of the project's own files, in which mutants are tried by the tests of their room."""

    def __init__(self, folder: Path, room: Path) -> None:
        self.folder = folder / PROJECT.name
        listed = subprocess.check_output(["git", "ls-files", "-z"], cwd=PROJECT, text=True)
        for name in filter(None, listed.split("\0")):
            if (source := PROJECT / name).is_file():
                (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(source, self.folder / name)
        if (shared := PROJECT.parent / "shared").exists():
            (folder / "shared").symlink_to(shared.resolve())
        tests = PROJECT / "tests" / (room.parent if room.suffix else room)
        self.tests = [str(file.relative_to(PROJECT)) for file in sorted(tests.rglob("test_*.py"))]

    def killer(self, mutant: Mutant, seconds: float) -> str:
        """Return what notices a mutant, "" if nothing does; seconds: after which it has hung."""
        file = self.folder / mutant.file
        content = file.read_bytes()
        file.write_bytes(mutant.source(content))
        try:
            return self.failure(self.nearest_first(mutant.file), seconds)
        finally:
            file.write_bytes(content)

    def nearest_first(self, changed: Path) -> list[str]:
        """Return the tests, those first that import a file, or compile a header."""
        name = changed.stem
        use = re.compile(
            rf"\.{name} import|import {name}\b" if changed.suffix == ".py" else "g\\+\\+"
        )
        return sorted(self.tests, key=lambda test: not use.search((PROJECT / test).read_text()))

    def failure(self, tests: Sequence[str], seconds: float | None = None) -> str:
        """Return which test fails first, "" if none does."""
        log = self.folder / "mutants.log"
        process = get_context("fork").Process(target=_try, args=(self.folder, tests, log))
        process.start()
        process.join(seconds)
        if process.exitcode is None:
            os.killpg(process.pid or 0, signal.SIGKILL)
            process.join()
            return f"no end within {seconds:.0f} s"
        said = log.read_text(errors="replace")
        failed = re.search(r"^(?:FAILED|ERROR) (\S+)", said, re.MULTILINE)
        return "" if process.exitcode == 0 else failed[1] if failed else said[-500:]


def _try(folder: Path, tests: Sequence[str], log: Path) -> None:
    """Run tests in a copy of the project, in a process that has loaded the libraries before."""
    os.setsid()
    os.chdir(folder)
    os.environ |= {"PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(folder))
    for name in [name for name in sys.modules if name.partition(".")[0] == "tests"]:
        del sys.modules[name]
    with log.open("w") as said:
        os.dup2(said.fileno(), 1)
        os.dup2(said.fileno(), 2)
    options = ["-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-m", "not thorough"]
    sys.exit(pytest.main([*options, *tests]))


def drawn(room: Path, count: int, seed: int) -> list[Mutant]:
    """Return mutants of a room's files, or of one file, of which all are as likely."""
    part = Path("ur5lib") / room
    kinds = ("*.py", "*.hpp")
    files = [part] if (PROJECT / part).is_file() else [
        file.relative_to(PROJECT) for kind in kinds for file in sorted((PROJECT / part).rglob(kind))
    ]  # fmt: skip
    if not files:
        sys.exit(f"{part} has no file; name a folder or file in ur5lib, e.g. topics/live/live.hpp")
    every = [mutant for file in files for mutant in mutants_of(file, (PROJECT / file).read_bytes())]
    return random.Random(seed).sample(every, min(count, len(every)))


def main() -> None:
    """Try mutants of a room, and print those that its tests do not notice."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("room", type=Path, help="folder or file in ur5lib, e.g. force")
    options.add_argument("-n", "--number", type=int, default=60)
    options.add_argument("--seed", type=int, default=random.randrange(10_000))
    given = options.parse_args()
    chosen = drawn(given.room, given.number, given.seed)
    with tempfile.TemporaryDirectory() as folder:
        copy, begin, survivors = Copy(Path(folder), given.room), time.monotonic(), []
        if failed := copy.failure(copy.tests):
            sys.exit(f"without any change, {failed} fails; mend it first")
        limit = max(LEAST_TIMEOUT, 4 * (time.monotonic() - begin))
        print(f"{len(chosen)} mutants of {given.room}, seed {given.seed}", flush=True)
        for number, mutant in enumerate(chosen, 1):
            killer = copy.killer(mutant, limit)
            line = mutant.line((PROJECT / mutant.file).read_bytes())
            print(f"{number}: {killer or 'SURVIVES'}: {line}", flush=True)
            survivors += [] if killer else [line]
    killed = len(chosen) - len(survivors)
    print(f"{killed} of {len(chosen)} killed ({killed / len(chosen):.0%}); these survive:")
    print("\n".join(survivors))


if __name__ == "__main__":
    main()
