"""The names of files and settings that a script reads, and those that its rule declares."""

import ast
import json
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

KINDS = ("input", "output", "params")
METHODS = {"get", "keys", "values", "items"}
LIBRARY = "ur5lib"

LIST_RULES = """\
import json, sys
from pathlib import Path
from snakemake.api import SnakemakeApi
from snakemake.settings.types import ConfigSettings, ResourceSettings

study = ConfigSettings(configfiles=[Path(sys.argv[1])])
with SnakemakeApi() as api:
    workflow = api.workflow(ResourceSettings(cores=1), study, snakefile=Path("Snakefile"))._workflow
    for rule in workflow.rules:
        if "code" in rule.params.keys():
            names = {
                kind: {name: str(value) for name, value in getattr(rule, kind).items()}
                for kind in ("input", "output", "params")
            }
            print(json.dumps([rule.name, names]))
"""

Names = dict[str, set[str]]
"""The names of each kind: input, output, params."""


@dataclass
class Declared:
    """What the rules of a script declare.

    names: all but `code`; by_itself: those of files that are part of the library, which may read
    them by itself.
    """

    names: Names = field(default_factory=lambda: {kind: set() for kind in KINDS})
    by_itself: Names = field(default_factory=lambda: {kind: set() for kind in KINDS})


def declared_names(project: Path, study: Path) -> dict[str, Declared]:
    """What the rules of a study declare, by the script."""
    program = [sys.executable, "-c", LIST_RULES, str(study)]
    done = subprocess.run(program, cwd=project, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, Declared] = {}
    steps = [path.stem for path in (project / "workflow" / "scripts").glob("*.py")]
    for rule, kinds in map(json.loads, done.stdout.splitlines()):
        step = max((name for name in steps if rule.startswith(name)), key=len)
        declared = found.setdefault(step, Declared())
        for kind, values in kinds.items():
            values.pop("code", None)
            declared.names[kind] |= set(values)
        declared.by_itself["input"] |= {
            name for name, value in kinds["input"].items() if _of_library(value.split())
        }
    return found


def _of_library(files: list[str]) -> bool:
    return bool(files) and all(file.startswith(f"{LIBRARY}/") for file in files)


@dataclass
class Reads:
    """What a script reads.

    names: as written; patterns: of names put together from parts; whole: places where all of a
    kind goes where it cannot be followed; open: kinds of which a name is computed;
    literals: all strings in the script and the modules that it imports.
    """

    names: Names = field(default_factory=lambda: {kind: set() for kind in KINDS})
    patterns: list[tuple[str, str]] = field(default_factory=list)
    open: set[str] = field(default_factory=set)
    whole: set[str] = field(default_factory=set)
    literals: set[str] = field(default_factory=set)

    def has(self, kind: str, name: str) -> bool:
        """Whether a declared name is read; a computed one is taken to be any literal."""
        figure = name.removesuffix("_data") if kind == "output" else name  # its numbers beside it
        return (
            figure in self.names[kind]
            or (kind in self.open and figure in self.literals)
            or any(own == kind and re.fullmatch(text, figure) for own, text in self.patterns)
        )


def read_names(script: Path, root: Path) -> Reads:
    """What the step of a script reads, in its helper functions and in those of the library."""
    module = _Module(script, root)
    reads = Reads()
    for path in [script, *module.imported.values()]:
        reads.literals |= {
            node.value
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        }
    _Follower(reads).follow(module, module.functions[script.stem], {kind: kind for kind in KINDS})
    return reads


def differences(reads: Reads, declared: Declared) -> list[str]:
    """Return one sentence for each name that is read but not declared, or declared but not read."""
    told = [f"passes all of {place}; pass what is needed" for place in sorted(reads.whole)]
    for kind in KINDS:
        told += [
            f"reads {kind}.{name}, which its rule does not declare"
            for name in sorted(reads.names[kind] - declared.names[kind])
        ]
        told += [
            f"does not read {kind}.{name}, which its rule declares"
            for name in sorted(declared.names[kind] - declared.by_itself[kind])
            if not reads.has(kind, name)
        ]
    return told


class _Module:
    """A Python file: its functions, its classes, and the library's files that it imports from."""

    def __init__(self, path: Path, root: Path) -> None:
        self.path, self.root = path, root
        tree = ast.parse(path.read_text())
        self.functions = {n.name: n for n in tree.body if isinstance(n, ast.FunctionDef)}
        self.classes = {n.name: n for n in tree.body if isinstance(n, ast.ClassDef)}
        self.imported: dict[str, Path] = {}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(LIBRARY):
                file = root.joinpath(*str(node.module).split(".")).with_suffix(".py")
                names = {alias.asname or alias.name: file for alias in node.names}
                self.imported |= {name: file for name in names if file.is_file()}

    def find(self, name: str) -> "tuple[_Module, ast.FunctionDef] | None":
        """A function by the name under which it is called here."""
        if name in self.functions:
            return self, self.functions[name]
        if name in self.imported:
            return _Module(self.imported[name], self.root).find(name)
        return None


class _Follower:
    """Goes through functions, and those that they pass input, output or params on to."""

    def __init__(self, reads: Reads) -> None:
        self.reads = reads
        self.seen: set[tuple[Path, str, tuple[tuple[str, str], ...]]] = set()

    def follow(self, module: _Module, function: ast.FunctionDef, known: dict[str, str]) -> None:
        """Note what a function reads. known: its variables that are an input, output or params."""
        visit = (module.path, function.name, tuple(sorted(known.items())))
        if visit in self.seen:
            return
        self.seen.add(visit)
        known = known | self._renamed(function, known)
        used: set[ast.expr] = set()
        for node in ast.walk(function):
            used |= self._note(node, known)
            if isinstance(node, ast.Call):
                used |= self._pass_on(module, node, known)
        for node in ast.walk(function):
            kind = _kind(node, known)
            if kind and node not in used and isinstance(node.ctx, ast.Load):
                self.reads.whole.add(f"{kind} on in {function.name}, line {node.lineno}")

    def _renamed(self, function: ast.FunctionDef, known: dict[str, str]) -> dict[str, str]:
        """Variables that are given one of them by a plain assignment."""
        return {
            node.targets[0].id: kind
            for node in ast.walk(function)
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)
            if (kind := _kind(node.value, known))
        }

    def _note(self, node: ast.AST, known: dict[str, str]) -> set[ast.expr]:
        """Note the name that an expression reads, and return the object that it is read from."""
        match node:
            case ast.Attribute(value=of, attr=name) if kind := _kind(of, known):
                if name not in METHODS:
                    self.reads.names[kind].add(name)
                elif name != "get":
                    return set()
                return {of}
            case ast.Subscript(value=of, slice=name) if kind := _kind(of, known):
                self._name(kind, name)
                return {of}
            case ast.Call(func=ast.Name(id="getattr" | "hasattr"), args=[of, name, *_]):
                if kind := _kind(of, known):
                    self._name(kind, name)
                    return {of}
            case ast.Call(func=ast.Attribute(value=of, attr="get"), args=[name, *_]):
                if kind := _kind(of, known):
                    self._name(kind, name)
            case ast.Assign(targets=[ast.Name()], value=of) if _kind(of, known):
                return {of}
        return set()

    def _name(self, kind: str, name: ast.expr) -> None:
        if isinstance(name, ast.Constant) and isinstance(name.value, str):
            self.reads.names[kind].add(name.value)
        elif isinstance(name, ast.JoinedStr):
            literals = "|".join(map(re.escape, self.reads.literals))
            parts = [
                re.escape(str(part.value)) if isinstance(part, ast.Constant) else f"({literals})"
                for part in name.values
            ]
            self.reads.patterns.append((kind, "".join(parts)))
        else:
            self.reads.open.add(kind)

    def _pass_on(self, module: _Module, call: ast.Call, known: dict[str, str]) -> set[ast.expr]:
        """Follow a call that is given one of them; returns the arguments that were followed."""
        arguments = [*call.args, *(keyword.value for keyword in call.keywords)]
        given = {argument for argument in arguments if _kind(argument, known)}
        if not given or not isinstance(call.func, ast.Name):
            return set()
        if call.func.id in module.classes:
            return self._keep(module.classes[call.func.id], module, call, known)
        found = module.find(call.func.id)
        if found is None:
            return set()
        names = [argument.arg for argument in found[1].args.args]
        pairs = [
            *zip(names, call.args, strict=False),
            *((str(keyword.arg), keyword.value) for keyword in call.keywords),
        ]
        followed = {name: kind for name, value in pairs if (kind := _kind(value, known))}
        self.follow(*found, followed)
        return given

    def _keep(
        self, kept: ast.ClassDef, module: _Module, call: ast.Call, known: dict[str, str]
    ) -> set[ast.expr]:
        """Follow an object that keeps one of them under its own name, through all of the script."""
        given = {word.arg: word.value for word in call.keywords if _kind(word.value, known)}
        own = {name: value for name, value in given.items() if name == _kind(value, known)}
        methods = [node for node in kept.body if isinstance(node, ast.FunctionDef)]
        for function in [*methods, *module.functions.values()]:
            self.follow(module, function, {f".{name}": str(name) for name in own})
        return set(own.values())


def _kind(node: ast.AST, known: dict[str, str]) -> str | None:
    """Which of input, output and params an expression is."""
    if isinstance(node, ast.Name):
        return known.get(node.id)
    if isinstance(node, ast.Attribute):
        return known.get(f".{node.attr}")
    return None
