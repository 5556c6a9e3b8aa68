"""A step on files in memory with the same bytes as on disk, so that its results equal a job's."""

import json
from collections.abc import Mapping
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any, get_args, get_origin

import pandas as pd

from ur5lib.jobs.files import assembled, parameter_types, read_file, setting
from ur5lib.jobs.job import step_named
from ur5lib.records.table import Table
from ur5lib.robots.description import Robot, robot_of
from ur5lib.strict import plain_yaml
from ur5lib.tables import ByKey, as_record, json_text, write_table

Content = Path | BytesIO | str  # a file; a table as Parquet; the text of any other file
Contents = Content | Mapping[str, Content]  # several by recording, or by arm


def call(step: str, inputs: Mapping[str, Contents], params: Mapping[str, Any]) -> Any:
    """Return the result of a step.

    inputs: contents of its files; params: plain data of a study, paths.
    """
    function = step_named(step)
    kinds = parameter_types(function)
    loads = {name: partial(_given, kinds[name], one) for name, one in inputs.items()}
    settings = {name: setting(kinds[name], own) for name, own in params.items()}
    return function(**assembled(function, loads, settings))


def contents(name: str, result: Any) -> dict[str, Content]:
    """Return a step's result as files by name: a single result under `name`, a NamedTuple under the
    names of its fields.
    """
    parts = result._asdict() if hasattr(result, "_asdict") else {name: result}
    return {part: _content(value) for part, value in parts.items()}


def record_of(kind: Any, content: Content) -> Any:
    """Return the record in a file in memory; content: the file, or its text."""
    if not isinstance(content, str):
        return read_file(kind, content)
    if kind is Robot:
        return robot_of(plain_yaml(content, "the arm"))
    return as_record(kind, json.loads(content))


def text_of(content: Content) -> str:
    """Return the text of a file that is no table."""
    assert not isinstance(content, BytesIO), "a table has no text"
    return content if isinstance(content, str) else content.read_text(encoding="utf-8")


def _content(value: Any) -> Content:
    if isinstance(value, str):
        return value
    if not isinstance(value, Table | pd.DataFrame):
        return json_text(value)
    file = BytesIO()
    value.write(file) if isinstance(value, Table) else write_table(value, file)
    return file


def _given(kind: Any, content: Contents) -> Any:
    if kind is Path:
        return content
    if get_origin(kind) is Mapping:
        assert isinstance(content, Mapping), f"{kind} is of several"
        own = get_args(kind)[1]
        return ByKey({name: partial(record_of, own, one) for name, one in content.items()})
    assert not isinstance(content, Mapping), f"{kind} is of one"
    return record_of(kind, content)
