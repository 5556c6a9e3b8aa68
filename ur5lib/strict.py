"""Base class of data that people write by hand."""

import re
import stat
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import AfterValidator, BaseModel, ConfigDict

from ur5lib.errors import InputError

MOST_BYTES = 5_000_000  # of a file; a study of a thousand recordings has a twentieth of them
MOST_VALUES = 100_000  # in a file; a study of a thousand recordings has a third of them
MAX_LEVELS = 50  # levels of lists and mappings; a study has 8
MAX_NUMBER_LENGTH = 100  # characters
MAX_PATH_BYTES, MAX_PART_BYTES = 1000, 255  # bytes of a path, and of a name in it
SNAKEMAKE_PLACEHOLDER = re.compile(r"\{\s*[.\w]+\s*[,}]|<[a-z]\w*>")  # replaced in a path
MERGE_TAG = "tag:yaml.org,2002:merge"  # of the key <<, which may stand several times
FAST_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # libyaml's, if installed
FAST_DUMPER: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
SPECIAL_FILE_KINDS = {
    stat.S_ISFIFO: "a named pipe",
    stat.S_ISSOCK: "a socket",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
}


class Strict(BaseModel):
    """A part of a hand-written file: unknown keys are errors, values stay as read."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def usable_path(path: str) -> str:
    """Return the path. Raises ValueError for one that no file has, or that Snakemake changes."""
    longest = max(len(part.encode(errors="replace")) for part in path.split("/"))
    if "\0" in path or longest > MAX_PART_BYTES or len(path) > MAX_PATH_BYTES:
        raise ValueError(
            f"a path of at most {MAX_PATH_BYTES:,} bytes, each name in it at most {MAX_PART_BYTES}"
        )
    if SNAKEMAKE_PLACEHOLDER.search(path):
        raise ValueError(
            "a path without a word in {} or <>, which Snakemake would replace; rename the file or "
            "folder"
        )
    return path


PathText = Annotated[str, AfterValidator(usable_path)]


def existing_file(path: str) -> str:
    """Return the path. Raises ValueError if there is no such file."""
    if not Path(usable_path(path)).is_file():
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
    return next((kind for is_kind, kind in SPECIAL_FILE_KINDS.items() if is_kind(mode)), None)


def read_yaml(path: Path) -> Any:
    """Return the content of a YAML file as plain data.

    Raises OSError or UnicodeDecodeError when it cannot be read, yaml.YAMLError when it is not YAML,
    InputError when it is not a file, has a key twice, holds a number that is none, or is too large.
    """
    expect_file(path)
    if path.stat().st_size > MOST_BYTES:
        raise InputError(f"{path} has more than {MOST_BYTES:,} bytes; divide it")
    text, source = path.read_text(encoding="utf-8"), str(path)
    try:
        _expect_few_levels(text, source)  # before libyaml, which crashes on a deep nest
        return _plain_data(FAST_LOADER(text), source)
    except yaml.YAMLError:  # for a message that shows the line
        return _plain_data(yaml.SafeLoader(text), source)


def _expect_few_levels(text: str, source: str) -> None:
    """Raise InputError where a text of YAML is nested too deep, or has too many values."""
    level = 0
    for count, event in enumerate(yaml.parse(text, FAST_LOADER)):
        level += isinstance(event, yaml.CollectionStartEvent)
        level -= isinstance(event, yaml.CollectionEndEvent)
        if level > MAX_LEVELS:
            raise _too_deep(source)
        if count > 3 * MOST_VALUES:  # a list has an event for its beginning, and one for its end
            raise _too_many(source)


def _plain_data(loader: Any, source: str) -> Any:
    """Return the content that a loader of YAML reads, as plain data."""
    try:
        if (node := loader.get_single_node()) is None:
            return None
        expect_few_values(node, source)
        for part in _nodes(node):
            if isinstance(part, yaml.MappingNode):
                _expect_keys_once(part, source)
            elif isinstance(part, yaml.ScalarNode) and part.tag != MERGE_TAG:
                _expect_value(part, loader, source)
        return loader.construct_document(node)
    except RecursionError as error:
        raise _too_deep(source) from error
    finally:
        loader.dispose()


def _nodes(node: yaml.Node) -> Iterator[yaml.Node]:
    """Yield a node of YAML and all below it, each once."""
    waiting, met = [node], {id(node)}
    while waiting:
        yield (node := waiting.pop())
        for part in _parts(node):
            if id(part) not in met:
                met.add(id(part))
                waiting.append(part)


def _expect_keys_once(node: yaml.MappingNode, source: str) -> None:
    """Raise InputError where a mapping has a key twice: one of its values would vanish."""
    lines: dict[str, int] = {}
    for key, _ in node.value:
        if not isinstance(key, yaml.ScalarNode) or key.tag == MERGE_TAG:
            continue
        if key.value in lines:
            raise InputError(
                f"{_place(key, source)}: `{key.value}` is in line {lines[key.value]} already, "
                "and one of its two values would be lost; join them, or remove one"
            )
        lines[key.value] = key.start_mark.line + 1


def _expect_value(node: yaml.ScalarNode, loader: Any, source: str) -> None:
    """Raise InputError for a number, a date or a truth value that is none.

    The loader keeps the others: they are not made twice.
    """
    try:
        value = loader.construct_object(node)
        sound = not isinstance(value, int) or len(node.value) <= MAX_NUMBER_LENGTH
    except yaml.YAMLError:
        raise
    except Exception:  # PyYAML lets through whatever a conversion raises
        sound = False
    if not sound:
        raise InputError(
            f"{_place(node, source)}: {node.value[:20]!r} ({len(node.value):,} characters) is no "
            "number, date or truth value that can be used; correct it, or quote it if it is text"
        )


def _place(node: yaml.Node, source: str) -> str:
    return f"{source}, line {node.start_mark.line + 1}"


def expect_few_values(data: Any, source: str) -> None:
    """Raise InputError where data are nested too deep, or huge through repeated aliases.

    data: plain data, or the nodes of a YAML file; source: its name, for the message. Each alias
    (`*name`) stands for all that it names: nine lines can stand for a thousand million values.
    """
    if _measure(data, 0, {}, source)[0] > MOST_VALUES:
        raise _too_many(source)


def _measure(
    data: Any, level: int, measured: dict[int, tuple[int, int]], source: str
) -> tuple[int, int]:
    """Return the count of values and of levels below; measured: those of parts by id."""
    if level + measured.get(id(data), (1, 0))[1] > MAX_LEVELS:
        raise _too_deep(source)
    if id(data) not in measured:
        below = [_measure(part, level + 1, measured, source) for part in _parts(data)]
        count = 1 + sum(count for count, _ in below)
        measured[id(data)] = count, 1 + max((depth for _, depth in below), default=-1)
    return measured[id(data)]


def _parts(data: Any) -> Sequence[Any]:
    """Return the direct parts of a list, a mapping or a node of YAML."""
    if isinstance(data, yaml.MappingNode):
        return [part for pair in data.value for part in pair]
    if isinstance(data, dict):
        return [*data, *data.values()]
    if isinstance(data, yaml.SequenceNode):
        return list(data.value)
    return data if isinstance(data, list | tuple) else ()


def _too_many(source: str) -> InputError:
    return InputError(
        f"{source} stands for more than {MOST_VALUES:,} values, its aliases (`*name`) written out; "
        "use fewer of them, or divide it"
    )


def _too_deep(source: str) -> InputError:
    return InputError(
        f"{source} nests lists and mappings more than {MAX_LEVELS} levels deep; flatten it"
    )
