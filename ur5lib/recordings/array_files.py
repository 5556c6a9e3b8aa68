"""Arrays by their names in a file: HDF5, MAT, NumPy, Parquet, Feather."""

import json
import traceback
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.feather as feather
import pyarrow.parquet as pq
import scipy  # loads scipy.io at its first use

from ur5lib.errors import InputError
from ur5lib.recordings.echo_start import ECHOED, is_echoed
from ur5lib.recordings.limits import BYTES_PER_NUMBER, expect_room
from ur5lib.recordings.unpacked import expect_mat_room, feather_numbers, parquet_numbers
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.strict import MOST_BYTES, expect_file
from ur5lib.timeseries.arrays import Array

PACKED_ENDING = ".zstd"  # of a bag's files that are packed as a whole
Arrays = dict[str, np.ndarray]  # by path in the file, (n,) or (n, k) or (k, n)
Load = Callable[[Path, Collection[str] | None, list[Finding]], Arrays]  # None: all arrays
LOADERS: dict[str, Load] = {}  # by the format's name in a study
ENDINGS: dict[str, str] = {}  # the format of a file by its ending
LEVELS_OF_DATA_SET = 4  # folders of a LeRobot data set above its files
UNPACKERS = ("array_files.py", "unpacked.py", "hdf5_links.py", "bag_chunks.py", "bag_files.py")
OWN_CODE = Path(__file__).parents[1]
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"  # behind the 512 bytes of MATLAB's own head


def array_format(
    name: str, kind: str, *endings: str, is_folder: bool = False
) -> Callable[[Load], Load]:
    """Register a function that loads a format; whatever it raises becomes an InputError.

    name: of the format in a study; kind: its name in messages; endings: of its files; is_folder:
    whether it may be a folder, without endings always is. Arrays that are not wanted are left out
    of the result.
    """

    def registered(load: Load) -> Load:
        @wraps(load)
        def loaded(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
            expect_file(path)
            is_file = path.is_file() and (endings or not is_folder)
            if not (is_file or (is_folder and path.is_dir())):
                raise InputError(
                    f"{path} is missing or not {kind}; add it, or remove the recording from the "
                    "study"
                )
            try:
                arrays = load(path, wanted, findings)
                expect_room(path, sum(array.size for array in arrays.values()))
            except InputError:
                raise
            except Exception as error:  # of damaged files, a library may raise anything
                if is_ours(error):
                    raise InputError(
                        f"{path} cannot be read as {kind} by a fault of ur5 and not of the file "
                        f"({error}); report it, with the file if you may"
                    ) from error
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


def is_ours(error: BaseException) -> bool:
    """Return whether the project's own code raised an exception, rather than a library that it
    calls.

    A library in C leaves no line of its own in the traceback, so that what UNPACKERS raise counts
    as the file's fault.
    """
    places = [Path(frame.filename) for frame in traceback.extract_tb(error.__traceback__)]
    of_file = isinstance(error, EOFError | OSError) or not places or places[-1].name in UNPACKERS
    return not of_file and places[-1].is_relative_to(OWN_CODE)


def report_unread(path: Path, names: Iterable[str], why: str, findings: list[Finding]) -> None:
    """Add a note on the arrays of a file that are not read, and why; `ur5 import` prints a line for
    each array.
    """
    listed = sorted({*names})
    meaning = f"{', '.join(listed)}: {why}"
    Log(path, "robot", findings).add(Found.UNREAD, "note", len(listed), meaning, channels=listed)


@array_format("parquet", "a Parquet file", ".parquet")
def parquet_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the columns of numbers by name; lists with named elements as columns
    `<column>/<element>`.
    """
    elements = named_elements(path)
    listed = {name for name in elements if wanted is None or any(name in one for one in wanted)}
    with pq.ParquetFile(path, page_checksum_verification=True) as file:
        columns = _numeric(file.schema_arrow, None if wanted is None else {*wanted, *listed})
        if wanted is None:
            others = {*file.schema_arrow.names} - {*columns}
            report_unread(path, others, "it holds no numbers", findings)
        expect_room(path, parquet_numbers(file, columns))
        arrays = _columns(file.read(columns))
    for name in listed & {*arrays}:
        if arrays[name].ndim == 2 and arrays[name].shape[1] == len(elements[name]):
            parts = {f"{name}/{part}": arrays[name][:, k] for k, part in enumerate(elements[name])}
            arrays |= parts
            del arrays[name]
    return arrays


def named_elements(path: Path) -> dict[str, list[str]]:
    """Return, by list column, the names of its elements by the `info.json` of a LeRobot data set,
    which is next to the file or in `meta` of a folder above it. Empty without such a file.
    """
    folders = path.absolute().parents[:LEVELS_OF_DATA_SET]
    infos = [path.with_name("info.json"), *(folder / "meta" / "info.json" for folder in folders)]
    info = next((info for info in infos if info.is_file()), None)
    if info is None or info.stat().st_size > MOST_BYTES:
        return {}
    told = json.loads(info.read_text(encoding="utf-8")).get("features", {})
    names = {column: feature.get("names") for column, feature in told.items()}
    lists = {
        c: next(iter(n.values()), None) if isinstance(n, dict) else n for c, n in names.items()
    }
    return {c: [*map(str, n)] for c, n in lists.items() if isinstance(n, list)}


@array_format("feather", "a Feather file", ".feather")
def feather_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the columns of numbers by name."""
    expect_room(path, feather_numbers(path))
    table = feather.read_table(path)
    table.validate(full=True)
    return _columns(table.select(_numeric(table.schema, wanted)))


def _numeric(schema: pa.Schema, wanted: Collection[str] | None) -> list[str]:
    """Return the names of the columns of numbers, stamps or lists of numbers, each name once."""
    counts = Counter(schema.names)
    found = [field.name for field in schema if counts[field.name] == 1 and _is_numeric(field.type)]
    return [name for name in found if wanted is None or name in wanted]


def _is_list(kind: pa.DataType) -> bool:
    return bool(pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind))


def _is_numeric(kind: pa.DataType) -> bool:
    numbers = kind.value_type if _is_list(kind) else kind
    stamps = pa.types.is_timestamp(kind)
    return bool(pa.types.is_integer(numbers) or pa.types.is_floating(numbers) or stamps)


def _columns(table: pa.Table) -> Arrays:
    """Return the columns by name: numbers (n,), stamps (n,) in seconds, lists (n, k)."""
    return {name: _column(table.column(name)) for name in table.column_names}


def _column(column: pa.ChunkedArray) -> np.ndarray:
    if pa.types.is_timestamp(column.type):
        return column.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy() * 1e-9
    if not _is_list(column.type):
        return np.asarray(column.to_numpy(), dtype=float)
    lengths = pc.list_value_length(column)
    widths = pc.if_else(pc.is_valid(column), lengths, 0).to_numpy()
    values = np.asarray(pc.list_flatten(column).to_numpy(), dtype=float)
    return rows_of(values, widths, int(widths[0]) if len(widths) else 0)


def format_of(path: Path) -> str | None:
    """Return the format of a file by its ending, or of text by its beginning, None for an unknown
    one. A folder is a bag.
    """
    if is_echoed(path):
        return ECHOED
    return "rosbag" if path.is_dir() else ENDINGS.get(path.suffix.lower())


def rows_of(values: np.ndarray, widths: np.ndarray, width: int) -> Array:
    """Return rows (n, width) from the values of all rows one after the other; NaN in rows of
    another width.

    widths: number of values in each row (n,).
    """
    fits = widths == width
    rows = np.full((len(widths), width), np.nan)
    rows[fits] = values[np.repeat(fits, widths)].reshape(-1, width)
    return rows


@array_format("hdf5", "an HDF5 file", ".h5", ".hdf5")
def hdf5_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the arrays of numbers by their path in the file."""
    import h5py  # slow to import

    from ur5lib.recordings.hdf5_links import expect_inside, expect_own_numbers

    with h5py.File(path) as file:
        names: list[str] = []
        file.visit(names.append)  # follows no link
        paths = names if wanted is None else wanted
        for name in paths:
            expect_inside(file, name, path)
        found = {name: one for name in paths if (one := _numbers(file, name)) is not None}
        if wanted is None:
            shapes = {name: getattr(file.get(name), "shape", ()) for name in names}
            others = {n: own for n, own in shapes.items() if own and n not in found}
            listed = (f"{n} ({' × '.join(f'{k:,}' for k in own)})" for n, own in others.items())
            shape = "it holds text, or more dimensions than rows and columns"
            report_unread(path, listed, shape, findings)
        for array in found.values():
            expect_own_numbers(array, path)
        expect_room(path, sum(array.size for array in found.values()))
        return {name: np.asarray(array[()]) for name, array in found.items()}


def _numbers(file: Any, name: str) -> Any:
    """Return a data set of numbers with one or two dimensions, None for anything else."""
    found = file.get(name)
    kind, shape = (getattr(found, key, None) for key in ("dtype", "shape"))
    if kind is None or kind.kind not in "iuf" or not shape or len(shape) > 2:
        return None
    return found


@array_format("mat", "a MAT file", ".mat")
def mat_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the arrays of numbers by name, fields of structures by `structure/field`.

    Version 7.3 of MAT is HDF5.
    """
    with path.open("rb") as stream:
        head = stream.read(520)
    if head[512:] == HDF5_SIGNATURE or head.startswith(HDF5_SIGNATURE):
        return hdf5_arrays(path, wanted, findings)
    expect_mat_room(path)
    whole = scipy.io.loadmat(path, simplify_cells=True)
    return _numeric_leaves(path, whole, wanted, findings)


def _numeric_leaves(
    path: Path, whole: dict[str, Any], wanted: Collection[str] | None, findings: list[Finding]
) -> Arrays:
    """Return the arrays of numbers by name; the others are reported if all are wanted."""
    leaves = dict(_leaves(whole))
    arrays = {name: own for name, own in leaves.items() if _has_rows(own)}
    others = (f"{n} ({_size(leaves[n])})" for n in leaves if n not in arrays)
    if wanted is None:
        report_unread(path, others, "no numbers in rows and columns", findings)
    return arrays


def _leaves(part: dict[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield what is in structures, by `structure/field`, without what describes the file."""
    for name, value in part.items():
        if isinstance(value, dict):
            yield from _leaves(value, f"{above}{name}/")
        elif not (name.startswith("__") and name.endswith("__")):  # as __header__, not __time
            yield above + name, value


def _has_rows(value: Any) -> bool:
    numbers = isinstance(value, np.ndarray) and value.dtype.kind in "iuf"
    return numbers and value.ndim in (1, 2)


def _size(value: Any) -> str:
    """Return the size of an array in words, as 350 × 480 × 640; 1 of a single value."""
    return " × ".join(f"{n:,}" for n in np.shape(value)) or "1"


@array_format("npz", "a NumPy archive", ".npz")
def npz_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the arrays of numbers by name."""
    with np.load(path) as archive:
        names = [name for name in archive if wanted is None or name in wanted]
        files = {*archive.zip.namelist()}
        stored = [name if name in files else f"{name}.npy" for name in names]
        sizes = [archive.zip.getinfo(name).file_size for name in stored]
        expect_room(path, sum(sizes) / BYTES_PER_NUMBER)
        whole = {name: _plain(archive, name) for name in names}
    return _numeric_leaves(path, whole, wanted, findings)


def _plain(archive: Any, name: str) -> np.ndarray | None:
    """Return an array of a NumPy archive, None for Python objects: to load them would run code."""
    try:
        return np.asarray(archive[name])
    except ValueError as error:
        if "allow_pickle" in str(error):
            return None
        raise
