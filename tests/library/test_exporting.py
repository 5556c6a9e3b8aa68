"""Recordings of a finished study as MAT, CSV and MCAP: the same numbers, with units.

They are read back by the formats' own libraries.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from mcap.reader import make_reader
from scipy.io import loadmat

from ur5lib.commands.convert import EXPORTED_TABLES, channels, write_recordings
from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.tables import columns, write_json, write_table

START = 1_700_000_000.25
TIME = 0.008 * np.arange(5)
WRENCH = [f"Fmap_{axis}" for axis in ("Fx", "Fy", "Fz", "nx", "ny", "nz")]
UNITS = dict.fromkeys([*WRENCH, *columns("predicted_current")], "N, Nm")


Tables = dict[str, pd.DataFrame]  # `time` as index, units in attrs["units"]


def from_mat(path: Path, columns: dict[str, list[str]]) -> Tables:
    """columns: of each table, which structures hold channel by channel."""
    content = loadmat(path, simplify_cells=True)
    return {name: _from_structure(content[name], its) for name, its in columns.items()}


def _from_structure(structure: dict[str, Any], columns: list[str]) -> pd.DataFrame:
    values, units = {}, {"time": structure["units"]["time"]}
    for channel, its in channels(columns).items():
        array = structure[channel].reshape(len(structure["time"]), -1)
        values |= dict(zip(its, array.T, strict=True))
        of_halves = structure["units"][channel].split(", ")
        units |= {column: of_halves[k * len(of_halves) // len(its)] for k, column in enumerate(its)}
    table = pd.DataFrame(values, index=pd.Index(structure["time"], name="time"))
    table.attrs["units"] = units
    return table


def from_csv(folder: Path) -> Tables:
    units = pd.read_csv(folder / "units.csv")
    tables = {}
    for name, own in units.groupby("table"):
        tables[str(name)] = pd.read_csv(folder / f"{name}.csv", index_col="time")
        tables[str(name)].attrs["units"] = dict(zip(own["column"], own["unit"], strict=True))
    return tables


def from_mcap(path: Path) -> tuple[Tables, np.ndarray]:
    """The tables, and the stamps [ns] of all messages in the file's order."""
    rows: dict[str, list[dict[str, float]]] = {}
    units: dict[str, dict[str, str]] = {}
    stamps = []
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            name = channel.topic.removeprefix("/")
            known = json.loads(schema.data)["properties"]
            units[name] = {key: value["description"] for key, value in known.items()}
            row = json.loads(message.data)
            for key, value in row.items():
                assert isinstance(value, bool) == (known[key]["type"] == "boolean")
            rows.setdefault(name, []).append(row | {"time": 1e-9 * message.log_time})
            stamps.append(message.log_time)
    tables = {name: pd.DataFrame(its).set_index("time") for name, its in rows.items()}
    for name, table in tables.items():
        table.attrs["units"] = {"time": "s"} | units[name]
    return tables, np.array(stamps)


def assert_as_in_study(tables: Tables, study: FinishedStudy, name: str, start: float = 0) -> None:
    """Each table has the study's numbers, and a single unit for each column.

    start: what the time counts from [s].
    """
    for part, table in tables.items():
        expected = study.frame(name, part)
        np.testing.assert_allclose(table.index - start, expected.index, atol=1e-6)
        assert table.attrs["units"].keys() == {"time", *expected}
        for column, unit in table.attrs["units"].items():
            assert unit in expected.attrs["units"][column].split(", ")
        found = table.reindex(columns=expected.columns).to_numpy(float)
        np.testing.assert_allclose(found, expected.to_numpy(float), rtol=1e-10, atol=1e-11)


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """Two recordings: one with forces that are partly unknown, one of which nothing is known."""
    random = np.random.default_rng(8)
    head = {"time": TIME, "segment": np.zeros(5, dtype=int)}
    q, wrench = random.normal(size=(5, 6)), random.normal(size=(5, 6))
    wrench[1] = np.nan
    flags = {"interpolated": np.array([False, True, False, False, False])}
    signals = head | flags | dict(zip(columns("actual_q"), q.T, strict=True))
    forces = head | dict(zip(WRENCH, wrench.T, strict=True))
    folder = tmp_path / "results" / "mine"
    for name, own in (("pushed", {"signals": signals, "forces": forces}), ("free", {})):
        for table in EXPORTED_TABLES:
            path = folder / "recordings" / name / f"{table}.parquet"
            write_table(pd.DataFrame(own.get(table, head)), path, UNITS)
    write_table(pd.DataFrame(signals), folder / "recordings" / "free" / "signals.parquet")
    write_json({"start_epoch_s": START}, folder / "recordings" / "pushed" / "quality.json")
    return folder


def exported(results: Path, to: str) -> Path:
    (path,) = write_recordings(results, ["pushed"], to)
    return path


def test_mat_has_the_study_s_numbers(results: Path) -> None:
    study = FinishedStudy(results)
    parts = {part: [*study.frame("pushed", part)] for part in ("signals", "forces")}
    path = exported(results, "mat")
    assert loadmat(path)["start_epoch_s"].item() == START
    tables = from_mat(path, parts)
    assert_as_in_study(tables, study, "pushed")
    assert tables["forces"].attrs["units"]["Fmap_nx"] == "Nm"


def test_csv_has_the_study_s_numbers(results: Path) -> None:
    tables = from_csv(exported(results, "csv"))
    assert tables.keys() == {"signals", "forces"}
    assert_as_in_study(tables, FinishedStudy(results), "pushed")


def test_mcap_has_the_study_s_numbers(results: Path) -> None:
    tables, stamps = from_mcap(exported(results, "mcap"))
    assert tables.keys() == {"signals", "forces"}
    assert_as_in_study(tables, FinishedStudy(results), "pushed", START)
    assert (np.diff(stamps) >= 0).all()


def test_stamps_count_from_the_start_where_that_is_unknown(results: Path) -> None:
    (path,) = write_recordings(results, ["free"], "mcap")
    _, stamps = from_mcap(path)
    np.testing.assert_allclose(1e-9 * stamps, TIME)


@pytest.mark.parametrize(
    ("to", "names"), [("mat", ["free.mat", "pushed.mat"]), ("csv", ["free", "pushed"])]
)
def test_all_recordings_are_written_where_none_is_named(
    results: Path, tmp_path: Path, to: str, names: list[str]
) -> None:
    paths = [*write_recordings(results, [], to, tmp_path / "here")]
    assert paths == [tmp_path / "here" / name for name in names]
    assert all(path.exists() for path in paths)


def test_columns_are_joined_to_channels() -> None:
    names = ["segment", "q_0", "q_1", "ft_fx", "ft_tz", "imu_ax", "imu_ay", "imu_gx", "log_odds_F"]
    joined = {"segment", "q", "ft", "imu_a", "imu_g", "log_odds_F"}
    assert channels(names).keys() == joined
    assert channels(names)["imu_a"] == ["imu_ax", "imu_ay"]


@pytest.mark.parametrize(
    ("names", "to", "message"),
    [
        (["pushd"], "mat", "pushed"),
        ([], "xls", "available: mat, csv, mcap"),
    ],
)
def test_what_is_not_there_is_reported(
    results: Path, names: list[str], to: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        [*write_recordings(results, names, to)]
    assert not (results / "exported").exists()


def test_an_interrupted_export_leaves_nothing(
    results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(path: Path, *_: object, **__: object) -> None:
        path.write_bytes(b"MATLAB")
        raise KeyboardInterrupt

    monkeypatch.setattr("scipy.io.savemat", interrupted)
    with pytest.raises(KeyboardInterrupt):
        exported(results, "mat")
    assert [*(results / "exported").iterdir()] == []
