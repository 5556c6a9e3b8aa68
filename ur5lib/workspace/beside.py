"""What the project names: commands of the packages next to this one, and packages of its extras.

In a clone, installed or not, pyproject.toml itself is read. A deleted package has no commands.
"""

import tomllib
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.metadata import distribution, requires
from pkgutil import resolve_name
from shlex import join
from typing import Any, NamedTuple

from ur5lib.errors import InputError
from ur5lib.workspace.origin import DISTRIBUTION
from ur5lib.workspace.places import IN_CLONE, PACKAGE, WORKFLOW

GROUP = "ur5lib.commands"


class Command(NamedTuple):
    """A command: its name, what it runs, and the `PANEL` of its module, under which it is listed.

    `ur5` imports the module at every start: slow imports belong into the function.
    """

    name: str
    run: Callable[..., Any]
    panel: str


def commands_beside() -> Iterator[Command]:
    """Yield the commands of the packages that lie next to this one, in the order of their names."""
    for name, place in sorted(entry_points().items()):
        module, _, _ = place.partition(":")
        package, _, _ = module.partition(".")
        if (PACKAGE.parent / package / "__init__.py").is_file():
            yield Command(name, resolve_name(place), resolve_name(f"{module}:PANEL"))


def entry_points() -> dict[str, str]:
    """Return the place of each command, `module:function`, by its name."""
    if IN_CLONE:
        return dict(_project()["entry-points"][GROUP])
    points = distribution(DISTRIBUTION).entry_points.select(group=GROUP)
    return {point.name: point.value for point in points}


def extra(name: str) -> list[str]:
    """Return the packages of an extra, each with its versions, as pip takes them.

    Of an installed wheel, too, these are their names: no index has the package itself.
    """
    if IN_CLONE:
        return list(_project()["optional-dependencies"][name])
    pairs = (line.split(";") for line in requires(DISTRIBUTION) or [])
    return [package.strip() for package, *of in pairs if of == [f" extra == '{name}'"]]


def of_extra(name: str, module: str, purpose: str) -> Any:
    """Return a module that an extra installs; purpose: for the message. Raises InputError where it
    is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise InputError(
            f"{purpose} needs the extra `{name}`; install it: pip install {join(extra(name))}"
        ) from error


def _project() -> dict[str, Any]:
    text = (WORKFLOW / "pyproject.toml").read_text(encoding="utf-8")
    return dict(tomllib.loads(text)["project"])
