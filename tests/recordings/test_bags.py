"""Bags of any kind: folders, parts, compressed ones, messages without names or velocities."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from tests.command import Command
from tests.conftest import said
from tests.entries import read_and_check, read_recording
from tests.stored_files import Made, entry_of, made_up_channels, write_bag
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import ImportedRecording, import_files, write_study
from ur5lib.recordings.array_files import LOADERS
from ur5lib.recordings.limits import LIMIT_VARIABLE
from ur5lib.records.account import AccountRow
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Robot
from ur5lib.study.reading import of_each_file, read_study
from ur5lib.study.selection import Selection
from ur5lib.tables import channel, checksum

STORE = get_typestore(Stores.ROS2_HUMBLE)
STATE = STORE.types["sensor_msgs/msg/JointState"]
Joints = tuple[Sequence[str], int, int, int]  # names; how many positions, velocities, efforts


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"))


def message(second: float, joints: Joints) -> bytes:
    names, *widths = joints
    nanoseconds = round(1e9 * second)
    stamp = STORE.types["builtin_interfaces/msg/Time"](*divmod(nanoseconds, 10**9))
    header = STORE.types["std_msgs/msg/Header"](stamp, "base")
    fields = (second + np.arange(float(width)) for width in widths)
    return bytes(STORE.serialize_cdr(STATE(header, [*names], *fields), STATE.__msgtype__))


def write_messages(folder: Path, joints: Sequence[Joints], **settings: Any) -> Path:
    """Write a ROS 2 bag with a message every 10 ms, in turn of each kind of joints."""
    writer = Writer(folder, version=9, storage_plugin=settings.get("plugin", StoragePlugin.SQLITE3))
    if mode := settings.get("mode"):
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer as bag:
        topic = bag.add_connection("/joint_states", STATE.__msgtype__, typestore=STORE)
        for k in range(settings.get("count", 60)):
            raw = message(0.01 * k, joints[k % len(joints)])
            bag.write(topic, 10_000_000 * k, raw)
    return folder


def loaded(path: Path) -> tuple[dict[str, np.ndarray], list[Finding]]:
    findings: list[Finding] = []
    arrays = LOADERS["rosbag"](path, None, findings)
    return {name.rpartition("/")[2]: values for name, values in arrays.items()}, findings


# Messages


@pytest.mark.parametrize("file", ["run.bag", "run.db3"])
def test_messages_without_names_and_velocities_are_read(
    tmp_path: Path, made: Made, file: str
) -> None:
    write_bag(tmp_path / file, made[0], {"actual_q": made[1]["actual_q"]}, names=())
    table = read_recording(entry_of("rosbag", tmp_path / file, ["actual_q"])).robot.table
    np.testing.assert_allclose(channel(table, "actual_q"), made[1]["actual_q"])


def order_of(found: ImportedRecording) -> AccountRow:
    return next(row for row in found.account if row.subject == "the joints' order")


def test_an_order_that_no_message_names_is_not_proven(tmp_path: Path, made: Made) -> None:
    kept = {name: made[1][name] for name in ("actual_q", "actual_qd")}
    for names in ((), [""] * 6):
        write_bag(tmp_path / "run.bag", made[0], kept, names=names)
        (found,) = import_files([tmp_path / "run.bag"], UserStatement("ur5"))
        assert {"actual_q", "actual_qd"} <= found.entry["channels"].keys()
        assert order_of(found).evidence != "name"
        assert order_of(found).confidence == "check"


def test_names_of_another_topic_do_not_doubt_the_arm_s(tmp_path: Path, made: Made) -> None:
    kept = {name: made[1][name] for name in ("actual_q", "actual_qd")}
    wrench = np.ones((len(made[0]), 6))
    write_bag(tmp_path / "run.bag", made[0], kept, wrench=wrench)
    (found,) = import_files([tmp_path / "run.bag"], UserStatement("ur5"))
    assert order_of(found).evidence == "name"


ARM = tuple(f"a{joint}" for joint in range(1, 8))
# kinds of messages in turn; shapes of positions and efforts; positions of the first
MIXED: dict[str, Any] = {
    "seven without names": ([((), 7, 0, 0)], (60, 7), None),
    "a gripper without names": ([((), 7, 7, 7), ((), 1, 1, 1)], (30, 7), (30, 7)),
    "a faster gripper": ([(ARM, 7, 7, 0), (("g",), 1, 1, 1), (("g",), 1, 1, 1)], (20, 7), None),
    "efforts at times": ([(ARM, 7, 7, 7), (ARM, 7, 7, 0), (ARM, 7, 7, 3)], (60, 7), (60, 7)),
    "nothing at times": ([((), 0, 0, 0), ((), 6, 0, 0)], (30, 6), None),
    "names of fewer": ([(ARM[:6], 7, 7, 7)], (60, 7), (60, 7)),
    "nothing at all": ([((), 0, 0, 0)], None, None),
}


@pytest.mark.parametrize("kind", MIXED)
def test_messages_of_different_joints_are_kept_apart(tmp_path: Path, kind: str) -> None:
    joints, q_shape, effort_shape = MIXED[kind]
    arrays, _ = loaded(write_messages(tmp_path / "run", joints))
    shapes = [arrays[n].shape if n in arrays else None for n in ("position", "effort")]
    assert shapes == [q_shape, effort_shape]
    if q_shape:
        assert np.isfinite(arrays["position"]).all()
        step = np.diff(arrays["stamp"])
        np.testing.assert_allclose(
            np.diff(arrays["position"], axis=0), np.tile(step, (q_shape[1], 1)).T
        )
    if effort_shape:
        given = np.array([effort == q_shape[1] for _, q, _, effort in joints if q == q_shape[1]])
        whole = np.isfinite(arrays["effort"]).all(axis=1)
        np.testing.assert_array_equal(whole, np.resize(given, len(whole)))


# Folders and compressed files

COMPRESSED = [
    (plugin, mode)
    for plugin in (StoragePlugin.SQLITE3, StoragePlugin.MCAP)
    for mode in (None, CompressionMode.FILE, CompressionMode.MESSAGE)
]


@pytest.mark.parametrize(("plugin", "mode"), COMPRESSED)
def test_a_bag_of_ros_2_is_its_folder_or_its_file(
    tmp_path: Path, plugin: StoragePlugin, mode: CompressionMode | None
) -> None:
    folder = write_messages(tmp_path / "run", [((), 6, 6, 6)], plugin=plugin, mode=mode)
    (file,) = (path for path in folder.iterdir() if path.suffix != ".yaml")
    assert file.name.endswith(".zstd") is (mode is CompressionMode.FILE)
    expected = 0.01 * np.arange(60)[:, None] + np.arange(6)
    for path in (folder, file):
        np.testing.assert_allclose(loaded(path)[0]["position"], expected)
    (folder / "metadata.yaml").unlink()
    np.testing.assert_allclose(loaded(folder)[0]["position"], expected)


def parted(folder: Path, made: Made, ending: str = ".bag", stem: str = "run") -> Path:
    """Write a recording as eleven bags, numbered from 0, and return their folder."""
    folder.mkdir()
    for k, rows in enumerate(np.array_split(np.arange(len(made[0])), 11)):
        channels = {"actual_q": made[1]["actual_q"][rows]}
        write_bag(folder / f"{stem}_{k}{ending}", made[0][rows], channels)
    return folder


@pytest.mark.parametrize(
    ("ending", "stem"), [(".bag", "run"), (".mcap", "run"), (".bag", "run_2026-01-02-03-04-05")]
)
def test_parts_of_a_bag_are_joined(tmp_path: Path, made: Made, ending: str, stem: str) -> None:
    folder = parted(tmp_path / "run", made, ending, stem)
    table = read_recording(entry_of("rosbag", folder, ["actual_q"])).robot.table
    np.testing.assert_allclose(channel(table, "actual_q"), made[1]["actual_q"])
    (folder / f"{stem}_3{ending}").unlink()
    with pytest.raises(InputError, match=r"holds 10 bags and no metadata\.yaml .*; name one"):
        loaded(folder)


def test_the_description_says_what_belongs_to_a_bag(tmp_path: Path, made: Made) -> None:
    folder = write_messages(tmp_path / "run", [((), 6, 6, 6)])
    (part,) = folder.glob("*.db3")
    shutil.copy(part, folder / "other.db3")
    assert len(loaded(folder)[0]["position"]) == 60
    text = (folder / "metadata.yaml").read_text()
    more = f"  - {part.name}\n  - lost.db3\n"
    (folder / "metadata.yaml").write_text(text.replace(f"  - {part.name}\n", more))
    found = [said(one) for one in loaded(folder)[1]]
    assert len(found) == 2
    assert found[0].endswith("parts that metadata.yaml lists, but that the folder lacks")
    assert "name no joints" in found[1]
    (folder / "metadata.yaml").write_text("rosbag2_bagfile_information: 7\n")
    with pytest.raises(InputError, match=r"holds 2 bags"):
        loaded(folder)


def test_a_sensor_in_a_folder_is_read(tmp_path: Path, made: Made, ur5: Robot) -> None:
    folder, wrench = tmp_path / "run", np.random.default_rng(2).normal(size=(len(made[0]), 6))
    folder.mkdir()
    write_bag(folder / "run.bag", made[0], {"actual_q": made[1]["actual_q"]}, wrench=wrench)
    entry = entry_of("rosbag", folder, ["actual_q"])
    its = {"time": "/wrench/stamp", "ft_f": "/wrench/force", "ft_t": "/wrench/torque"}
    taken = read_and_check(entry | {"force_sensor": {"channels": its}}, ur5, 0.1)
    assert taken.quality.files == {"force": checksum(folder)}
    np.testing.assert_allclose(taken.sensors["force"].drop(columns="time"), wrench)


def test_a_folder_without_a_bag_is_said_to_be_one(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"is a folder without a ROS bag .*; name a file"):
        import_files([tmp_path])


@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_what_unpacks_to_too_much_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: CompressionMode
) -> None:
    folder = write_messages(tmp_path / "run", [((), 300_000, 0, 0)], mode=mode, count=8)
    assert loaded(folder)[0]["position"].shape == (8, 300_000)
    monkeypatch.setenv(LIMIT_VARIABLE, "0.001")
    with pytest.raises(InputError, match=r"holds more than .*export"):
        loaded(folder)


def test_a_folder_is_imported_checked_and_has_its_files_as_input(
    tmp_path: Path, made: Made, ur5: Robot, run_ur5: Command
) -> None:
    folder = parted(tmp_path / "run", made)
    imported = import_files([folder], UserStatement("ur5"))
    assert imported[0].entry["folder"] == str(tmp_path)
    assert imported[0].entry["file"] == "run"
    taken = read_and_check(imported[0].entry, ur5, 0.1)
    np.testing.assert_allclose(channel(taken.robot, "actual_q"), made[1]["actual_q"], atol=1e-6)
    write_study(imported, tmp_path / "study.yaml")
    assert [one["file"] for one in of_each_file(imported[0].entry | {"file": "r*"})] == ["run"]
    assert run_ur5("check", tmp_path / "study.yaml").status == 0
    study = Selection(read_study(tmp_path / "study.yaml"))
    assert study.raw_files("run") == sorted(map(str, folder.iterdir()))
