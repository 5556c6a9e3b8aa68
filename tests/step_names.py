"""The names of files and settings that a script reads, and those that its rule declares."""

import ast
import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

KINDS = ("input", "output", "params")
METHODS = {"get", "items"}
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
    """What the rules of a script declare: all names but `code`."""

    names: Names = field(default_factory=lambda: {kind: set() for kind in KINDS})


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
    return found


@dataclass
class Reads:
    """What a script reads.

    names: as written; open: kinds of which a name is computed; whole: places where all of a kind
    goes where it cannot be followed; literals: all strings in the script and the modules that it
    imports.
    """

    names: Names = field(default_factory=lambda: {kind: set() for kind in KINDS})
    open: set[str] = field(default_factory=set)
    whole: set[str] = field(default_factory=set)
    literals: set[str] = field(default_factory=set)

    def has(self, kind: str, name: str) -> bool:
        """Whether a declared name is read; a computed one is taken to be any literal."""
        figure = name.removesuffix("_data") if kind == "output" else name  # its numbers beside it
        return figure in self.names[kind] or (kind in self.open and figure in self.literals)

    def note(self, kind: str, name: ast.expr) -> None:
        """Take up a name that is written, or computed."""
        if isinstance(name, ast.Constant):
            self.names[kind].add(str(name.value))
        else:
            self.open.add(kind)


def read_names(script: Path, root: Path) -> Reads:
    """What a script reads of the variables `input`, `output` and `params` of its functions."""
    tree = ast.parse(script.read_text())
    reads = Reads(literals={*literals(tree)})
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith(LIBRARY):
            file = root.joinpath(*str(node.module).split(".")).with_suffix(".py")
            reads.literals |= {*literals(ast.parse(file.read_text()))} if file.is_file() else set()
    functions = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    followed = {own for node in ast.walk(tree) for own in read_by(node, functions, reads)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in KINDS and node not in followed:
            reads.whole.add(f"{node.id} on in line {node.lineno}")
    return reads


def literals(tree: ast.AST) -> Iterator[str]:
    """The strings of a program."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def read_by(
    node: ast.AST, functions: dict[str, ast.FunctionDef], reads: Reads
) -> Iterator[ast.Name]:
    """Note the name that an expression reads; yield the variables of which that is known.

    A function of the script is followed where it calls the variable by the same name.
    """
    match node:
        case ast.Attribute(value=ast.Name(id=kind) as of, attr=name) if kind in KINDS:
            if name not in METHODS:
                reads.names[kind].add(name)
            yield of
        case ast.Subscript(value=ast.Name(id=kind) as of, slice=name) if kind in KINDS:
            reads.note(kind, name)
            yield of
        case ast.Call(
            func=ast.Name(id="getattr" | "hasattr"), args=[ast.Name(id=kind) as of, name, *_]
        ) if kind in KINDS:
            reads.note(kind, name)
            yield of
        case ast.Call(func=ast.Attribute(value=ast.Name(id=kind), attr="get"), args=[name, *_]):
            if kind in KINDS:
                reads.note(kind, name)
        case ast.Call(func=ast.Name(id=called), args=given) if called in functions:
            taken = [argument.arg for argument in functions[called].args.args]
            for of, name in zip(given, taken, strict=False):
                if isinstance(of, ast.Name) and of.id == name:
                    yield of


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
            for name in sorted(declared.names[kind])
            if not reads.has(kind, name)
        ]
    return told
