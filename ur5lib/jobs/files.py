"""Files of a job as the typed arguments of its step, and the step's results as files.

A step is a function of records. Its parameters, and the fields of its `Opened` parameters, have the
names of the rule's inputs and params, and their types decide how a file is read. Its results are
written to the rule's outputs of the same names.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from io import BytesIO
from itertools import chain
from pathlib import Path
from types import GenericAlias, UnionType
from typing import Any, get_args, get_origin, get_type_hints

import pandas as pd
from pydantic import TypeAdapter

from ur5lib.errors import InputError
from ur5lib.jobs.unreadable import Files, marked
from ur5lib.records.opened import Opened
from ur5lib.records.table import Table
from ur5lib.robots.description import Robot, load_robot
from ur5lib.tables import (
    ByKey,
    Source,
    intact,
    read_csv,
    read_record,
    read_table,
    write_bytes,
    write_csv,
    write_json,
    write_rows,
    write_table,
    write_text,
)

PLAIN = (str, int, float, bool)  # settings that need no conversion


def arguments(step: Callable[..., Any], input: Files, params: Mapping[str, Any]) -> dict[str, Any]:
    """Return a step's arguments by name; those without a file or setting keep their default.

    input: paths; a parameter of type Mapping takes a list of files, by the folders (of recordings
    or arms) that contain them. Raises InputError if a file does not match its type.
    """
    kinds = parameter_types(step)
    loads = {name: partial(_read, kinds[name], of) for name, of in input.items() if name in kinds}
    settings = {name: setting(kinds[name], own) for name, own in params.items() if name in kinds}
    return assembled(step, loads, settings)


def assembled(
    step: Callable[..., Any], loads: Mapping[str, Callable[[], Any]], known: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a step's arguments by name, from functions that read them and from values at hand.

    loads: functions that read a parameter (called now) or a field of an `Opened` (called at its
    first use); known: parameters and fields in memory. Raises InputError for a field without any;
    of several recordings, none may be there.
    """
    own = _annotated(step)
    given = {name: load() for name, load in loads.items() if name in own}
    given |= {name: value for name, value in known.items() if name in own}
    for name, kind in own.items():
        if (record := opened(kind)) is not None:
            fields = get_type_hints(record).keys() - own.keys()
            files = {field: load for field, load in loads.items() if field in fields}
            of_one = {field: value for field, value in known.items() if field in fields}
            for field in sorted(fields - {*files, *of_one, "name"}):
                if not hasattr(record, field) and (files or of_one or kind is record):
                    raise InputError(f"nothing is given for `{field}`, which `{name}` declares")
            given[name] = record(files, **of_one) if kind is record else _each(record, files)
    return given


def _each(record: type[Opened], loads: Mapping[str, Callable[[], Any]]) -> Mapping[str, Opened]:
    """Return a record for each recording or arm, by its name; loads: functions by field."""
    several = {field: load() for field, load in loads.items()}

    def of(name: str) -> Opened:
        known = {field: each for field, each in several.items() if name in each}
        files = {field: partial(each.__getitem__, name) for field, each in known.items()}
        return record(files, name=name)

    names = dict.fromkeys(chain.from_iterable(several.values()))
    return ByKey({name: partial(of, name) for name in names})


def write(step: Callable[..., Any], result: Any, output: Files) -> None:
    """Write a step's result to its outputs: one record, or several by the outputs' names.

    Several: the fields of a NamedTuple, or a dictionary. The numbers of a figure are written next
    to it. None: the step has written its files itself.
    """
    kind = get_type_hints(step)["return"]
    for name, (own, value) in _parts(kind, result, output).items():
        _write(own, value, Path(str(output[name])))


def leave(step: Callable[..., Any], reason: str, output: Files) -> None:
    """Write the reason why a recording cannot be read to a step's outputs; to tables, no rows."""
    kind = get_type_hints(step)["return"]
    for paths in output.values():
        for path in [paths] if isinstance(paths, str) else paths:
            if get_origin(kind) is list and path.endswith(".csv"):
                write_rows(get_args(kind)[0], [], path)
            else:
                write_text(marked(reason), path)


def _parts(kind: Any, result: Any, output: Files) -> dict[str, tuple[Any, Any]]:
    """Return the type and the value that belong to each output, by the output's name."""
    if result is None:
        return {}
    if hasattr(result, "_asdict") and {*result._fields} & {*output}:
        kinds, values = get_type_hints(kind), result._asdict()
    elif get_origin(kind) is dict and {*result} & {*output}:
        kinds, values = dict.fromkeys(result, get_args(kind)[1]), result
    else:
        return {next(iter(output)): (kind, result)}
    return {name: (kinds[name], values[name]) for name in values if name in output}


@cache
def parameter_types(step: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of a step's parameters by name, with the fields of an `Opened` in its place.

    Optional types are returned without None.
    """
    types = dict[str, Any]()
    for name, kind in _annotated(step).items():
        if (record := opened(kind)) is None:
            types[name] = kind
            continue
        for field, own in get_type_hints(record, include_extras=True).items():
            types.setdefault(field, own if kind is record else GenericAlias(Mapping, (str, own)))
    return {name: _without_none(kind) for name, kind in types.items()}


@cache
def _annotated(step: Callable[..., Any]) -> dict[str, Any]:
    types = get_type_hints(step, include_extras=True)
    return {name: kind for name, kind in types.items() if name != "return"}


def opened(kind: Any) -> type[Opened] | None:
    """Return the type of `Opened` that a parameter takes, alone or in a Mapping, else None."""
    own = get_args(kind)[1] if get_origin(kind) is Mapping else kind
    return own if isinstance(own, type) and issubclass(own, Opened) else None


def _without_none(kind: Any) -> Any:
    """Return a type without None; a union of several other types stays as it is."""
    if not isinstance(kind, UnionType):
        return kind
    others = [part for part in get_args(kind) if part is not type(None)]
    return others[0] if len(others) == 1 else kind


def _read(kind: Any, paths: str | Sequence[str]) -> Any:
    """Return the content of a file, or of several by their folders, each read at its first use."""
    origin = get_origin(kind)
    if kind is Path or (origin in (list, Sequence) and get_args(kind) == (Path,)):
        return Path(paths) if isinstance(paths, str) else [*map(Path, paths)]
    if origin is Mapping:
        each = [paths] if isinstance(paths, str) else paths
        read = partial(_read, get_args(kind)[1])
        return ByKey({Path(path).parent.name: partial(read, path) for path in each})
    if not isinstance(paths, str):
        return None if not paths else _read(kind, paths[0])
    return read_file(kind, paths)


def read_file(kind: Any, path: Source) -> Any:
    """Return the record in a file; path: also the buffer of a table."""
    if isinstance(kind, type) and issubclass(kind, Table):
        return kind.read(path)
    if kind is pd.DataFrame and not str(path).endswith(".csv"):
        return read_table(path)
    assert not isinstance(path, BytesIO), f"{kind} is no table"
    if kind is pd.DataFrame:
        return read_csv(path)
    if kind is Robot:
        with intact(path):
            return load_robot(path)
    return read_record(kind, path)


def setting(kind: Any, value: Any) -> Any:
    """Return plain data of a study converted to the type of a setting."""
    if value is None or kind in PLAIN or kind is Any:
        return value
    return _validated(kind)(value)


@cache
def _validated(kind: Any) -> Callable[[Any], Any]:
    validate: Callable[[Any], Any] = TypeAdapter(kind).validate_python
    return validate


def _write(kind: Any, value: Any, path: Path) -> None:
    if isinstance(value, Table):
        value.write(path)
    elif isinstance(value, pd.DataFrame):
        write_table(value, path) if path.suffix == ".parquet" else write_csv(value, path)
    elif isinstance(value, str):
        write_text(value, path)
    elif isinstance(value, bytes):
        write_bytes(value, path)
    elif path.suffix == ".csv":
        write_rows(get_args(kind)[0], value, path)
    elif path.suffix == ".json":
        write_json(value, path)
    else:
        from ur5lib.report.figures.house_style import save  # slow to import

        save(value, path)
