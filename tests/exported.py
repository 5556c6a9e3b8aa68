"""Exported recordings, read back by the formats' own libraries, as tables by name."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy.io
from mcap.reader import make_reader

from ur5lib.commands.convert import channels
from ur5lib.finished import FinishedStudy

Tables = dict[str, pd.DataFrame]  # `time` as index, units in attrs["units"]


def from_mat(path: Path, columns: dict[str, list[str]]) -> Tables:
    """columns: of each table, which structures hold channel by channel."""
    content = scipy.io.loadmat(path, simplify_cells=True)
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
