"""What of a Python file can change a result: its syntax, without comments, docstrings of modules
and functions, and imports for type checkers alone.

Docstrings of classes count, since tables and settings are described by them.
"""

import ast
import contextlib
import json
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from ur5lib.errors import InputError

KEPT = Path(".snakemake", "syntax.json")  # by content: to parse all of the library takes a second
OWN = Path(__file__).read_bytes()  # another version of this module finds other checksums


class Syntax(NamedTuple):
    """What of a Python file can change a result.

    imports: the names of the modules that it imports, and of what it imports from them.
    """

    checksum: str
    imports: list[str]


FOUND: dict[str, Syntax] = {}  # by this process


@cache
def syntax(path: Path) -> Syntax:
    """Return what of a Python file can change a result; all of its text where it has no syntax."""
    content = path.read_bytes()
    key = sha256(OWN + content).hexdigest()
    return FOUND.setdefault(key, _before().get(key) or _syntax_of(content))


def form_of(part: ast.AST) -> str:
    """Return what of a part of a syntax tree can change a result, as a text."""
    reading = _Reading()
    reading.read(part)
    return "".join(reading.form)


def keep_for_the_next_process() -> None:
    """Write what this process found to the working folder, if it had to parse a file."""
    if FOUND.keys() - _before().keys():
        from ur5lib.tables import write_text  # slow to import

        with contextlib.suppress(InputError):  # the next one parses anew
            write_text(json.dumps(FOUND), KEPT)


@cache
def _before() -> dict[str, Syntax]:
    """Return what an earlier process kept, none if that cannot be read."""
    with contextlib.suppress(OSError, ValueError):
        return {key: Syntax(*kept) for key, kept in json.loads(KEPT.read_text()).items()}
    return {}


def _syntax_of(content: bytes) -> Syntax:
    try:
        tree = ast.parse(content)
    except (SyntaxError, ValueError):  # such as a template in a user's package
        return Syntax(sha256(content).hexdigest(), [])
    reading = _Reading()
    reading.read(tree)
    return Syntax(sha256("".join(reading.form).encode()).hexdigest(), sorted(reading.imports))


class _Reading:
    """What was read of a syntax tree.

    form: names and values of its nodes, without their place in the text. Fields without content
    are left out: newer versions of Python add such fields, as `ast.unparse` writes other quotes,
    and each would make a study run again.
    """

    def __init__(self) -> None:
        self.form: list[str] = []
        self.imports: set[str] = set()

    def read(self, part: object) -> None:
        if isinstance(part, list):
            self.form.append("[")
            for own in part:
                self.read(own)
            self.form.append("]")
        elif isinstance(part, ast.If) and ast.unparse(part.test) == "TYPE_CHECKING":
            self.read(part.orelse)
        elif isinstance(part, ast.AST):
            self._read_fields(part)
        else:
            self.form.append(repr(part))

    def _read_fields(self, node: ast.AST) -> None:
        self.imports |= _imports(node)
        self.form.append(f"{type(node).__name__}(")
        for name in node._fields:
            value = _without_docstring(node) if name == "body" else getattr(node, name, None)
            if value is not None and value != [] and name != "ctx":  # which the place tells
                self.form.append(name)
                self.read(value)
        self.form.append(")")


def _without_docstring(node: ast.AST) -> object:
    """Return the body of a node, that of a module or a function without its docstring."""
    worded = ast.Module | ast.FunctionDef | ast.AsyncFunctionDef
    if isinstance(node, worded) and ast.get_docstring(node, clean=False) is not None:
        return node.body[1:]
    return getattr(node, "body", None)


def _imports(node: ast.AST) -> set[str]:
    if isinstance(node, ast.Import):
        return {own.name for own in node.names}
    if isinstance(node, ast.ImportFrom):
        return {str(node.module), *(f"{node.module}.{own.name}" for own in node.names)}
    return set()
