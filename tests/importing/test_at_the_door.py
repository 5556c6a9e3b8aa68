"""What is wrong at the door, a file or a fault of ours, is one sentence and never a traceback."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import ur5lib
from tests.command import Command
from tests.stored_files import frame, made_up_channels
from ur5lib.errors import InputError
from ur5lib.importing import files
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.importing.parted_runs import runs_of


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("log")
    time, channels = made_up_channels(folder)
    kept = {name: channels[name] for name in ("actual_q", "actual_qd", "actual_current")}
    frame(time, kept).rename(columns={"time": "timestamp"}).to_csv(folder / "log.csv", index=False)
    return folder / "log.csv"


@pytest.fixture
def broken(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: object) -> None:
        raise ZeroDivisionError("three lines\nand a traceback")

    monkeypatch.setattr(files, "propose", fail)


@pytest.mark.usefixtures("broken")
def test_a_fault_of_ours_is_a_sentence_with_its_place(run_ur5: Command, log: Path) -> None:
    answer = run_ur5("import", log, "--robot", "ur5")
    assert answer.status == 1
    assert "Traceback" not in answer.line
    assert "a fault of ours, in ur5lib/importing/files.py:" in answer.line
    with pytest.raises(InputError, match=r"a fault of ours, in ur5lib/importing/files\.py:\d+"):
        ur5lib.read(log, "ur5")


def test_a_fault_with_one_file_leaves_the_others(
    log: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    other, whole = tmp_path / "other.csv", files.propose
    pd.read_csv(log).filter(regex="stamp|actual_q").to_csv(other, index=False)
    monkeypatch.setattr(files, "propose", lambda file: whole(file) if file.path == log else 1 / 0)
    found = import_files([log, other], UserStatement("ur5"))
    assert [one.entry["name"] for one in found] == ["log"]
    assert "other.csv: a fault of ours" in found.refused[0]


@pytest.mark.parametrize("robot", ["ur5", ""])
def test_seven_columns_under_a_wrench_s_name_are_no_wrench(
    log: Path, tmp_path: Path, robot: str
) -> None:
    table = pd.read_csv(log)
    for k in range(7):
        table[f"TCPWrench_{k}"] = np.sin(table["timestamp"] + k)
    for name in ("actual_q", "actual_qd", "actual_current"):
        table[f"{name}_6"] = 0.1 * np.sin(table["timestamp"])
    table.to_csv(tmp_path / "seven.csv", index=False)
    (found,) = import_files([tmp_path / "seven.csv"], UserStatement(robot))
    (row,) = (row for row in found.account if "TCPWrench" in row.subject)
    assert row.confidence == "left out"
    assert "external joint torques" in row.reason


def write_cameras(folder: Path) -> Path:
    """A bag with forty messages of kinds that are not read, and none of joints."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    text = store.types["std_msgs/msg/String"]("ready")
    with Writer(folder / "run", version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        for name in ("/state", "/camera/info"):
            topic = bag.add_connection(name, text.__msgtype__, typestore=store)
            for k in range(20):
                bag.write(topic, 10_000_000 * k, store.serialize_cdr(text, text.__msgtype__))
    return folder / "run"


def test_no_file_with_messages_holds_nothing(tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        import_files([write_cameras(tmp_path)])
    for seen in ("/state (std_msgs/msg/String, 20)", "/camera/info (std_msgs/msg/String, 20)"):
        assert seen in str(error.value)
    assert "holds nothing" not in str(error.value)


def test_arrays_without_rows_are_seen(tmp_path: Path, log: Path) -> None:
    table = pd.read_csv(log)
    rows = {n: table.filter(regex=rf"{n}_\d").to_numpy() for n in ("actual_q", "actual_qd")}
    others = {"valid": np.ones(len(table), bool), "camera": np.zeros((9, 4, 4))}
    np.savez(tmp_path / "run.npz", time=table["timestamp"], **rows, **others)
    (found,) = import_files([tmp_path / "run.npz"], UserStatement("ur5"))
    (row,) = (row for row in found.account if "camera" in row.subject)
    assert "camera (9 × 4 × 4)" in row.subject
    assert f"valid ({len(table):,})" in row.subject
    assert row.confidence == "left out"


def test_a_numpy_file_is_what_its_csv_is(tmp_path: Path, log: Path) -> None:
    table = pd.read_csv(log)
    np.save(tmp_path / "log.npy", table.to_numpy())
    table.to_csv(tmp_path / "nameless.csv", index=False, header=False)
    np.save(tmp_path / "named.npy", table.to_records(index=False))
    same = import_files([tmp_path / "log.npy", tmp_path / "nameless.csv"], UserStatement("ur5"))
    ignored = {"name", "file", "after"}
    first, second = ({k: v for k, v in one.entry.items() if k not in ignored} for one in same)
    assert first == second
    (named,) = import_files([tmp_path / "named.npy"], UserStatement("ur5"))
    assert named.entry["format"] == "rtde-csv"
    np.save(tmp_path / "objects.npy", np.array([{}], object), allow_pickle=True)
    with pytest.raises(InputError, match="Python objects"):
        import_files([tmp_path / "objects.npy"])


@pytest.mark.parametrize("inner", [",", " "])
@pytest.mark.parametrize("named", [True, False])
def test_two_separators_at_once(tmp_path: Path, log: Path, inner: str, named: bool) -> None:
    table = pd.read_csv(log)
    blocks = [f"actual_{n}" for n in ("q", "qd", "current")]
    values = {name: table.filter(regex=rf"{name}_\d").to_numpy() for name in blocks}
    lines = ["timestamp;" + ";".join(blocks)] if named else []
    lines += [
        ";".join([f"{now:.9g}", *(inner.join(f"{x:.9g}" for x in values[n][k]) for n in blocks)])
        for k, now in enumerate(table["timestamp"])
    ]
    (tmp_path / "two.csv").write_text("\n".join(lines) + "\n")
    (found,) = import_files([tmp_path / "two.csv"], UserStatement("ur5"))
    assert found.entry["columns"] == ["time", *blocks] if not named else True
    taken = {row.taken_for for row in found.account}
    assert {"actual_q", "actual_qd", "actual_current"} <= taken


def test_the_folder_of_a_lerobot_data_set_is_its_data(tmp_path: Path, log: Path) -> None:
    table = pd.read_csv(log)
    data = tmp_path / "set" / "data" / "chunk-000"
    data.mkdir(parents=True)
    (tmp_path / "set" / "meta").mkdir()
    motors = {"names": [f"joint_{k}.pos" for k in range(6)], "dtype": "float32"}
    info = {"codebase_version": "v3.0", "features": {"observation.state": motors}}
    (tmp_path / "set" / "meta" / "info.json").write_text(json.dumps(info))
    state = [*table.filter(regex=r"actual_q_\d").to_numpy()]
    rows = {"timestamp": table["timestamp"], "observation.state": state}
    pd.DataFrame(rows).to_parquet(data / "file-000.parquet")
    (found,) = import_files(runs_of([tmp_path / "set"]), UserStatement("ur5"))
    assert found.entry["file"] == "file-000.parquet"
    assert "actual_q" in found.entry["channels"]
