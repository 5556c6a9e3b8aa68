"""A workspace's own friction terms, force estimators and formats (docs/extensions.md).

They are the user's own code: files of the folder `extensions` in the workspace, and modules of
installed packages that name them as entry points. No study can name another.
"""

import os
import sys
import traceback
from collections.abc import Callable, Container, Iterator
from functools import cache, partial
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from ur5lib.errors import InputError
from ur5lib.workspace.places import PACKAGE

FOLDER = Path("extensions")  # in the workspace, which is the working folder
ENTRY_POINT_GROUP = "ur5lib."  # prefix of ur5lib.friction, ...
PAGE = "docs/extensions.md shows how"
USE_VARIABLE = "UR5_EXTENSIONS"  # a command of `ur5` sets this variable to NAMED or LEFT_OUT
NAMED = "named"  # each is named on stderr before it runs
LEFT_OUT = "left out"


class Kind(NamedTuple):
    """A kind of extension: its name in the extension's module, and the module of ur5lib that loads
    such extensions when it is imported.
    """

    name: str
    taken_up_by: str

    def file(self) -> Path:
        """Return the file of the module that loads the extensions."""
        return PACKAGE.parent.joinpath(*self.taken_up_by.split(".")).with_suffix(".py")


KINDS = {
    "friction": Kind("TERMS", "ur5lib.robots.friction"),
    "estimators": Kind("ESTIMATORS", "ur5lib.force.estimators"),
    "formats": Kind("FORMATS", "ur5lib.recordings.own_formats"),
}


class Addition(NamedTuple):
    """One entry that an extension adds: its name and value; source: the file or module that states
    it, for messages.
    """

    source: str
    name: str
    value: Any


def additions(kind: str) -> Iterator[Addition]:
    """Yield the workspace's additions of a kind of KINDS.

    Raises InputError where an extension cannot be loaded, or two of them state the same name.
    """
    sources: dict[str, str] = {}
    for source, module in extensions(kind).items():
        entries = getattr(module, KINDS[kind].name, None)
        if not isinstance(entries, dict) or not all(isinstance(name, str) for name in entries):
            raise InputError(f"{source} needs a dict {KINDS[kind].name} by name; {PAGE}")
        for name, value in entries.items():
            if sources.setdefault(name, source) != source:
                other = sources[name]
                raise InputError(f"{source}: {name!r} is stated in {other}, too; rename one")
            yield Addition(source, name, value)


@cache
def extensions(kind: str) -> dict[str, ModuleType]:
    """Return the modules with extensions of a kind of KINDS, by the file or the entry point that
    they come from.

    Raises InputError where one cannot be loaded.
    """
    return {source: _module(source, load) for source, load in _loaders(kind).items()}


def take_up_all() -> None:
    """Load all extensions. Raises InputError where one cannot be loaded or used."""
    for name, kind in KINDS.items():
        if _loaders(name):
            import_module(kind.taken_up_by)


def source_files(modules: Container[Path]) -> list[Path]:
    """Return the files of all extensions that these modules of ur5lib load.

    A module in a package counts with all files of the package's folder.
    """
    files = []
    for name in (name for name, kind in KINDS.items() if kind.file() in modules):
        for module in extensions(name).values():
            file = Path(module.__file__ or "")
            files += sorted(file.parent.rglob("*.py")) if module.__package__ else [file]
    return files


def _loaders(kind: str) -> dict[str, Callable[[], Any]]:
    """Return the functions that load the extensions of a kind, by their file or entry point."""
    if os.environ.get(USE_VARIABLE) == LEFT_OUT:
        return {}
    file = FOLDER / f"{kind}.py"
    files = {str(file): partial(_module_in, file)} if file.is_file() else {}
    points = _entry_points().select(group=ENTRY_POINT_GROUP + kind)
    return files | {point.value: point.load for point in points}


@cache
def _entry_points() -> Any:
    """Return those of all installed packages, whose files are read once."""
    return entry_points()


def _module_in(file: Path) -> ModuleType:
    """Run a file and return its module, with a unique name, which its classes need."""
    spec = spec_from_file_location(f"ur5lib_extension_{file.stem}", file)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def _module(source: str, load: Callable[[], Any]) -> ModuleType:
    """Return the module of an extension. Raises InputError where there is none."""
    if os.environ.get(USE_VARIABLE) == NAMED:
        print(f"ur5: runs {source}; `ur5 --no-extensions` leaves it out", file=sys.stderr)
    try:
        module = load()
    except Exception as error:  # whatever a user's code does
        raise failed(source, error) from error
    if not isinstance(module, ModuleType):
        raise InputError(f"the entry point {source} names no module; {PAGE}")
    return module


def failed(source: str, error: Exception) -> InputError:
    """Return the error for an extension whose own code raised an exception."""
    cause = traceback.format_exception_only(error)[-1].strip()
    return InputError(f"{source}{_line_of(source, error)} fails ({cause}); correct it")


def _line_of(source: str, error: Exception) -> str:
    """Return the failing line of a file for a message, "" if it is unknown."""
    if isinstance(error, SyntaxError):
        return f", line {error.lineno}"
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if Path(frame.filename) == Path(source).resolve()]
    return f", line {lines[-1]}" if lines else ""
