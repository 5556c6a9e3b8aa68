"""Tables: units, provenance of names, and never half a file."""

import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ur5lib import tables
from ur5lib.errors import InputError, NameTaken
from ur5lib.tables import (
    channel,
    named,
    read_cells,
    read_columns,
    read_csv,
    read_footer,
    read_json,
    read_record,
    read_table,
    read_units,
    unit,
    write_csv,
    write_json,
    write_new,
    write_new_text,
    write_table,
    write_text,
)


@pytest.fixture
def table() -> pd.DataFrame:
    time = np.arange(5) * 0.008
    return pd.DataFrame({"time": time, **named(np.arange(30.0).reshape(5, 6), "actual_q")})


def test_a_table_comes_back_with_its_units_and_is_always_the_same_file(
    table: pd.DataFrame, tmp_path: Path
) -> None:
    path = tmp_path / "signals.parquet"
    write_table(table, path)
    pd.testing.assert_frame_equal(read_table(path), table)
    units = {field.name: field.metadata[b"unit"] for field in pq.read_schema(path)}
    assert units == {"time": b"s"} | {f"actual_q_{j}": b"rad" for j in range(6)}
    write_table(table, tmp_path / "again.parquet")
    assert (tmp_path / "again.parquet").read_bytes() == path.read_bytes()


def test_a_long_table_is_written_and_read_in_parts(
    table: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    table.loc[3, "actual_q_2"] = np.nan
    monkeypatch.setattr(tables, "ROWS", 2)
    write_table(table, tmp_path / "parts.parquet")
    pd.testing.assert_frame_equal(read_table(tmp_path / "parts.parquet"), table)
    names = ["actual_q_2", "time"]
    found = read_columns(tmp_path / "parts.parquet", names)
    some = np.array([0, 3, 4])
    np.testing.assert_array_equal(
        read_columns(tmp_path / "parts.parquet", names, rows=some), found[some]
    )
    np.testing.assert_array_equal(found, table[names].to_numpy())
    assert pq.ParquetFile(tmp_path / "parts.parquet").num_row_groups == 3


@pytest.mark.parametrize(
    ("column", "expected"),
    [("actual_q_0", "rad"), ("actual_qd_5", "rad/s"), ("ft_fx", "N"), ("ft_tz", "Nm"),
     ("imu_gy", "rad/s"), ("actual_TCP_force_2", "N"), ("actual_TCP_force_3", "Nm"),
     ("target_moment_0", "Nm"), ("payload_cog_1", "m"), ("payload", "kg")],
)  # fmt: skip
def test_units(column: str, expected: str) -> None:
    assert unit(column) == expected


def test_a_force_is_in_newtons_and_its_torque_in_newton_metres(tmp_path: Path) -> None:
    forces = pd.DataFrame({"time": [0.0], "Fmap_Fx": [1.0], "Fmap_std_nx": [0.1], "pose_3": [0.2]})
    given = {"Fmap_Fx": "N, Nm", "Fmap_std_nx": "N, Nm", "pose_3": "m, rad"}
    write_table(forces, tmp_path / "forces.parquet", given)
    assert [*read_units(tmp_path / "forces.parquet").values()] == ["s", "N", "Nm", "rad"]


def test_a_given_unit_comes_before_that_of_the_channel(table: pd.DataFrame, tmp_path: Path) -> None:
    path, given = tmp_path / "signals.parquet", {"something": "1", "actual_q_0": "deg"}
    write_table(table.assign(something=0.0), path, given)
    units = {field.name: field.metadata[b"unit"].decode() for field in pq.read_schema(path)}
    assert units["something"] == "1"
    assert (units["actual_q_0"], units["actual_q_1"], units["time"]) == ("deg", "rad", "s")


def test_a_channel_is_its_columns_in_order(table: pd.DataFrame) -> None:
    np.testing.assert_array_equal(channel(table, "actual_q"), np.arange(30).reshape(5, 6))


def test_a_failed_write_leaves_the_old_file_and_no_other(tmp_path: Path) -> None:
    path = tmp_path / "tables" / "result.json"
    write_json({"value": 1}, path)
    with pytest.raises(TypeError):
        write_json({"value": object()}, path)
    with pytest.raises(ValueError, match="no known unit"):
        write_table(pd.DataFrame({"nonsense": [1.0]}), path)
    assert read_json(path) == {"value": 1}
    assert [file.name for file in path.parent.iterdir()] == ["result.json"]


def test_what_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "results").write_text("a file where a folder should be")
    with pytest.raises(InputError, match=r"report.html cannot be written \(File exists\); check"):
        write_text("text", tmp_path / "results" / "report.html")


@pytest.mark.parametrize("rows", [7, 40, 1000])
def test_numbers_are_written_as_pandas_writes_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: int
) -> None:
    monkeypatch.setattr(tables, "ROWS", rows)  # that are written at once
    numbers = np.random.default_rng(3).standard_normal((40, 3)) * [1e-9, 1.0, 1e9]
    numbers[5, 1], numbers[6, 0], numbers[7, 2] = np.nan, np.inf, -np.inf
    table = pd.DataFrame(numbers, columns=["time [s]", 'a, "b"', "nan"])
    write_csv(table, tmp_path / "table.csv")
    assert (tmp_path / "table.csv").read_text() == table.to_csv(index=False, float_format="%.9g")


@pytest.mark.parametrize("write", [write_table, write_csv, write_json, write_text])
def test_a_full_disk_leaves_the_old_file_and_no_half_one(
    tmp_path: Path, write: Callable[[object, Path], None]
) -> None:
    path, old = tmp_path / "file", b"what was there before"
    path.write_bytes(old)
    long = {write_json: [0.1] * 9000, write_text: "long " * 9000}
    table = pd.DataFrame({"time": np.random.default_rng(0).random(9000)})
    with full_disk(), pytest.raises(InputError, match=r"file cannot be written .*; check .*disk"):
        write(long.get(write, table), path)
    assert [(file.name, file.read_bytes()) for file in tmp_path.iterdir()] == [("file", old)]


def test_a_file_is_on_the_disk_before_it_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else a power failure leaves the name without its content."""
    path, flushed = tmp_path / "x.json", list[tuple[str, bool]]()

    def fsync(number: int) -> None:
        flushed.append((Path(f"/proc/self/fd/{number}").read_text(), path.exists()))

    monkeypatch.setattr("os.fsync", fsync)
    write_json([1], path)
    assert flushed == [(path.read_text(), False)]


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "cut": lambda data: data[: len(data) // 2],
    "zeros": lambda data: bytes(len(data)),
}
READERS: dict[str, list[Callable[[Path], object]]] = {
    "x.parquet": [read_table, read_units, read_footer, lambda path: read_columns(path, ["time"])],
    "x.csv": [read_csv, read_cells],
    "x.json": [read_json, lambda path: read_record(dict[str, list[float]], path)],
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("name", READERS)
def test_a_damaged_result_is_named_with_the_command_that_makes_it_anew(
    table: pd.DataFrame, tmp_path: Path, name: str, damage: str
) -> None:
    path = tmp_path / "a study" / name
    write_table(table, path.with_suffix(".parquet"))
    write_csv(table, path.with_suffix(".csv"))
    write_json({"time": table["time"].to_numpy()}, path.with_suffix(".json"))
    for read in READERS[name]:
        read(path)
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    for read in READERS[name]:
        with pytest.raises(InputError) as stop:
            read(path)
        sentence = str(stop.value)
        assert sentence.startswith(f"{path} is damaged (")
        assert sentence.endswith(f"(rm '{path}'), and `ur5 run` the study again")
        assert "\n" not in sentence


def test_pages_cut_out_of_a_table_are_damage(table: pd.DataFrame, tmp_path: Path) -> None:
    """Its footer, at the end, is whole."""
    path = tmp_path / "x.parquet"
    write_table(table, path)
    content = path.read_bytes()
    path.write_bytes(content[:4] + bytes(100) + content[104:])
    with pytest.raises(InputError, match="is damaged"):
        read_columns(path, ["time"], footer=read_footer(path))


@contextmanager
def full_disk() -> Iterator[None]:
    """As if only 20 kB were left on any disk."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@settings(max_examples=50)
@given(st.lists(st.from_regex(r"\A[A-Za-z0-9_-][A-Za-z0-9_.-]*\Z"), min_size=1))
@example(["nan", "null", "NA", "None"])
@example(["1e5", "1", "007"])
@example(["True", "false"])
@example(["false"])  # the only kind of alarm of a study
def test_names_come_back_as_they_are(names: list[str]) -> None:
    with TemporaryDirectory() as folder:
        table = pd.DataFrame({"recording": names, "kind": names, "mae": np.nan})
        write_csv(table, Path(folder, "mae.csv"))
        found = read_csv(Path(folder, "mae.csv"))
    assert [*found["recording"]] == [*found["kind"]] == names
    assert found["mae"].isna().all()


def test_missing_numbers_are_null_and_empty(tmp_path: Path) -> None:
    write_json({"a": np.array([1.0, np.nan]), "b": [float("inf")]}, tmp_path / "x.json")
    assert read_json(tmp_path / "x.json") == {"a": [1.0, None], "b": [None]}
    write_csv(pd.DataFrame({"mae": [0.123456789012, None]}), tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == 'mae\n0.123456789\n""\n'


@dataclass
class Measured:
    value: float
    interval: tuple[float, float]
    by_name: dict[str, float] | None
    expected: float | None


def test_an_unknown_number_of_a_record_is_read_as_nan_or_as_none_where_that_is_declared(
    tmp_path: Path,
) -> None:
    write_json(Measured(np.nan, (np.inf, 2.0), {"a": np.nan}, None), tmp_path / "x.json")
    found = read_record(Measured, tmp_path / "x.json")
    expected = {"value": np.nan, "interval": (np.nan, 2.0), "by_name": {"a": np.nan}}
    np.testing.assert_equal(vars(found), expected | {"expected": None})


def test_a_summary_of_another_version_is_refused_with_its_place(tmp_path: Path) -> None:
    write_json({"a": [1.0, "b"]}, tmp_path / "old.json")
    assert read_record(dict[str, list[object]], tmp_path / "old.json") == {"a": [1.0, "b"]}
    with pytest.raises(InputError, match=r"old\.json: a → 1 .* `ur5 run` the study again"):
        read_record(dict[str, list[float]], tmp_path / "old.json")


def test_a_new_file_never_replaces_another_that_came_while_it_was_written(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"

    def write(aside: Path) -> None:
        aside.write_text("second")
        write_new_text("first", path)  # by another process, from its start to its end

    with pytest.raises(NameTaken, match=r"mine\.yaml exists; name another"):
        write_new(path, write)
    assert path.read_text() == "first"
    assert [*tmp_path.iterdir()] == [path]


@pytest.mark.parametrize("taken", [False, True])
def test_a_new_file_on_a_disk_without_links(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, taken: bool
) -> None:
    """As FAT32 says so."""

    def refused(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr("os.link", refused)
    path = tmp_path / "mine.yaml"
    if taken:
        path.write_text("first")
    with pytest.raises(NameTaken) if taken else nullcontext():
        write_new_text("second", path)
    assert path.read_text() == ("first" if taken else "second")
    assert [*tmp_path.iterdir()] == [path]
