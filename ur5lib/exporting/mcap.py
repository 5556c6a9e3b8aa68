"""A recording as an MCAP file, which Foxglove and PlotJuggler read."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from ur5lib.errors import InputError
from ur5lib.exporting.contents import Contents
from ur5lib.tables import write_aside

if TYPE_CHECKING:
    from mcap.writer import Writer


def write_mcap(contents: Contents, path: Path) -> None:
    """Write a topic for each table, e.g. /forces, and a JSON message for each sample and table.

    A message has a number for each column, without unknown values. The topic's JSON schema has the
    units. Time stamps count from 1970, or from the recording's start if its date is unknown.
    Raises InputError where the file cannot be written, or the package `mcap` is missing.
    """
    try:
        from mcap.writer import Writer
    except ImportError as error:
        raise InputError(
            "MCAP needs the package mcap; install it by pip install --editable '.[formats]'"
        ) from error

    def write(aside: Path) -> None:
        with aside.open("wb") as stream:
            writer = Writer(stream)
            writer.start()
            _write_messages(writer, contents)
            writer.finish()

    write_aside(path, write)


def _write_messages(writer: "Writer", contents: Contents) -> None:
    """Write the samples of all tables in the order of their time stamps, as players expect."""
    topics = {name: _add_topic(writer, name, table) for name, table in contents.tables.items()}
    rows = [_messages(table) for table in contents.tables.values()]
    first = next(iter(contents.tables.values()))
    stamps = [round(1e9 * (time + (contents.start or 0.0))) for time in first.index]
    for number, (stamp, *messages) in enumerate(zip(stamps, *rows, strict=True)):
        for topic, message in zip(topics.values(), messages, strict=True):
            writer.add_message(topic, stamp, message, stamp, number)


def _add_topic(writer: "Writer", name: str, table: pd.DataFrame) -> int:
    schema = json.dumps(schema_of(table)).encode()
    number = writer.register_schema(f"ur5lib.{name}", "jsonschema", schema)
    return int(writer.register_channel(f"/{name}", "json", number))


def schema_of(table: pd.DataFrame) -> dict[str, Any]:
    """Return the JSON schema of a table's messages; each column's description is its unit."""
    units = table.attrs["units"]
    kinds = {name: "boolean" if table[name].dtype == bool else "number" for name in table}
    properties = {name: {"type": kinds[name], "description": units[name]} for name in table}
    return {"type": "object", "properties": properties}


def _messages(table: pd.DataFrame) -> Iterator[bytes]:
    names = [*table]
    for row in table.itertuples(index=False, name=None):
        message = {
            name: value for name, value in zip(names, row, strict=True) if math.isfinite(value)
        }
        yield json.dumps(message).encode()
