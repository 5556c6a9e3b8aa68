"""Arrays by their names in a file: HDF5, MAT, NumPy, Parquet, Feather, text files of a channel."""

import re
from collections.abc import Callable, Collection, Iterator
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.parquet as pq

from ur5lib.errors import InputError
from ur5lib.recordings.delimited import first_cells, read_numbers
from ur5lib.recordings.quality import Finding, Log
from ur5lib.strict import expect_file

Arrays = dict[str, np.ndarray]  # by path in the file, (n,) or (n, k) or (k, n)
Load = Callable[[Path, Collection[str] | None, list[Finding]], Arrays]  # None: all arrays
LOADERS: dict[str, Load] = {}  # by the format's name in a study
ENDINGS: dict[str, str] = {}  # the format of a file by its ending
HDF5_INSIDE = b"\x89HDF\r\n\x1a\n"  # behind the 512 bytes of MATLAB's own head
BLANK = re.compile(rb"\n[ \t\r]*\n")


def array_format(name: str, kind: str, *endings: str) -> Callable[[Load], Load]:
    """Register a function that loads a format; whatever it raises becomes an InputError.

    name: in a study; kind: for messages; endings: of such files, none where it is a folder. Arrays
    that the file lacks are left out.
    """

    def registered(load: Load) -> Load:
        @wraps(load)
        def loaded(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
            expect_file(path)
            if not (path.is_file() if endings else path.is_dir()):
                raise InputError(
                    f"{path} is missing or not {kind}; add it, or remove the recording from the "
                    "study"
                )
            try:
                arrays = load(path, wanted, findings)
            except InputError:
                raise
            except Exception as error:  # of damaged files, a library may raise anything
                raise InputError(
                    f"{path} cannot be read as {kind}: it is damaged, incomplete or of another "
                    "format, or its permissions forbid it; copy it again from its source, or "
                    "correct `format` in the study"
                ) from error
            return {name: arrays[name] for name in arrays if wanted is None or name in wanted}

        LOADERS[name] = loaded
        ENDINGS.update(dict.fromkeys(endings, name))
        return loaded

    return registered


@array_format("parquet", "a Parquet file", ".parquet")
def parquet_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the columns of numbers by name."""
    return _columns(pq.read_table(path))


@array_format("feather", "a Feather file", ".feather")
def feather_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the columns of numbers by name."""
    table = feather.read_table(path)
    table.validate(full=True)
    return _columns(table)


def _columns(table: pa.Table) -> Arrays:
    """Return the columns: of numbers as (n,), of stamps in seconds, of lists as (n, k)."""
    names = table.column_names
    columns = {n: _column(table.column(k)) for k, n in enumerate(names) if names.count(n) == 1}
    return {name: values for name, values in columns.items() if values is not None}


def _column(column: pa.ChunkedArray) -> np.ndarray | None:
    kind = column.type
    if pa.types.is_timestamp(kind):
        return column.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy() * 1e-9
    if pa.types.is_integer(kind) or pa.types.is_floating(kind):
        return column.cast(pa.float64()).to_numpy()
    if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind):
        rows = column.to_pylist()
        width = len(rows[0] or []) if rows else 0
        return np.array([row if row and len(row) == width else [np.nan] * width for row in rows])
    return None


@array_format("hdf5", "an HDF5 file", ".h5", ".hdf5")
def hdf5_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the arrays of numbers by their path in the file."""
    import h5py  # slow to import

    with h5py.File(path) as file:
        names: list[str] = []
        file.visit(names.append)  # follows no link to another file
        paths = names if wanted is None else wanted
        return {name: values for name in paths if (values := _numbers(file, name)) is not None}


def _numbers(file: Any, name: str) -> np.ndarray | None:
    """Return a data set of numbers with one or two dimensions, None for anything else."""
    found = file.get(name)
    kind, shape = (getattr(found, key, None) for key in ("dtype", "shape"))
    if kind is None or kind.kind not in "iuf" or not shape or len(shape) > 2:
        return None
    return np.asarray(found[()])


@array_format("mat", "a MAT file", ".mat")
def mat_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the arrays of numbers by name, fields of structures by `structure/field`.

    Version 7.3 of MAT is HDF5.
    """
    import scipy.io

    with path.open("rb") as stream:
        head = stream.read(520)
    if head[512:] == HDF5_INSIDE or head.startswith(HDF5_INSIDE):
        return hdf5_arrays(path, wanted, findings)
    return dict(_leaves(scipy.io.loadmat(path, simplify_cells=True)))


def _leaves(part: dict[str, Any], above: str = "") -> Iterator[tuple[str, np.ndarray]]:
    for name, value in part.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{above}{name}/")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iuf" and value.ndim in (1, 2):
            yield above + name, value


@array_format("npz", "a NumPy archive", ".npz")
def npz_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the arrays of numbers by name."""
    with np.load(path) as archive:
        names = [name for name in archive if wanted is None or name in wanted]
        return dict(_leaves({name: _plain(archive, name) for name in names}))


def _plain(archive: Any, name: str) -> np.ndarray | None:
    """Return an array of a NumPy archive, None for Python objects: to load them would run code."""
    try:
        return np.asarray(archive[name])
    except ValueError as error:
        if "allow_pickle" in str(error):
            return None
        raise


@array_format("channel-files", "a folder of text files")
def channel_file_arrays(
    folder: Path, wanted: Collection[str] | None, findings: list[Finding]
) -> Arrays:
    """Return the numbers (n, k) of text files, by their names in a folder.

    Rows belong together by their number, so that a line that is lost inside a file would shift all
    later ones: raises InputError for it.
    """
    there = sorted(path.name for path in folder.iterdir() if path.is_file())
    return {
        name: _read_rows(folder / name, findings)
        for name in there
        if wanted is None or name in wanted
    }


def _read_rows(path: Path, findings: list[Finding]) -> np.ndarray:
    own: list[Finding] = []
    names = [str(index) for index, _ in enumerate(first_cells(path)[0])]
    table = read_numbers(Log(path, "robot", own), names)
    blank = BLANK.search(path.read_bytes().strip())
    if blank or any(finding.finding == "damaged lines" for finding in own):
        raise InputError(
            f"{path} has lines without a number, so that its rows can no longer be matched with "
            "those of the other files; correct these lines, or record it again"
        )
    findings += own
    return table.to_numpy()
