"""Recordings in memory as files: read from these, they give the same results to the bit."""

import re
from collections.abc import Iterable, Iterator, Mapping
from os import PathLike
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pandas as pd
import pyarrow as pa

from ur5lib.errors import InputError, briefly, expect_text
from ur5lib.tables import made, write_exactly

UNNAMED = "recording"  # name of data that have none
NO_CELL = re.compile(r'[\s,;"]+')  # not allowed in a column's name
NO_FILE = re.compile(r"[^\w-]+")  # replaced in a file's name
SECONDS = {"M": "datetime64[ns]", "m": "timedelta64[ns]"}  # by an array's kind of dtype


def named(given: object) -> list[tuple[str, Any]]:
    """Return (name, data) of each given recording; the name of a file is "".

    given: a file, a data frame, an array, or arrays by name; or several of these, as a list or by
    name. Raises InputError for anything else.
    """
    if _is_one(given):
        return [("" if _is_path(given) else UNNAMED, given)]
    if isinstance(given, Mapping):
        return [(str(name), _one(part)) for name, part in given.items()]
    if not isinstance(given, Iterable) or isinstance(given, bytes):
        raise _no_recording(given)
    parts = [_one(part) for part in given]
    return [
        ("" if _is_path(part) else f"{UNNAMED}_{k}", part) for k, part in enumerate(parts, start=1)
    ]


def as_files(recordings: Iterable[tuple[str, Any]], folder: Path) -> Iterator[Path]:
    """Yield the file of each recording, (name, file or data); data are written into `folder`.

    A frame or an array becomes CSV with all its digits, arrays by name a NumPy archive, each in its
    own folder, so that several do not count as one run.
    """
    for number, (name, data) in enumerate(recordings, start=1):
        if _is_path(data):
            yield Path(expect_text(data, "file"))
            continue
        stem = made(folder / str(number)) / (NO_FILE.sub("_", name) or UNNAMED)
        if isinstance(data, Mapping):
            path = stem.with_suffix(".npz")
            _write_archive({str(key): _numbers(values) for key, values in data.items()}, path)
        else:
            frame = _frame(data)
            nameless = all(isinstance(column, int | np.integer) for column in frame.columns)
            path = stem.with_suffix(".csv")
            write_exactly(frame.rename(columns=_cell), path, header=not nameless)
        yield path


def _write_archive(arrays: Mapping[str, np.ndarray], path: Path) -> None:
    """Write a NumPy archive; np.savez cannot write an array that is called `file`."""
    with ZipFile(path, "w") as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, values, allow_pickle=False)


def _one(part: object) -> object:
    if not _is_one(part):
        raise _no_recording(part)
    return part


def _is_one(data: object) -> bool:
    """Return whether data are one recording; a mapping of frames or files is several."""
    if isinstance(data, Mapping):
        return bool(data) and all(_is_array(values) or _is_rows(values) for values in data.values())
    return _is_path(data) or _is_frame(data) or _is_array(data)


def _is_path(data: object) -> bool:
    return isinstance(data, str | PathLike)


def _is_frame(data: object) -> bool:
    """Return whether data are a frame of pandas, Polars or Arrow."""
    has_rows = hasattr(data, "__arrow_c_stream__") and len(getattr(data, "shape", ())) == 2
    return isinstance(data, pd.DataFrame) or has_rows


def _is_array(data: object) -> bool:
    return hasattr(data, "__array__") and not _is_frame(data)


def _is_rows(data: object) -> bool:
    """Return whether data are a list of numbers, or of lists of numbers."""
    return isinstance(data, list | tuple) and not any(_is_path(part) for part in data)


def _frame(data: Any) -> pd.DataFrame:
    """Return data as a data frame, with its index as a column if that is more than the row
    number.
    """
    if not isinstance(data, pd.DataFrame):
        if _is_array(data) and np.ndim(data) != (np.asarray(data).dtype.names is None) + 1:
            raise _no_recording(data)
        data = pd.DataFrame(data) if _is_array(data) else pa.table(data).to_pandas()
    frame = data.copy(deep=False)
    frame.columns = [_joined(name) for name in frame.columns]
    names = [name for name in frame.index.names if name is not None]
    if not names and frame.index.dtype.kind in "fMm":
        frame, names = frame.rename_axis("time"), ["time"]
    frame = frame.reset_index(drop=not names)
    for name, kind in frame.dtypes.items():
        if kind.kind in "bm":
            frame[name] = _numbers(frame[name])
        elif kind.kind == "O":  # NumPy prints an array in a cell with eight digits
            frame[name] = [_plain(cell) for cell in frame[name]]
    return frame


def _plain(cell: Any) -> Any:
    """Return a cell with NumPy's numbers, which do not print as numbers, replaced by Python's."""
    if isinstance(cell, list | tuple):
        return [_plain(part) for part in cell]
    return cell.tolist() if isinstance(cell, np.ndarray | np.generic) else cell


def _joined(name: object) -> object:
    """Return a column's name as one text: the levels of a name with several are joined by `_`."""
    return "_".join(str(part) for part in name if part != "") if isinstance(name, tuple) else name


def _cell(name: object) -> str:
    return NO_CELL.sub(" ", str(name)).strip()


def _numbers(values: Any) -> np.ndarray:
    """Return values as an array; dates become seconds since 1970, durations seconds."""
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{briefly(values)} is no array of numbers: its rows differ") from error
    if array.dtype.kind not in SECONDS:
        return array.astype({"b": float, "O": str}.get(array.dtype.kind, array.dtype))
    counted = array.astype(SECONDS[array.dtype.kind])
    return np.where(np.isnat(counted), np.nan, counted.astype(np.int64) * 1e-9)


def _no_recording(given: object) -> InputError:
    shown = briefly(given)
    return InputError(
        f"{shown} is no recording; give files, data frames, arrays (N, M), or arrays by name"
    )
