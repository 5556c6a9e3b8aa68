"""What the fast tests would not notice: one token at a time is changed, and they are asked.

    python tests/mutants.py --seed 0 --count 60
    python tests/mutants.py --module ur5lib/force/gate.py --count 20

Nothing on the disk changes: a changed module is compiled in a process of its own, which runs the
tests that call what was changed. Which tests those are, and how long each takes, is measured once
and kept in .pytest_cache (again for a test file that was edited). What takes more than two
minutes of the processor's time counts as killed, by the time limit. A mutant that survives needs a
test, or a line in tests/equivalent_mutants.yaml with the reason why no test can tell it.
"""

import argparse
import ast
import importlib
import importlib.util
import json
import math
import os
import random
import re
import resource
import sys
import time
from collections.abc import Iterator
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml

ROOMS = [
    f"ur5lib/{room}/*.py"
    for room in ("force", "identification", "signals", "recordings", "timeseries")
]
TESTS = ["tests/library/test_*.py", "tests/scripts/test_*.py"]
FAST, BUDGET, LIMIT = 6.0, 20.0, 120  # s: of a test, of all of a mutant, of CPU until its end
KNOWN = Path("tests/equivalent_mutants.yaml")
MEASURED = Path(".pytest_cache/mutants.json")
QUIET = ["-q", "-x", "-p", "no:cacheprovider", "-p", "no:xdist", "-o", "addopts=", "-W", "ignore"]
FORK = get_context("fork")

OPERATORS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.Mod: ast.FloorDiv, ast.FloorDiv: ast.Div, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
PAIRS = "min max|minimum maximum|argmin argmax|floor ceil|sin cos|any all|mean sum|zeros ones"
NAMES = {a: b for pair in PAIRS.split("|") for a, b in (pair.split(), pair.split()[::-1])}


class Mutant(NamedTuple):
    """A module with one change; function: the qualified name of the one that holds it."""

    module: str
    number: int
    function: str
    before: str
    after: str
    line: str
    becomes: str
    source: str


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """What may stand instead of a node."""
    match node:
        case ast.BinOp(op=ast.MatMult()):
            yield ast.BinOp(node.right, node.op, node.left)
        case ast.BinOp() if type(node.op) in OPERATORS:
            yield ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right)
        case ast.AugAssign() if type(node.op) in OPERATORS:
            yield ast.AugAssign(node.target, OPERATORS[type(node.op)](), node.value)
        case ast.Compare():
            first, *rest = node.ops
            yield ast.Compare(node.left, [OPERATORS[type(first)](), *rest], node.comparators)
        case ast.BoolOp():
            yield ast.BoolOp(OPERATORS[type(node.op)](), node.values)
        case ast.UnaryOp():
            yield node.operand
        case ast.IfExp():
            yield ast.IfExp(ast.UnaryOp(ast.Not(), node.test), node.body, node.orelse)
        case ast.Constant(value=bool()):
            yield ast.Constant(not node.value)
        case ast.Constant(value=int()):
            yield ast.Constant(node.value + 1 if abs(node.value) < 10 else 2 * node.value)
        case ast.Constant(value=float()):
            yield ast.Constant(2 * node.value or 1.0)
        case ast.Subscript(slice=ast.Tuple(elts=[first, second, *rest])):
            yield ast.Subscript(node.value, ast.Tuple([second, first, *rest]), node.ctx)
        case ast.Subscript(slice=ast.Slice(lower, upper, step)) if lower or upper:
            for left in [(None, upper, step)] * bool(lower) + [(lower, None, step)] * bool(upper):
                yield ast.Subscript(node.value, ast.Slice(*left), node.ctx)
        case ast.Name(id=name) if name in NAMES:
            yield ast.Name(NAMES[name])
        case ast.Attribute(attr=name) if name in NAMES:
            yield ast.Attribute(node.value, NAMES[name])


def code(node: ast.AST, function: str = "") -> Iterator[tuple[ast.AST, str]]:
    """All nodes that are run, with the function they are in: no types, texts and decorators, and
    no assertions, of which `strict=True` of a zip is one."""
    if isinstance(node, ast.JoinedStr | ast.Raise | ast.Assert):
        return
    if isinstance(node, ast.keyword) and node.arg == "strict":
        return
    if isinstance(node, ast.ClassDef):
        function = f"{node.name}."
    elif isinstance(node, ast.FunctionDef) and function[-1:] in ("", "."):  # not within another
        function += node.name
    yield node, function.rstrip(".")
    typed = ("annotation", "returns", "decorator_list", "bases")
    for field, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and field not in typed:
                yield from code(child, function)


def mutants(path: Path) -> Iterator[Mutant]:
    """All of a module."""
    source = path.read_bytes()
    lines = source.splitlines(keepends=True)
    begins = [0, *(sum(map(len, lines[:n])) for n in range(1, len(lines) + 1))]
    for node, function in code(ast.parse(source)):
        for changed in changes(node):
            start = begins[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
            end = begins[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
            text = ast.unparse(ast.fix_missing_locations(changed))
            if text == ast.unparse(node):  # [j, j] -> [j, j]
                continue
            plain = isinstance(node, ast.AugAssign | ast.Constant | ast.Name | ast.Subscript)
            before, after = source[:start].decode(), source[end:].decode()
            new = before + (text if plain else f"({text})") + after
            try:
                compile(new, path, "exec")
            except SyntaxError:
                continue
            number = node.lineno  # type: ignore[attr-defined]
            line, becomes = (s.splitlines()[number - 1].strip() for s in (source.decode(), new))
            old = " ".join(source[start:end].decode().split())
            yield Mutant(str(path), number, function, old, text, line, becomes, new)


class Watch:
    """Which functions each test calls, how long it takes, and which test fails first."""

    def __init__(self) -> None:
        self.called, self.failed = set[str](), ""
        self.tests: dict[str, Any] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self.called.clear()
        begin = time.process_time()
        result = yield
        seconds = round(time.process_time() - begin, 3)
        self.tests[item.nodeid] = {"seconds": seconds, "calls": sorted(self.called)}
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.failed = self.failed or (report.nodeid if report.failed else "")


def noting_calls(path: Path) -> ast.Module:
    """A module whose functions note their names when they are called."""
    tree = ast.parse(path.read_bytes())
    for node, function in code(tree):
        if isinstance(node, ast.FunctionDef):
            note = ast.parse(f"_note({f'{path}:{function}'!r})").body
            node.body[bool(ast.get_docstring(node)) : 0] = note
    return ast.fix_missing_locations(tree)


class Changed(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports modules from sources that are not on the disk."""

    def __init__(self, sources: dict[str, Any], note: Any) -> None:
        self.sources, self.note = sources, note

    def find_spec(self, name: str, *_: object) -> Any:
        path = name.replace(".", "/") + ".py"
        if path in self.sources:
            return importlib.util.spec_from_loader(name, self, origin=path)
        return None

    def exec_module(self, module: Any) -> None:
        path = module.__spec__.origin
        module.__file__, module._note = os.path.abspath(path), self.note
        exec(compile(self.sources[path], module.__file__, "exec"), module.__dict__)


def pytested(arguments: list[str], sources: dict[str, Any], limit: int, answer: Any) -> None:
    """In a process of its own: run some tests, and send what came of it."""
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    watch = Watch()
    sys.meta_path.insert(0, Changed(sources, watch.called.add))
    status = pytest.main([*QUIET, *arguments], plugins=[watch])
    answer.send((int(status), watch.failed or f"exit status {int(status)}", watch.tests))


def asked(arguments: list[str], sources: dict[str, Any], limit: int) -> Any:
    """Exit status, first failed test, and all tests; None where the time ran out or it died."""
    ours, theirs = FORK.Pipe(duplex=False)
    process = FORK.Process(target=pytested, args=(arguments, sources, limit, theirs))
    process.start()
    theirs.close()
    try:
        return ours.recv() if ours.poll(10 * limit) else None
    except EOFError:
        return None
    finally:
        process.kill()
        process.join()


def measured(tests: list[Path], modules: list[Path]) -> dict[str, Any]:
    """Seconds and calls of all tests, by file; measured anew for files that were edited."""
    kept = json.loads(MEASURED.read_text()) if MEASURED.exists() else {}
    noting = {str(each): noting_calls(each) for each in modules}
    for path in tests:
        edited = path.stat().st_mtime
        if kept.get(str(path), {}).get("edited") == edited:
            continue
        print(f"measuring {path}", file=sys.stderr)
        status, _, ran = asked([str(path)], noting, 600) or (1, "", {})
        if status:
            print(f"{path} fails or takes too long: left out", file=sys.stderr)
        kept[str(path)] = {"edited": edited, "tests": {} if status else ran}
        MEASURED.parent.mkdir(exist_ok=True)
        MEASURED.write_text(json.dumps(kept))
    return {str(path): kept[str(path)]["tests"] for path in tests}


def chosen(mutant: Mutant, files: dict[str, Any]) -> list[str]:
    """Fast tests of a mutant, the likeliest and quickest first: those that call what it changes
    (or, of what is no function, those of a file that imports its module), then those that call its
    module, then others of their files, which may share what one of them prepared."""
    own, module = f"{mutant.module}:{mutant.function}", f"{mutant.module}:"
    called = any(own in test["calls"] for tests in files.values() for test in tests.values())
    package, _, name = mutant.module.removesuffix(".py").replace("/", ".").rpartition(".")
    of_package = rf"from {package} import (?:\([^)]*|.*)\b{name}\b"
    imported = rf"\b{package}\.{name}\b|{of_package}|from {name} import"
    ranked = []
    for file, tests in files.items():
        if not called and re.search(imported, Path(file).read_text()):
            far = dict.fromkeys(tests, 1)
        else:
            far = {name: _far(test["calls"], own, module) for name, test in tests.items()}
        if min(far.values(), default=3) < 3:
            ranked += [(far[n], t["seconds"], n) for n, t in tests.items()]
    names, spent = [], 0.0
    for _, seconds, name in sorted(ranked):
        if not names or (seconds <= FAST and spent + seconds <= BUDGET):
            names.append(name)
            spent += seconds
    return names


def _far(calls: list[str], function: str, module: str) -> int:
    if function in calls:
        return 1
    return 2 if any(call.startswith(module) for call in calls) else 3


def interval(killed: int, count: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    z, n = 1.96, max(count, 1)
    share = killed / n
    middle, half = share + z**2 / 2 / n, z * math.sqrt(share * (1 - share) / n + (z / 2 / n) ** 2)
    return (middle - half) / (1 + z**2 / n), (middle + half) / (1 + z**2 / n)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--count", type=int, default=60, help="of mutants; 0: all")
    parser.add_argument("--module", nargs="+", default=ROOMS, help="paths or patterns")
    parser.add_argument("--tests", nargs="+", default=TESTS)
    options = parser.parse_args()
    sys.path.insert(0, os.getcwd())
    sys.dont_write_bytecode = True
    os.environ["OMP_NUM_THREADS"] = "1"  # threads that wait for one another spend its time, too
    modules = sorted(path for pattern in options.module for path in Path().glob(pattern))
    tests = sorted(path for pattern in options.tests for path in Path().glob(pattern))
    everything = sorted({p for pattern in [*ROOMS, *options.module] for p in Path().glob(pattern)})
    users = [".".join(path.parent.parts) for path in everything] + ["ur5lib.pipeline"]
    tests = [
        path
        for path in tests
        if not path.stem.endswith("_of_real_arms")
        and any(user in path.read_text() for user in users)
    ]
    listed = yaml.safe_load(KNOWN.read_text()) if KNOWN.exists() else []
    known = {(one["line"], one["becomes"]) for one in listed}
    for package in {path.parts[0] for path in everything}:  # what they import is loaded once
        for path in Path(package).rglob("*.py"):
            importlib.import_module(".".join(path.with_suffix("").parts))
        for name in [name for name in sys.modules if name.split(".")[0] == package]:
            del sys.modules[name]
    files = measured(tests, everything)
    sample = [mutant for path in modules for mutant in mutants(path)]
    if options.count:
        sample = random.Random(options.seed).sample(sample, min(options.count, len(sample)))
    counts = {"killed": 0, "survived": 0, "equivalent": 0}
    for mutant in sorted(sample):
        verdict, by = "equivalent", ""
        if (mutant.line, mutant.becomes) not in known:
            names = chosen(mutant, files)
            answer = asked(names, {mutant.module: mutant.source}, LIMIT) if names else (0, "", {})
            status, failed, _ = answer or (1, "time limit", {})
            verdict = "killed" if status else "survived"
            by = failed if status else f"{len(names)} tests"
        counts[verdict] += 1
        place = f"{mutant.module}:{mutant.number}"
        print(f"{verdict:10} {place}  {mutant.before} -> {mutant.after}  [{by}]", flush=True)
        if verdict == "survived":
            print(f"           - {mutant.line}\n           + {mutant.becomes}", flush=True)
    judged = counts["killed"] + counts["survived"]
    low, high = interval(counts["killed"], judged)
    print(f"seed {options.seed}:", ", ".join(f"{n} {verdict}" for verdict, n in counts.items()))
    print(f"{counts['killed'] / max(judged, 1):.0%} killed, 95 % interval {low:.0%} to {high:.0%}")


if __name__ == "__main__":
    main()
