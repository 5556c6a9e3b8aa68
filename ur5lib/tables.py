"""Reading and writing of all the pipeline's files.

Signals are Parquet, one column a channel under its RTDE name with a zero-based suffix, `time` [s]
first, the unit in each column's metadata. Results are CSV, summaries JSON. Every file is written to
a temporary name, flushed to the disk and renamed, so that no reader meets an incomplete one.
What must not replace another file is linked instead.
"""

import contextlib
import hashlib
import json
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, partial
from io import BytesIO, StringIO
from itertools import count
from pathlib import Path
from shlex import quote
from typing import Any, BinaryIO, TypeVar, cast

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv as pacsv
import pyarrow.parquet as pq
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError
from pydantic_core import SchemaValidator
from pydantic_core.core_schema import no_info_before_validator_function as before

from ur5lib.channels import CHANNELS, channels_of
from ur5lib.errors import InputError, NameTaken
from ur5lib.timeseries.arrays import Array, Labels

ROWS = 1 << 16  # read or written at once
# Matches columns of the first half of a pose, a twist or a wrench.
FIRST_HALF = re.compile(r"_[0-2]$|_F[xyz]$")
# These columns may have any text, or numbers of joints with blanks between them.
NAMES = (
    *("study", "recording", "robot", "arm", "model", "fitted_on", "tested_on"),
    *("joints", "moving_joints", "kind"),
)
Column = NDArray[Any]
Source = str | Path | BytesIO  # a file, or one in memory
Record = TypeVar("Record")
Value = TypeVar("Value")
_asides = count()  # a process may write one file twice at the same time


class ByKey(Mapping[str, Value]):
    """A mapping that loads a value each time it is used."""

    def __init__(self, loads: Mapping[str, Callable[[], Value]]) -> None:
        self._loads = loads

    def __getitem__(self, key: str) -> Value:
        return self._loads[key]()

    def __iter__(self) -> Iterator[str]:
        return iter(self._loads)

    def __len__(self) -> int:
        return len(self._loads)

    def __or__(self, other: Mapping[str, Value]) -> dict[str, Value]:
        return {**self, **other}

    def __ror__(self, other: Mapping[str, Value]) -> dict[str, Value]:
        return {**other, **self}


@contextlib.contextmanager
def intact(path: Source) -> Iterator[None]:
    """Raise InputError with the remedy if the code of a `with` block finds a damaged file of
    results; path: of the file.
    """
    try:
        yield
    # pyarrow raises OSError without an errno for a truncated Parquet file
    except (InputError, OSError, ValueError, pa.ArrowException) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        reason = str(error).splitlines()[0].removeprefix(f"{path} ").rstrip(".")
        raise InputError(
            f"{path} is damaged ({reason}); delete it (rm {quote(str(path))}), and `ur5 run` "
            "the study again"
        ) from error


def unit(column: str) -> str:
    """Return the unit of a column's channel, the longest channel name that the column begins with.

    Raises ValueError for an unknown channel.
    """
    if not has_unit(column):
        raise ValueError(f"column {column!r} has no known unit")
    return column_unit(column, CHANNELS[max(channels_of(column), key=len)].unit)


def column_unit(column: str, unit: str) -> str:
    """Return the unit of one column of a channel; unit: of the channel, where `N, Nm` means N for
    its forces and Nm for its moments.
    """
    first, _, second = unit.partition(", ")
    return first if FIRST_HALF.search(column) or not second else second


def has_unit(column: str) -> bool:
    """Return whether a column is a channel with a unit."""
    return bool(channels_of(column))


def write_table(
    table: pd.DataFrame | Mapping[str, Column],
    path: Source,
    units: Mapping[str, str] | None = None,
) -> None:
    """Write signals as Parquet, with the unit of each column: from `units`, else of its channel.

    Raises ValueError for a column without a unit.
    """
    explicit = units or {}
    arrays = {str(name): np.asarray(values) for name, values in table.items()}
    fields = []
    for name, values in arrays.items():
        own = column_unit(name, explicit[name]) if explicit.get(name) else unit(name)
        fields.append(pa.field(name, pa.from_numpy_dtype(values.dtype), metadata={"unit": own}))
    write = partial(_write_parquet, arrays, pa.schema(fields))
    write(path) if isinstance(path, BytesIO) else write_aside(path, write)


def _write_parquet(arrays: Mapping[str, Column], schema: pa.Schema, path: Path | BytesIO) -> None:
    """Write columns part by part, which avoids a copy of the whole."""
    count = len(next(iter(arrays.values())))
    # dictionary encoding would take three quarters of the time, and makes such files larger
    with pq.ParquetWriter(path, schema, use_dictionary=False) as writer:
        for start in range(0, count, ROWS):
            rows = slice(start, start + ROWS)
            part = [pa.array(values[rows], from_pandas=True) for values in arrays.values()]
            writer.write_table(pa.Table.from_arrays(part, schema=schema))


def read_table(path: Source, names: list[str] | None = None) -> pd.DataFrame:
    """Read a table of signals, or some of its columns."""
    # column by column avoids a second copy of the whole
    with intact(path), pq.ParquetFile(path) as file:
        wanted = file.schema_arrow.names if names is None else names
        arrays = {name: file.read([name]).column(0).to_numpy() for name in wanted}
    return pd.DataFrame(arrays, copy=False)


def read_units(path: Source) -> dict[str, str]:
    """Return the unit of each column of a table of signals."""
    with intact(path):
        fields = pq.read_schema(path)
    return {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in fields}


def read_footer(path: Source) -> pq.FileMetaData:
    """Return the Parquet metadata of a table: places of the columns, names in `schema.names`."""
    with intact(path):
        return pq.read_metadata(path)


def read_columns(
    path: Source,
    names: list[str],
    dtype: type = np.float64,
    rows: Labels | None = None,
    footer: pq.FileMetaData | None = None,
) -> Column:
    """Return columns of a table as an array (N, len(names)), without reading others.

    rows: indices of the rows to return, ascending; all by default; footer: from `read_footer`, to
    save reading it again, which takes longer than the columns of a short table.
    """
    with intact(path), pq.ParquetFile(path, metadata=footer) as file:
        count = file.metadata.num_rows if rows is None else len(rows)
        result = np.empty((count, len(names)), dtype)
        start = 0
        # threads cost more than they save: a step has one core
        for batch in file.iter_batches(ROWS, columns=names, use_threads=False):
            end = start + len(batch)
            first, last = (start, end) if rows is None else np.searchsorted(rows, (start, end))
            kept = slice(None) if rows is None else rows[first:last] - start
            for name, values in zip(names, result[first:last].T, strict=True):
                values[:] = batch.column(name).to_numpy(zero_copy_only=False)[kept]
            start = end
    return result


def columns(name: str, count: int = 6) -> list[str]:
    """Return the names of a channel's columns: name_0, name_1, ..."""
    return [f"{name}_{index}" for index in range(count)]


def channel(table: pd.DataFrame, name: str, count: int | None = None) -> Array:
    """Return a channel as a copied array (N, count), by default of all its columns."""
    have = count or next(k for k in range(len(table.columns) + 1) if f"{name}_{k}" not in table)
    values = [table[column].to_numpy(np.float64) for column in columns(name, max(1, have))]
    return np.array(values).T  # column-major in memory, as in pandas


def named(values: Array, name: str) -> dict[str, Array]:
    """Return the columns name_0, name_1, … of an array (N, M), or (N, ...) flattened row by row."""
    flat = values.reshape(len(values), -1)
    return dict(zip(columns(name, flat.shape[1]), flat.T, strict=True))


def write_csv(table: pd.DataFrame, path: str | Path, digits: int = 9) -> None:
    """Write a table of results; NaN becomes an empty cell, numbers have `digits` digits."""
    of_numbers = table.shape[1] > 1 and bool((table.dtypes == np.float64).all())
    write = _write_numbers if of_numbers else csv_text
    write_aside(path, lambda aside: write(table, digits, aside))


def csv_text(table: pd.DataFrame, digits: int = 9, path: Path | None = None) -> str | None:
    """Return the CSV text of a table of results, or write it to a path and return None."""
    return table.to_csv(path, index=False, float_format=f"%.{digits}g")


def write_exactly(table: pd.DataFrame, path: Path, header: bool = True) -> None:
    """Write a table as CSV; numbers are the same to the last bit when read again."""
    if any(kind.kind not in "iuf" for kind in table.dtypes):
        table.to_csv(path, index=False, header=header)
        return
    # ten times as fast with Arrow; the header is written here, since Arrow would quote the names
    arrays = [pa.array(table.iloc[:, k], from_pandas=True) for k in range(table.shape[1])]
    form = pacsv.WriteOptions(include_header=False, quoting_style="none")
    with path.open("wb") as file:
        if header:
            file.write((",".join(map(str, table.columns)) + "\n").encode())
        pacsv.write_csv(pa.table(arrays, [*map(str, range(len(arrays)))]), file, form)


def exact_text(table: pd.DataFrame, header: bool = True) -> str:
    """Return a table as CSV; numbers are the same to the last bit when read again."""
    return table.to_csv(index=False, header=header)


def _write_numbers(table: pd.DataFrame, digits: int, path: Path) -> None:
    """Write a table of only floats, four times as fast as pandas."""
    line = ",".join([f"%.{digits}g"] * table.shape[1]) + "\n"
    with path.open("w", encoding="utf-8", newline="") as file:
        table.iloc[:0].to_csv(file, index=False)
        for start in range(0, len(table), ROWS):
            rows = table.iloc[start : start + ROWS].to_numpy().tolist()
            file.writelines((line % tuple(row)).replace("nan", "") for row in rows)


def write_rows(kind: type, rows: Iterable[object], path: str | Path) -> None:
    """Write rows of a table as CSV; infinity becomes an empty cell."""
    write_csv(table_of(kind, rows).replace([math.inf, -math.inf], math.nan), path)


def table_of(kind: type, rows: Iterable[object]) -> pd.DataFrame:
    """Return rows as a table with a column for each field of `kind`; True is "yes", False "no"."""
    names = [field.name for field in fields(kind)]
    cells = [[_cell(getattr(row, name)) for name in names] for row in rows]
    return pd.DataFrame(cells, columns=names)


def table_by_owner(
    kind: type, rows: Mapping[str, Iterable[object]], owner: str = "recording"
) -> pd.DataFrame:
    """Return a table of the rows of several recordings or arms; the first column names the owner.

    owner: name of this column, `recording` or `robot`.
    """
    each = [*((of, row) for of, own in rows.items() for row in own)]
    table = table_of(kind, (row for _, row in each))
    table.insert(0, owner, pd.Series([of for of, _ in each], dtype=object))
    return table


def _cell(value: object) -> object:
    value = value.item() if isinstance(value, np.generic) else value
    return ("no", "yes")[value] if isinstance(value, bool) else value


def read_csv(path: str | Path) -> pd.DataFrame:
    """Read a table of results: an empty cell is NaN, and a name is text (`nan`, `1e5`)."""
    with _whole_lines(path) as file:
        return _parsed(file)


def as_written(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of results as `read_csv` would read it after writing."""
    return _parsed(StringIO(csv_text(table)))


def _parsed(file: Any) -> pd.DataFrame:
    names = dict.fromkeys(NAMES, str)
    return pd.read_csv(file, dtype=names, keep_default_na=False, na_values=[""])


def read_cells(path: str | Path) -> pd.DataFrame:
    """Read a table of results with all cells as text."""
    with _whole_lines(path) as file:
        return pd.read_csv(file, dtype=str, keep_default_na=False)


@contextlib.contextmanager
def _whole_lines(path: str | Path) -> Iterator[BinaryIO]:
    """Open a table of results. Raises InputError if its last line is incomplete."""
    with intact(path), open(path, "rb") as file:
        file.seek(max(0, file.seek(0, os.SEEK_END) - 1))
        if file.read() != b"\n":
            raise ValueError("its last line is cut")
        file.seek(0)
        yield file


def checksum(path: str | Path) -> str:
    """Return the SHA-256 of a file of any size, or of the checksums of a folder's files."""
    if (folder := Path(path)).is_dir():
        files = sorted(file for file in folder.iterdir() if file.is_file())
        return hashlib.sha256("".join(map(checksum, files)).encode()).hexdigest()
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_json(data: object, path: str | Path) -> None:
    """Write a summary; NaN and infinity become null."""
    write_text(json_text(data), path)


def json_text(data: object) -> str:
    """Return plain data, arrays and records as JSON; NaN and infinity become null."""
    return json.dumps(_plain(data), indent=2, allow_nan=False) + "\n"


def read_json(path: str | Path, of_object: Callable[[dict[str, Any]], Any] | None = None) -> Any:
    """Read a summary; of_object: function that converts each JSON object."""
    with intact(path):
        return json.loads(Path(path).read_text(encoding="utf-8"), object_hook=of_object)


def read_record(kind: type[Record], path: str | Path) -> Record:
    """Read a summary as a record with declared fields.

    Raises InputError if its fields differ, as in results of another version.
    """
    try:
        return as_record(kind, read_json(path, _as_now))
    except ValidationError as error:
        place = " → ".join(map(str, error.errors()[0]["loc"]))
        raise InputError(
            f"{path}: {place} is not as this version writes it; `ur5 run` the study again"
        ) from None


def _as_now(data: dict[str, Any]) -> dict[str, Any]:
    """Return one JSON object of a summary; a finding up to version 1.0 had its name as `finding`
    and its cause as `code`, and one of 0.2, or a remark, values instead of a sentence.
    """
    if not data.keys() >= {"code", "values"}:
        return _with_code(data)
    values, sentence = data["values"], data["code"] or data.get("finding", "")
    joints = values.get("joints", [values["joint"]] if "joint" in values else [])
    channels = values.get("names", [values["name"]] if "name" in values else [])
    said = {name: values.get(name) or "" for name in ("kind", "motion")}
    named = {"detail": sentence, "text": sentence, "joints": joints, "channels": channels}
    return _with_code(data | said | named)


def _with_code(data: dict[str, Any]) -> dict[str, Any]:
    if not data.keys() >= {"finding", "severity"}:
        return data
    return data | {"code": data["finding"], "cause": data["code"] or None}


def as_record(kind: type[Record], data: object) -> Record:
    """Return plain data as a dataclass, or a dictionary of dataclasses; null for a number is NaN.

    Raises pydantic's ValidationError where the fields differ.
    """
    record: Record = _validator(cast(Any, kind)).validate_python(data)
    return record


@cache
def _validator(kind: Any) -> SchemaValidator:
    """Return the validator of a record's fields, cached since building it takes long."""
    return SchemaValidator(_null_is_nan(TypeAdapter(kind).core_schema))


def _null_is_nan(schema: Any) -> Any:
    """Return pydantic's schema, changed so that null becomes NaN unless a number is optional."""
    if isinstance(schema, list):
        return [_null_is_nan(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") == "nullable" and schema["schema"].get("type") == "float":
        return schema
    if schema.get("type") == "float":
        return before(lambda value: math.nan if value is None else value, schema)
    return {name: _null_is_nan(part) for name, part in schema.items()}


def key(field: str) -> str:
    """Return the key of a record's field in a JSON summary: `from` for the field `from_`, which is
    a keyword in Python.
    """
    return field.removesuffix("_")


BY_KEY = {"alias_generator": key}  # `__pydantic_config__` of records with such a field


def write_text(text: str, path: str | Path) -> None:
    """Write a text file."""
    write_aside(path, lambda aside: aside.write_text(text, encoding="utf-8"))


def write_new_text(text: str, path: str | Path) -> None:
    """Write a text file, but not over another. Raises NameTaken where there is one."""
    write_new(path, lambda aside: aside.write_text(text, encoding="utf-8"))


def write_bytes(data: bytes, path: str | Path) -> None:
    """Write a binary file."""
    write_aside(path, lambda aside: aside.write_bytes(data))


def write_new(path: str | Path, write: Callable[[Path], object]) -> None:
    """Write a file as `write_aside` does, but never over another: NameTaken where one has its name,
    even if that was written meanwhile.
    """
    write_aside(path, write, _link)


def write_aside(
    path: str | Path,
    write: Callable[[Path], object],
    place: Callable[[Path, Path], object] = os.replace,
) -> None:
    """Write a file to a temporary path by the function `write`, flush it, then rename it by the
    function `place`.

    Without the flush, a power failure may leave the new name without its content. Raises InputError
    where the file cannot be written.
    """
    path = Path(path)
    aside = path.with_name(f".{path.name}.{os.getpid()}-{next(_asides)}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write(aside)
        with aside.open("rb") as written:
            os.fsync(written.fileno())
        place(aside, path)
    except OSError as error:
        raise InputError(
            f"{path} cannot be written ({error.strerror}); "
            "check the name, the free disk space and the permissions"
        ) from error
    finally:
        with contextlib.suppress(OSError):
            aside.unlink()


def _link(aside: Path, path: Path) -> None:
    """Give a file its name. Raises NameTaken where another has it."""
    try:
        try:
            os.link(aside, path)
        except FileExistsError:
            raise
        except OSError:  # a file system without links, as of a USB stick
            path.open("xb").close()
            os.replace(aside, path)
    except FileExistsError as error:
        raise NameTaken(f"{path} exists; name another") from error


def made(folder: Path) -> Path:
    """Return a folder, made if it does not exist. Raises InputError where it cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{folder} cannot be written ({error.strerror}); check its name and the permissions"
        ) from error
    return folder


def _plain(data: object) -> object:
    if isinstance(data, float):  # first, as the most frequent
        return data if math.isfinite(data) else None
    if hasattr(data, "model_dump"):
        return _plain(data.model_dump())
    if is_dataclass(data):
        return {key(field.name): _plain(getattr(data, field.name)) for field in fields(data)}
    if isinstance(data, dict):
        return {key: _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, np.generic | np.ndarray):
        return _plain(data.tolist())
    return data
