"""`ur5 convert --into`: copies of recordings in their own layout, with the force in each row."""

import json
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Writer as BagWriter
from rosbags.typesys import Stores, get_typestore

import ur5lib
from tests.in_memory import FREE, put_recordings
from tests.stored_files import JOINTS, WRITERS, Channels, write_bag
from ur5lib.commands.into import Fit, convert, with_topics
from ur5lib.importing.episodes import Episodes
from ur5lib.recordings.rosbag import typestore

Contents = dict[str, Any]  # of a file, by the name of an array, a column, or a topic
ROWS = 625  # of 5 s; the arm is pushed from 3 s on


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("episodes")
    put_recordings(folder)
    pushed = pd.read_csv(folder / "pushed.csv")[:ROWS]
    pushed.to_csv(folder / "pushed.csv", index=False)
    return folder


@pytest.fixture(scope="module")
def given(folder: Path) -> Fit:
    free = ur5lib.read([folder / name for name in FREE], "ur5e")
    return with_topics(ur5lib.fit(free), "fit to free1, free2")


def channels_of(table: pd.DataFrame) -> Channels:
    names = "actual_q", "actual_qd", "actual_current"
    return {name: table[[f"{name}_{k}" for k in range(6)]].to_numpy() for name in names}


def put_csv(folder: Path, table: pd.DataFrame) -> Path:
    path = folder / "run.csv"
    table.to_csv(path, index=False, lineterminator="\r\n")
    return path


def put_bare_table(folder: Path, table: pd.DataFrame) -> Path:
    """As a spreadsheet of Europe writes numbers, with the clock in milliseconds."""
    rows = np.column_stack([table["timestamp"], *channels_of(table).values()])
    path = folder / "run.csv"
    names = ["time", *(f"{n}_{k}" for n in channels_of(table) for k in range(6))]
    pd.DataFrame(rows, columns=names).to_csv(path, index=False, sep=";", decimal=",")
    return path


def put_stored(kind: str) -> Callable[[Path, pd.DataFrame], Path]:
    def put(folder: Path, table: pd.DataFrame) -> Path:
        name, write = WRITERS[kind]
        write(folder / name, table["timestamp"].to_numpy(), channels_of(table))
        return folder / name

    return put


def put_lists(folder: Path, table: pd.DataFrame) -> Path:
    """As LeRobot does: a list for each row."""
    named = {"timestamp": table["timestamp"].to_numpy()}
    own = {f"observation.{n}": [*rows] for n, rows in channels_of(table).items()}
    pd.DataFrame(named | own).to_parquet(folder / "run.parquet")
    return folder / "run.parquet"


def put_bag_folder(folder: Path, table: pd.DataFrame) -> Path:
    """A bag with its description, and with a topic of a kind that nobody reads."""
    store, path = get_typestore(Stores.ROS2_HUMBLE), folder / "run"
    write_bag(folder / "one.db3", table["timestamp"].to_numpy(), channels_of(table))
    with (
        AnyReader([folder / "one.db3"], default_typestore=store) as bag,
        BagWriter(path, version=9) as writer,
    ):
        topics = {
            one.id: writer.add_connection(one.topic, one.msgtype, typestore=store)
            for one in bag.connections
        }
        said = writer.add_connection("/said", "std_msgs/msg/String", typestore=store)
        kind = store.types["std_msgs/msg/String"]
        for connection, time, data in bag.messages():
            writer.write(topics[connection.id], time, data)
            writer.write(said, time, store.serialize_cdr(kind("on"), kind.__msgtype__))
    (folder / "one.db3").unlink()
    return path


def put_json(folder: Path, table: pd.DataFrame) -> Path:
    """States of joints as Foxglove has them, with an attachment."""
    path = folder / "run.mcap"
    fields = dict(zip(("position", "velocity", "effort"), channels_of(table).values(), strict=True))
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("foxglove.JointStates", "jsonschema", b"{}")
        topic = writer.register_channel("/states", "json", schema, {"by": "me"})
        for row, time in enumerate(table["timestamp"]):
            joints = [
                {"name": n, **{key: own[row, k] for key, own in fields.items()}}
                for k, n in enumerate(JOINTS)
            ]
            stamp = dict(zip(("sec", "nsec"), divmod(round(1e9 * time), 10**9), strict=True))
            message = {"timestamp": stamp, "joints": joints}
            now = round(1e9 * time)
            writer.add_message(topic, now, json.dumps(message).encode(), now + 1, row)
        writer.add_attachment(1, 1, "notes", "text/plain", b"hand-led")
        writer.add_metadata("who", {"operator": "7"})
        writer.finish()
    return path


PUT: dict[str, Callable[[Path, pd.DataFrame], Path]] = {
    "rtde": put_csv,
    "table": put_bare_table,
    "hdf5": put_stored("hdf5"),
    "npz": put_stored("npz"),
    "parquet": put_stored("parquet"),
    "lists": put_lists,
    "db3": put_stored("rosbag"),
    "bag": put_bag_folder,
    "mcap": put_stored("rosbag mcap"),
    "outputs": put_stored("rosbag outputs"),
    "json": put_json,
}


def of_csv(path: Path) -> Contents:
    text = path.read_bytes().decode()
    mark = ";" if ";" in text else ","
    rows = [line.rstrip("\r\n").split(mark) for line in text.splitlines()]
    return {name: np.array(column) for name, *column in zip(*rows, strict=True)}


def of_hdf5(path: Path) -> Contents:
    found = dict[str, Any]()
    with h5py.File(path) as file:
        file.visititems(lambda n, own: found.update({n: own[()]} if hasattr(own, "dtype") else {}))
    return found


def of_npz(path: Path) -> Contents:
    with np.load(path) as archive:
        return {name: archive[name] for name in archive}


def of_parquet(path: Path) -> Contents:
    table = pq.read_table(path)
    return {name: np.array(table.column(name).to_pylist()) for name in table.column_names}


def of_bag(path: Path) -> Contents:
    found = defaultdict[str, list[Any]](list)
    with AnyReader([path], default_typestore=typestore()) as bag:
        for connection, time, data in bag.messages():
            found[connection.topic].append((time, bytes(data)))
    return found


def of_mcap(path: Path) -> Contents:
    """Messages by topic, and all else that a file has."""
    found = defaultdict[str, list[Any]](list)
    with path.open("rb") as file:
        reader = make_reader(file)
        for schema, channel, one in reader.iter_messages(log_time_order=False):
            kind = (schema.name, schema.data) if schema else ()
            own = one.log_time, one.publish_time, one.sequence, one.data
            found[channel.topic].append((kind, channel.metadata, own))
        found["attachments"] += [(one.name, one.data) for one in reader.iter_attachments()]
        found["metadata"] += [
            (one.name, one.metadata) for one in reader.iter_metadata() if one.name != "ur5lib"
        ]
    return found


def contents(path: Path) -> Contents:
    """What a file has, by the library of its format."""
    by_ending = {".csv": of_csv, ".h5": of_hdf5, ".npz": of_npz, ".parquet": of_parquet}
    return (by_ending | {".mcap": of_mcap}).get(path.suffix, of_bag)(path)


def wrenches(path: Path, name: str) -> np.ndarray:
    """The wrench (N, 6) that was added under a name."""
    own, parts = contents(path), ("Fx", "Fy", "Fz", "nx", "ny", "nz")
    if path.suffix in (".h5", ".npz"):
        return own[f"ur5lib/{name}"]
    if f"ur5lib_{name}" in own:
        return own[f"ur5lib_{name}"]
    if f"ur5lib_{name}_Fx" in own:
        cells = np.array([own[f"ur5lib_{name}_{part}"] for part in parts]).T
        if cells.dtype.kind == "U":
            cells = np.char.replace(cells, ",", ".")
        return cells.astype(float)
    if "/ur5lib/estimates" in own:
        texts = [json.loads(data) for *_, (*_, data) in own["/ur5lib/estimates"]]
        return np.array([[one[f"{name}_{part}"] for part in parts] for one in texts])
    store, kind = typestore(), "geometry_msgs/msg/WrenchStamped"
    raw = [one[-1][-1] if path.suffix == ".mcap" else one[-1] for one in own[f"/ur5lib/{name}"]]
    bodies = [store.deserialize_cdr(one, kind).wrench for one in raw]
    return np.array(
        [
            [getattr(getattr(one, h), a) for h in ("force", "torque") for a in "xyz"]
            for one in bodies
        ]
    )


def entry(runs: ur5lib.Recordings) -> dict[str, Any]:
    """How a file is read, without where it lies, and the columns that are left out at its end."""
    own = runs._study.recordings[0].model_dump() | {"folder": ""}
    columns = own.pop("columns", [])
    while columns and columns[-1] == "-":
        columns.pop()
    return own | {"columns": columns}


@pytest.mark.parametrize("kind", PUT)
def test_a_copy_has_all_that_its_original_has_and_the_force(
    kind: str, folder: Path, given: Fit, tmp_path: Path
) -> None:
    source = PUT[kind](tmp_path, pd.read_csv(folder / "pushed.csv"))
    before, target = contents(source), tmp_path / "copy" / source.name
    read = Episodes(ur5lib.read_arm("ur5e"))
    runs = read(source)
    convert(source, target, given, read)
    assert sorted(one.name for one in target.parent.iterdir()) == [target.name]
    after = contents(target)
    for name, own in before.items():
        np.testing.assert_equal(after[name], own)
    assert {*before} < {*after}
    assert all("ur5lib" in name for name in {*after} - {*before})
    forces = given.model.estimate(runs)
    for name in ("Fmap", "Fmap_std"):
        stated = forces[[f"{name}_{part}" for part in ("Fx", "Fy", "Fz", "nx", "ny", "nz")]]
        np.testing.assert_array_equal(wrenches(target, name), stated.to_numpy())
    assert np.isfinite(wrenches(target, "live")).all()
    assert entry(ur5lib.read(target, "ur5e", role="contact")) == entry(runs)
