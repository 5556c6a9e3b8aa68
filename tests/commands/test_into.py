"""`ur5 convert --into`: copies of recordings in their own layout, with the force in each row."""

import json
import shutil
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
from tests.command import Command
from tests.in_memory import FREE, put_recordings, simulated
from tests.stored_files import JOINTS, WRITERS, Channels, write_bag
from ur5lib.commands import copies
from ur5lib.commands.copies import write_copy
from ur5lib.commands.exported_model import results_of
from ur5lib.commands.into import Copier, Fit, with_topics
from ur5lib.errors import InputError
from ur5lib.importing.episodes import Episodes
from ur5lib.recordings.rosbag import typestore
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.tables import read_table
from ur5lib.timeseries.metrics import NORMAL95

Contents = dict[str, Any]  # of a file, by the name of an array, a column, or a topic
STD = [f"Fmap_std_{part}" for part in ("Fx", "Fy", "Fz", "nx", "ny", "nz")]
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
    return with_topics(ur5lib.fit(free), "fit to free1, free2", free._study.recordings)


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


def put_episodes(folder: Path, table: pd.DataFrame) -> Path:
    """Two episodes in one file, each a recording of its own."""
    path = put_lists(folder, table)
    whole = pd.read_parquet(path)
    whole.assign(episode_index=np.arange(len(whole)) // (len(whole) // 2 + 1)).to_parquet(path)
    return path


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
    "episodes": put_episodes,
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
    Copier(given, read).copy(source, target)
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
    if given.causal:  # where there is that topic
        assert np.isfinite(wrenches(target, "live")).all()
    again = ur5lib.read(target, "ur5e", role="contact")
    assert entry(again) == entry(runs)
    with pytest.raises(InputError, match="copy its original"):
        write_copy(again._study.recordings[0], tmp_path / "again", [], {"version": ""})


def test_what_an_arm_did_before_is_known_where_files_follow_one_another(
    ur5e: Robot, given: Fit, tmp_path: Path
) -> None:
    """As where all are read together; alone, it is not known how friction begins."""
    points = [[0.5, -1.6, 1.6, -1.5, 1.5, 0.3], [0.1, -1.2, 1.3, -1.2, 1.2, -0.1]]
    moves = {"kind": "movej", "pause_s": 0.5, "way_points": points}
    plan = SimulatedRecording(trajectory=moves, seconds=6.0)
    simulate(ur5e, plan, "rtde-csv", tmp_path / "raw", tmp_path / "truth")
    rows = pd.read_csv(tmp_path / "raw" / "robot.csv")[::4]
    still = np.flatnonzero((rows.filter(like="target_qd_") == 0).all(axis=1))
    pause = np.split(still, np.flatnonzero(np.diff(still) > 1) + 1)[1]
    middle = pause[len(pause) // 2]
    files = [tmp_path / f"part_{k}.csv" for k in (1, 2)]
    rows[: middle + 1].to_csv(files[0], index=False)
    rows[middle:].to_csv(files[1], index=False)
    together = ur5lib.read(files, "ur5e", role="contact")
    copier = Copier(given, Episodes(ur5lib.read_arm("ur5e")))
    for path in files:
        copier.copy(path, tmp_path / "copies" / path.name)
    copier.copy(files[1], tmp_path / "alone" / "part_2.csv")  # it does not follow itself
    after, alone = (wrenches(tmp_path / n / "part_2.csv", "Fmap_std") for n in ("copies", "alone"))
    expected = given.model.estimate(together).loc["part_2", STD].to_numpy()
    np.testing.assert_array_equal(after, expected)
    expected = given.model.estimate(ur5lib.read(files[1], "ur5e", role="contact"))[STD].to_numpy()
    np.testing.assert_array_equal(alone, expected)
    assert not np.array_equal(after, alone)


def test_a_folder_is_copied_and_goes_on_where_it_was_killed(
    folder: Path, tmp_path: Path, run_ur5: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What cannot be read is named, and left out; what a killed process left is removed."""
    raw, into = tmp_path / "raw", tmp_path / "copies"
    rows = pd.read_csv(folder / "pushed.csv")
    for name in ("day_1/run_1", "day_1/run_2", "day_2/run_1"):
        (raw / name).parent.mkdir(parents=True, exist_ok=True)
        rows.to_csv(raw / f"{name}.csv", index=False)
    (raw / "day_1/torn.h5").write_bytes(b"\x89HDF")
    (raw / "notes.md").touch()
    command = "convert", "--robot", "ur5e", "--into", into
    write, made = copies.write_csv, list[Path]()

    def killed(recording: Any, aside: Path, rows: Any) -> None:
        write(recording, aside, rows)
        made.append(aside)
        if len(made) == 2:
            aside.rename(aside.with_name(".run_2.csv.1-0.part"))
            raise KeyboardInterrupt

    monkeypatch.setitem(copies.WRITERS, ".csv", killed)
    answer = run_ur5(*command, raw)
    assert answer.status == 130
    assert "--resume makes the others" in answer.err
    assert (into / "day_1/.run_2.csv.1-0.part").exists()
    assert not (into / "day_1/run_2.csv").exists()
    first = (into / "day_1/run_1.csv").stat().st_mtime_ns
    monkeypatch.setitem(copies.WRITERS, ".csv", write)
    assert "go on with --resume" in run_ur5(*command, raw).err
    answer = run_ur5(*command, "--resume", raw)
    assert answer.status == 1
    assert "2 copies, 1 were there" in answer.out
    assert "no fit" in answer.out
    assert f"left out: 1 {raw / 'day_1/torn.h5'}" in answer.line
    assert (into / "day_1/run_1.csv").stat().st_mtime_ns == first
    found = sorted(path.relative_to(into) for path in into.rglob("*") if path.is_file())
    expected = ["day_1/run_1.csv", "day_1/run_2.csv", "day_2/run_1.csv", "ur5lib.json"]
    assert found == [*map(Path, expected)]
    (raw / "day_1/torn.h5").unlink()
    assert "3 were there" in run_ur5(*command, "--resume", raw).out
    answer = run_ur5(*command[:-1], into, "--resume", "--fit", "run_2*", raw)
    assert "has copies with the study 'no fit" in answer.err


def test_a_wrong_call_changes_nothing(folder: Path, tmp_path: Path, run_ur5: Command) -> None:
    source, into = tmp_path / "run.csv", tmp_path / "copies"
    shutil.copy(folder / "pushed.csv", source)
    before = source.read_bytes()
    for words, answer in [
        (("--robot", "ur5e", "--into", tmp_path, source), "would be replaced"),
        (("--into", into, source), "or the arm by --robot"),
        (("--robot", "ur5e", "--into", into, "--fit", "no*", source), "none of 1 file matches"),
        (("--robot", "ur5e", "--into", into, tmp_path / "no.csv"), "does not exist"),
        (("--robot", "ur5e", "--into", into, source, folder / "run.mat"), "does not exist"),
        (("--robot", "ur5e", "--into", into, "--accept", "order", source), "a kind and why"),
        (("--robot", "ur5e", source), "belong to --into"),
    ]:
        told = run_ur5("convert", *words)
        assert told.status == 1
        assert answer in told.err
    assert source.read_bytes() == before
    assert [*tmp_path.iterdir()] == [source]


def test_a_study_estimates_as_its_model_does_and_reads_its_files_as_it_says(
    folder: Path, given: Fit, tmp_path: Path, run_ur5: Command
) -> None:
    """A recording of the fit is estimated by the fit without its path."""
    files = [folder / name for name in ("pushed.csv", FREE[0])]
    copier = Copier(given, Episodes(ur5lib.read_arm("ur5e"), given.entries))
    for path in files:
        copier.copy(path, tmp_path / "by_model" / path.name)
    with results_of(given.model, "live") as results:
        answer = run_ur5("convert", results, *files, "--into", tmp_path / "by_study")
        assert answer.status == 0, answer.err
        study = ur5lib.load(results)
        forces = study.model("ur5e").estimate(ur5lib.read(files[0], "ur5e", role="contact"))
    for path in files:
        one, other = (contents(tmp_path / by / path.name) for by in ("by_model", "by_study"))
        np.testing.assert_equal(one, other)
    np.testing.assert_array_equal(
        wrenches(tmp_path / "by_study" / "pushed.csv", "Fmap_std"), forces[STD].to_numpy()
    )


def test_the_load_of_a_gripper_may_be_another_in_each_file(
    ur5e: Robot, given: Fit, tmp_path: Path
) -> None:
    """What is held throughout is taken off, and said; it is no contact."""
    copier, read = Copier(given, Episodes(ur5lib.read_arm("ur5e"))), dict[str, Contents]()
    for name, load in {"empty": None, "loaded": {"mass": 2.5}}.items():
        moves = {"kind": "fourier", "draw": 3, "period_s": 10}
        plan = SimulatedRecording(trajectory=moves, seconds=10.0, undeclared_payload=load)
        simulate(ur5e, plan, "rtde-csv", tmp_path / name, tmp_path / f"{name}.truth")
        rows = pd.read_csv(tmp_path / name / "robot.csv")[::4]
        source, target = PUT["npz"](tmp_path / name, rows), tmp_path / "copies" / f"{name}.npz"
        copier.copy(source, target)
        read[name] = contents(target)
        assert not read[name]["ur5lib/contact_Fmap"].any()
    about = {name: json.loads(str(own["ur5lib/about"])) for name, own in read.items()}
    assert "remarks" not in about["empty"]
    assert "kg" in about["loaded"]["remarks"]


@pytest.mark.parametrize("fitted", [True, False], ids=["fit", "no fit"])
def test_bands_have_the_true_force_and_nothing_else_is_a_contact(
    fitted: bool, folder: Path, given: Fit, tmp_path: Path
) -> None:
    """Of a simulated arm, also where nothing without contact was recorded."""
    read = Episodes(ur5lib.read_arm("ur5e"))
    files = [folder / name for name in ("pushed.csv", "free2.csv")]
    used = given if fitted else with_topics(ur5lib.fit(read(files[0])), "no fit")
    copier = Copier(used, read)
    for path in files:
        copier.copy(path, tmp_path / path.name)
        truth = read_table(Path(simulated().name) / path.stem / "truth.parquet")
        time = pd.read_csv(path)["timestamp"].to_numpy()
        true = truth[[f"wrench_{k}" for k in range(6)]].to_numpy()
        own = truth["time"].to_numpy()
        force = np.array([np.interp(time - time[0], own, column) for column in true.T]).T
        is_live = fitted and bool(given.causal)
        estimates = ("Fmap", "live") if is_live else ("Fmap",)
        for name in estimates:
            touched = force.any(axis=1)
            wrench, std = (wrenches(tmp_path / path.name, n) for n in (name, f"{name}_std"))
            stated = contents(tmp_path / path.name)[f"ur5lib_contact_{name}"] == "1"
            assert not stated[~near(touched)].any()
            if touched.any():
                assert stated[touched].any()
                within = np.abs(wrench - force)[touched] <= NORMAL95 * std[touched]
                assert within.mean() >= 0.9
    assert ("ur5lib_live_Fx" in contents(tmp_path / "pushed.csv")) == is_live


def near(touched: np.ndarray) -> np.ndarray:
    """Where there is a contact within a fifth of a second."""
    return np.convolve(touched, np.ones(51), "same") > 0
