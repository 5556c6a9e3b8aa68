"""What a step declares, read in the source of its module: a plan of jobs imports no step.

`python -m ur5lib.jobs.declared estimate_forces` prints what a step reads, and which step writes it.
"""

import ast
import sys
from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

from ur5lib.errors import InputError
from ur5lib.jobs.code import all_steps, module_of
from ur5lib.workspace.places import PACKAGE

Fields = Mapping[str, list[str]]  # of each record of which a module states what is read


class Declared(NamedTuple):
    """A step as its module declares it by `ur5lib.records.step`.

    reads: by parameter, or field of an `Opened`, the name of what it receives; several: those that
    are of several recordings; writes: file by output.
    """

    name: str
    of: str
    recordings: str
    reads: dict[str, str]
    several: frozenset[str]
    writes: dict[str, str]


def every() -> list[Declared]:
    """Return the steps that declare their files, by name; the others have rules of their own.

    Raises InputError where a step uses a field that it does not declare.
    """
    return [own for step in all_steps() if (own := declared(step))]


@cache
def declared(step: str) -> Declared | None:
    """Return a step as it is declared, None for one with a rule of its own."""
    tree = ast.parse(module_of(step).read_bytes())
    fields = _records(tree)
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    for function in functions:
        _expect_declared(step, function, fields)
    own = next(node for node in functions if node.name == step)
    call = next((one for one in own.decorator_list if isinstance(one, ast.Call)), None)
    if call is None:
        return None
    of, writes = map(ast.literal_eval, call.args)
    stated = {str(word.arg): ast.literal_eval(word.value) for word in call.keywords}
    recordings = stated.pop("recordings", "")
    several = dict[str, bool]()
    for name, kind in _parameters(own).items():
        for read in fields.get(_record(kind, fields), [name]):
            several.setdefault(read, kind.startswith("Mapping"))
    return Declared(
        step,
        of,
        recordings,
        {name: stated.get(name, name) for name in several},
        frozenset(name for name, is_so in several.items() if is_so),
        dict(map(_output, writes.split())),
    )


@cache
def written_by() -> dict[str, tuple[Declared, str]]:
    """Return the step and the file of each output that steps read, by its name."""
    steps = [step for step in every() if not is_figure(step)]
    return {output: (step, file) for step in steps for output, file in step.writes.items()}


def is_figure(step: Declared) -> bool:
    """Return whether a step draws figures, which no step reads."""
    return any(file.endswith(".svg") for file in step.writes.values())


def _output(stated: str) -> tuple[str, str]:
    name, _, file = stated.rpartition("=")
    return name or file.partition(".")[0], file


def _parameters(function: ast.FunctionDef) -> dict[str, str]:
    """Return the types of a function's parameters, as text, by name."""
    return {own.arg: ast.unparse(own.annotation) for own in function.args.args if own.annotation}


def _record(kind: str, fields: Fields) -> str:
    """Return the record that a type names, alone or as one of several, "" if none."""
    name = kind.removeprefix("Mapping[str, ").removesuffix("]")
    return name if name in fields else ""


def _records(tree: ast.Module) -> dict[str, list[str]]:
    """Return the fields of each `Opened` of a module, and of those that its classes extend."""
    found = {"Opened": list[str]()}
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    bases = {ast.unparse(base) for node in classes for base in node.bases} - {"Opened"}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and bases & {own.name for own in node.names}:
            path = PACKAGE.parent.joinpath(*str(node.module).split(".")).with_suffix(".py")
            found |= _records(ast.parse(path.read_bytes())) if path.is_file() else {}
    for own in classes:
        if base := next((name for base in own.bases if (name := ast.unparse(base)) in found), ""):
            rows = [row for row in own.body if isinstance(row, ast.AnnAssign)]
            found[own.name] = [*found[base], *(ast.unparse(row.target) for row in rows)]
    return found


def _expect_declared(step: str, function: ast.FunctionDef, fields: Fields) -> None:
    """Raise InputError if a function uses a field that its record does not have.

    One of several `recordings` is called `recording`.
    """
    held = dict[str, str]()
    for name, kind in _parameters(function).items():
        held[name if kind in fields else name.removesuffix("s")] = _record(kind, fields)
    for node in ast.walk(function):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            record = held.get(node.value.id, "")
            if record and node.attr not in fields[record]:
                raise InputError(
                    f"{step} uses `{node.attr}` of a {node.value.id}, which it does not declare; "
                    f"add it to `{record}` in {module_of(step).name}"
                )


if __name__ == "__main__":
    if asked := declared(sys.argv[1]):
        for parameter, received in asked.reads.items():
            writer = written_by().get(received)
            of_study = f"`{received}` of ur5lib/study/given.py"
            print(f"{parameter}: {f'{writer[1]}, by {writer[0].name}' if writer else of_study}")
