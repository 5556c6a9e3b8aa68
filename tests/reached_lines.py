"""Which tests reach a line: a map for each file of tests, made by coverage on demand, and kept.

What a fixture of several tests or a cached function reaches belongs to all tests of the file. Left
out are tests marked slow, and studies that Snakemake builds, in processes that coverage cannot see.
"""

import ast
import functools
import json
import re
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import coverage
import pytest

PROJECT = Path(__file__).parents[1]
KEPT = PROJECT / ".pytest_cache" / "reached_lines"
MAPPED = "not slow and not thorough and not real_time"
OUTSIDE = {"artefacts", "house", "workflow"}  # tests of what is built, and of the code as text
STEPS = "ur5lib/steps/"
SHARED, AT_IMPORT = "shared", ""


class Map(NamedTuple):
    """What the tests of a file reach.

    checksums: of the files that they use. seconds: of processor, by test that passes. lines: by
    test and file of ur5lib.
    """

    checksums: dict[str, str]
    seconds: dict[str, float]
    lines: dict[str, dict[str, list[int]]]

    def measured(self) -> list[str]:
        """Return the files of ur5lib of which a line was reached."""
        return [one for one in self.checksums if not one.startswith("tests/")]

    def holds_for(self, changed: str) -> bool:
        """Return whether the tests and a file of ur5lib are as they were."""
        alike = ("tests/", changed)
        return all(checksum(a) == b for a, b in self.checksums.items() if a.startswith(alike))

    def tests(self, file: str, lines: frozenset[int]) -> dict[str, float]:
        """Return the tests that reach one of a file's lines, with their parts of the seconds."""
        reached = {one for one, at in self.lines.items() if lines.intersection(at.get(file, ()))}
        if AT_IMPORT in reached:  # a constant: of tests that reach a line with its name
            users = {one: with_name(one, file, lines) for one in self.measured()}
            reached = {
                test
                for test, at in self.lines.items()
                if test != AT_IMPORT and any(users[one].intersection(at[one]) for one in at)
            }
        own = {test for test in self.seconds if test != SHARED and {test, SHARED} & reached}
        return {test: self.seconds[test] + self.seconds[SHARED] / len(own) for test in own}


@functools.cache
def checksum(name: str) -> str:
    """Return the checksum of a file of the project."""
    return sha256((PROJECT / name).read_bytes()).hexdigest() if (PROJECT / name).exists() else ""


@functools.cache
def imports(name: str) -> set[str]:
    """Return the files of the project that a file imports."""
    found = set[str]()
    for node in ast.walk(ast.parse((PROJECT / name).read_bytes())):
        if isinstance(node, ast.Import):
            found |= {one.name for one in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{one.name}" for one in node.names)}
    files = {f"{one.replace('.', '/')}.py" for one in found if one.startswith(("ur5", "tests"))}
    return {file for file in files if (PROJECT / file).is_file()}


@functools.cache
def with_name(user: str, file: str, lines: frozenset[int]) -> set[int]:
    """Return the lines of a file with a name that some lines of another, or of itself, assign; all
    lines without such a name, none if it does not import the other.
    """
    if user != file and file not in imports(user):
        return set()
    text, assigning = ((PROJECT / one).read_text().splitlines() for one in (user, file))
    found = re.match(r" *([\w, ]+?)(?:: .*)? = ", assigning[min(lines) - 1])
    name = re.compile(rf"\b({'|'.join(found[1].split(', '))})\b" if found else "")
    return {number for number, line in enumerate(text, start=1) if name.search(line)}


def near(changed: str) -> tuple[list[str], list[str]]:
    """Return the files of tests of a file's room, and others that import it or a step with it."""
    room = Path("tests", *Path(changed).parent.parts[1:])
    every = [file.relative_to(PROJECT) for file in sorted(PROJECT.glob("tests/*/**/test_*.py"))]
    own = [str(test) for test in every if test.is_relative_to(room)]
    others = [str(test) for test in every if test.parts[1] not in OUTSIDE]
    return own, [test for test in others if test not in own and changed in _tried(test)]


@functools.cache
def _tried(test: str) -> set[str]:
    own = imports(test)
    return own.union(*(imports(one) for one in own if one.startswith(STEPS)))


def kept(test: str) -> Path:
    """Return where the map of a file of tests is kept."""
    return KEPT / test.replace("/", ".").replace(".py", ".json")


@functools.lru_cache(200)
def _read(file: Path, written: float) -> Map:
    return Map(**json.loads(file.read_text()))


def read_map(test: str) -> Map:
    """Return the map of a file of tests, one that never holds if there is none."""
    file = kept(test)
    return _read(file, file.stat().st_mtime) if file.exists() else Map({test: ""}, {}, {})


class Recorder:
    """A plugin of pytest, which tells coverage what runs, and takes its time."""

    def __init__(self, test: str) -> None:
        self.test = test
        self.coverage = coverage.Coverage(None, config_file=False, source=["ur5lib"])
        self.coverage.set_option("run:relative_files", True)
        self.seconds: dict[str, float] = defaultdict(float)
        self.running, self.since, self.passed = [AT_IMPORT], 0.0, {SHARED}

    @contextmanager
    def context(self, name: str) -> Iterator[None]:
        """Take the lines and the time of what runs inside for those of a test."""
        self.turn([*self.running, name])
        try:
            yield
        finally:
            self.turn(self.running[:-1])

    def turn(self, running: list[str]) -> None:
        """End what ran, and begin or resume another."""
        now = time.process_time()
        self.seconds[self.running[-1]] += now - self.since
        self.running, self.since = running, now
        self.coverage.switch_context(running[-1])

    def shared(self, function: Callable) -> Callable:
        """Return a function whose lines are of all tests of the file."""

        @functools.wraps(function)
        def inside(*given: Any, **named: Any) -> Any:
            with self.context(SHARED):
                return function(*given, **named)

        return inside

    def pytest_configure(self) -> None:
        """Share what is cached, and begin."""
        from tests import warm_snakemake  # of the copy in which the tests run

        cache, begin = functools.cache, functools.cached_property.__init__

        def begin_shared(one: functools.cached_property, function: Callable) -> None:
            own = function.__module__.startswith("tests.")  # others are of a test's own object
            begin(one, self.shared(function) if own else function)

        functools.cache = lambda function: cache(self.shared(function))
        functools.cached_property.__init__ = begin_shared
        warm_snakemake.ended = lambda *_: pytest.skip("a study")
        self.coverage.start()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Take what follows for a test's."""
        with self.context(item.nodeid):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef) -> Iterator[None]:
        """Share what a fixture of several tests reaches."""
        with nullcontext() if fixturedef.scope == "function" else self.context(SHARED):
            return (yield)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note what passes."""
        if report.when == "call" and report.passed:
            self.passed.add(report.nodeid)

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        """Keep what was reached, if the tests ran."""
        self.coverage.stop()
        ran = pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED, pytest.ExitCode.NO_TESTS_COLLECTED
        if exitstatus in ran:
            KEPT.mkdir(parents=True, exist_ok=True)
            kept(self.test).write_text(json.dumps(self.map()._asdict()))

    def map(self) -> Map:
        """Return what was reached."""
        data = self.coverage.get_data()
        lines: dict[str, dict[str, list[int]]] = defaultdict(dict)
        for file in data.measured_files():
            at: dict[str, list[int]] = defaultdict(list)
            for number, contexts in data.contexts_by_lineno(file).items():
                for one in contexts:
                    at[one].append(number)
            for one, numbers in at.items():
                lines[one][file] = numbers
        return Map(
            {name: checksum(name) for name in [*_helpers(self.test), *data.measured_files()]},
            {one: self.seconds[one] for one in self.passed},
            lines,
        )


def _helpers(test: str) -> set[str]:
    """Return a file of tests, and those beside it that it uses."""
    found, new = set[str](), {test, "tests/conftest.py", str(Path(test).parent / "conftest.py")}
    while new:
        found |= new
        new = {name for one in new if checksum(one) for name in imports(one)} - found
        new = {name for name in new if name.startswith("tests/")}
    return found
