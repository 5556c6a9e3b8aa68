"""Base class of data that people write by hand."""

import stat
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml
from pydantic import BaseModel, ConfigDict

from ur5lib.errors import InputError

MOST_VALUES = 100_000  # in a file; a study of a thousand recordings has a third of them
DEEPEST = 50  # levels of lists and mappings; a study has 8
FAST_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml's, if installed
FAST_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
SPECIAL = {
    stat.S_ISFIFO: "a named pipe",
    stat.S_ISSOCK: "a socket",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
}


class Strict(BaseModel):
    """A part of a hand-written file: unknown keys are errors, values stay as read."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def existing_file(path: str) -> str:
    """Return the path. Raises ValueError if there is no such file."""
    if not Path(path).is_file():
        kind = _special_kind(Path(path))
        raise ValueError(f"a file, not {kind}" if kind else "an existing file")
    return path


def expect_file(path: Path) -> None:
    """Raise InputError for a pipe, socket or device, which may block forever."""
    if kind := _special_kind(path):
        raise InputError(
            f"{path} is {kind}, which cannot be read as a file; save its content in a file and "
            "name that one"
        )


def _special_kind(path: Path) -> str | None:
    """Return the kind of a path that is neither file nor folder, None for others."""
    try:
        mode = path.stat().st_mode
    except OSError:
        return None
    return next((kind for is_kind, kind in SPECIAL.items() if is_kind(mode)), None)


def read_yaml(path: Path) -> Any:
    """Return the content of a YAML file as plain data.

    Raises OSError or UnicodeDecodeError when it cannot be read, yaml.YAMLError when it is not YAML,
    InputError when it is not a file, or stands for too many values.
    """
    expect_file(path)
    text, source = path.read_text(encoding="utf-8"), str(path)
    try:
        _expect_few_levels(text, source)  # before libyaml, which crashes on a deep nest
        return _plain_data(FAST_LOADER(text), source)
    except yaml.YAMLError:  # for a message that shows the line
        return _plain_data(yaml.SafeLoader(text), source)


def _expect_few_levels(text: str, source: str) -> None:
    """Raise InputError where a text of YAML is nested too deep."""
    level = 0
    for event in yaml.parse(text, FAST_LOADER):
        level += isinstance(event, yaml.CollectionStartEvent)
        level -= isinstance(event, yaml.CollectionEndEvent)
        if level > DEEPEST:
            raise _too_deep(source)


def _plain_data(loader: Any, source: str) -> Any:
    """Return the content that a loader of YAML reads, as plain data."""
    try:
        node = loader.get_single_node()
        expect_few_values(node, source)
        return None if node is None else loader.construct_document(node)
    except RecursionError as error:
        raise _too_deep(source) from error
    finally:
        loader.dispose()


def expect_few_values(data: Any, source: str) -> None:
    """Raise InputError where data are nested too deep, or huge through repeated aliases.

    data: plain data, or the nodes of a YAML file; source: its name, for the message. Each alias
    (`*name`) stands for all that it names: nine lines can stand for a thousand million values.
    """
    if _measure(data, 0, {}, source)[0] > MOST_VALUES:
        raise InputError(
            f"{source} stands for more than {MOST_VALUES:,} values, its aliases (`*name`) written "
            "out; use fewer of them"
        )


def _measure(
    data: Any, level: int, known: dict[int, tuple[int, int]], source: str
) -> tuple[int, int]:
    """Return the count of values and of levels below; known: those of parts seen before, by id."""
    if level + known.get(id(data), (1, 0))[1] > DEEPEST:
        raise _too_deep(source)
    if id(data) not in known:
        below = [_measure(part, level + 1, known, source) for part in _parts(data)]
        count = 1 + sum(count for count, _ in below)
        known[id(data)] = count, 1 + max((depth for _, depth in below), default=-1)
    return known[id(data)]


def _parts(data: Any) -> Sequence[Any]:
    """Return the direct parts of a list, a mapping or a node of YAML."""
    if isinstance(data, yaml.MappingNode):
        return [part for pair in data.value for part in pair]
    if isinstance(data, dict):
        return [*data, *data.values()]
    if isinstance(data, yaml.SequenceNode):
        return list(data.value)
    return data if isinstance(data, list | tuple) else ()


def _too_deep(source: str) -> InputError:
    return InputError(
        f"{source} nests lists and mappings more than {DEEPEST} levels deep; flatten it"
    )
