"""Recordings written as files that hold arrays: HDF5, MAT, bags, Parquet, Feather, text."""

import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import scipy.io
import yaml
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from tests.entries import read_recording
from tests.synthetic import write_recording
from ur5lib.channels import SIX_SUFFIXES, SUFFIXES
from ur5lib.recordings.rosbag import DEFINITIONS

Channels = dict[str, np.ndarray]  # (n, k) by channel of RTDE
Made = tuple[np.ndarray, Channels]  # time (n,) [s], and channels
JOINTS = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
THESIS = {
    "actual_q": "q_actual",
    "actual_qd": "qd_actual",
    "actual_current": "i_actual",
    "target_moment": "m_target",
    "actual_TCP_pose": "tool_vector",
}


def thesis_channels(folder: Path, names: Sequence[str] = tuple(THESIS)) -> Made:
    """Time (n,) and channels of a recording in the thesis's format."""
    table = read_recording({"format": "thesis-csv", "folder": str(folder)}).robot.table.dropna()
    columns = {name: [name + suffix for suffix in SUFFIXES[name]] for name in names}
    return table["time"].to_numpy(), {n: table[its].to_numpy() for n, its in columns.items()}


def made_up_channels(folder: Path, seconds: float = 6, seed: int = 5) -> Made:
    """The same of a made-up UR5 that swings."""
    write_recording(folder, seconds, seed)
    return thesis_channels(folder)


def write_hdf5(path: Path, time: np.ndarray, channels: Channels, turned: bool = False) -> None:
    """One group of arrays, n × 6 or turned, with stamps in pairs of seconds and nanoseconds."""
    seconds = np.floor(time)
    pairs = np.column_stack([seconds, np.round(1e9 * (time - seconds))])
    with h5py.File(path, "w") as file:
        file["run/time"] = pairs.T if turned else pairs
        for name, values in channels.items():
            file[f"run/{name}"] = values.T if turned else values


def write_mat(path: Path, time: np.ndarray, channels: Channels) -> None:
    """A structure of arrays, version 5."""
    run = {"time": time[:, None]} | channels
    scipy.io.savemat(path, {"run": run}, do_compression=True)


def write_mat73(path: Path, time: np.ndarray, channels: Channels) -> None:
    """The same as MATLAB's version 7.3, which stores arrays turned."""
    with h5py.File(path, "w", userblock_size=512) as file:
        file["run/time"] = time[None, :]
        for name, values in channels.items():
            file[f"run/{name}"] = values.T
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def write_npz(path: Path, time: np.ndarray, channels: Channels) -> None:
    np.savez_compressed(path, time=time, **channels)


def write_parquet(path: Path, time: np.ndarray, channels: Channels) -> None:
    frame(time, channels).to_parquet(path)


def write_feather(path: Path, time: np.ndarray, channels: Channels) -> None:
    frame(time, channels).to_feather(path)


def write_channel_files(folder: Path, time: np.ndarray, channels: Channels) -> None:
    """A file for each channel; the time has one value a line."""
    folder.mkdir(parents=True, exist_ok=True)
    np.savetxt(folder / "time.txt", time, fmt="%.9f")
    for name, values in channels.items():
        np.savetxt(folder / f"{name}.txt", values, fmt="%.12g")


def frame(time: np.ndarray, channels: Channels) -> pd.DataFrame:
    columns = {
        name + suffix: values[:, k]
        for name, values in channels.items()
        for k, suffix in enumerate(SUFFIXES.get(name, SIX_SUFFIXES))
    }
    return pd.DataFrame({"time": time, **columns})


def write_bag(
    path: Path,
    time: np.ndarray,
    channels: Channels,
    names: Sequence[str] = tuple(JOINTS),
    others: int = 0,
    wrench: np.ndarray | None = None,
) -> None:
    """A ROS 1 bag (.bag), or a ROS 2 bag (.db3 or .mcap) without its metadata.

    Effort is whatever channel remains; names: of the joints, in the order of the columns; others:
    how many messages about a gripper; wrench: (n, 6).
    """
    ros1 = path.suffix == ".bag"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    serialize, first = (store.serialize_ros1, [0]) if ros1 else (store.serialize_cdr, [])
    types = store.types
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    folder = path.with_suffix(".folder")
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    state, vector = types["sensor_msgs/msg/JointState"], types["geometry_msgs/msg/Vector3"]
    effort = next(iter(channels.keys() - {"actual_q", "actual_qd", "actual_TCP_pose"}), None)
    empty = np.empty((len(time), 0))
    rows = [channels.get(n or "", empty) for n in ("actual_q", "actual_qd", effort)]
    path.unlink(missing_ok=True)
    writer = Ros1Writer(path) if ros1 else Ros2Writer(folder, version=9, storage_plugin=plugin)
    with writer as bag:
        joints = bag.add_connection("/joint_states", state.__msgtype__, typestore=store)
        forces = bag.add_connection("/wrench", "geometry_msgs/msg/WrenchStamped", typestore=store)
        for k, now in enumerate(time):
            nanoseconds = round(1e9 * now)
            head = header(*first, stamp(nanoseconds // 10**9, nanoseconds % 10**9), "base")
            message = state(head, list(names), *(np.array(values[k]) for values in rows))
            raw = serialize(message, state.__msgtype__)
            bag.write(joints, nanoseconds + 1_000_000, raw)
            if k < others:
                one = np.zeros(1)
                raw = serialize(state(head, ["finger"], one, one, one), state.__msgtype__)
                bag.write(joints, nanoseconds + 1_100_000, raw)
            if wrench is not None:
                three = [vector(*map(float, part)) for part in (wrench[k, :3], wrench[k, 3:])]
                body = types["geometry_msgs/msg/Wrench"](*three)
                both = types["geometry_msgs/msg/WrenchStamped"](head, body)
                bag.write(forces, nanoseconds, serialize(both, both.__msgtype__))
    if not ros1:
        next(file for file in folder.iterdir() if file.suffix == path.suffix).rename(path)
        shutil.rmtree(folder)


def write_echo(path: Path, time: np.ndarray, channels: Channels) -> None:
    """What `ros2 topic echo` prints of JointState."""
    effort = next(iter(channels.keys() - {"actual_q", "actual_qd", "actual_TCP_pose"}), None)
    fields = {"position": "actual_q", "velocity": "actual_qd", "effort": effort or ""}
    with path.open("w") as file:
        for k, now in enumerate(time):
            stamp = dict(zip(("sec", "nanosec"), divmod(round(1e9 * now), 10**9), strict=True))
            rows = {n: channels[own][k].tolist() for n, own in fields.items() if own in channels}
            header = {"stamp": stamp, "frame_id": "base"}
            yaml.safe_dump({"header": header, "name": JOINTS} | rows, file, sort_keys=False)
            file.write("---\n")


def write_dynamic(path: Path, time: np.ndarray, channels: Channels) -> None:
    """An MCAP file of DynamicJointState, with an input of the arm beside its joints."""
    effort = next(iter(channels.keys() - {"actual_q", "actual_qd", "actual_TCP_pose"}), "")
    named = {"effort": effort, "position": "actual_q", "velocity": "actual_qd"}
    fields = {name: channels[own] for name, own in named.items() if own in channels}
    store = get_typestore(Stores.ROS2_HUMBLE)
    for kind, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, kind))
    values, states = (store.types[kind] for kind in DEFINITIONS)
    header, stamp = (store.types[k] for k in ("std_msgs/msg/Header", "builtin_interfaces/msg/Time"))

    def messages() -> Iterator[tuple[str, float, Any]]:
        for k, now in enumerate(time):
            head = header(stamp(*divmod(round(1e9 * now), 10**9)), "")
            joints = [np.array([rows[k, j] for rows in fields.values()]) for j in range(6)]
            parts = [values(["speed"], np.ones(1)), *(values([*fields], own) for own in joints)]
            yield "/dynamic_joint_states", now, states(head, ["gpio", *JOINTS], parts)

    _write_mcap(path, store, messages())


def write_outputs(path: Path, time: np.ndarray, channels: Channels) -> None:
    """An MCAP file with a topic for each channel, of arrays without stamp, and their clock."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    layout = types["std_msgs/msg/MultiArrayLayout"]([], 0)

    def messages() -> Iterator[tuple[str, float, Any]]:
        for k, now in enumerate(time):
            stamp = divmod(round(1e9 * now), 10**9)
            yield "/timestamp", now, types["builtin_interfaces/msg/Time"](*stamp)
            for place, (name, rows) in enumerate(channels.items()):
                numbers = types["std_msgs/msg/Float64MultiArray"](layout, np.array(rows[k]))
                yield f"/{name}", now + 1e-5 * place, numbers

    _write_mcap(path, store, messages())


def _write_mcap(path: Path, store: Any, messages: Iterator[tuple[str, float, Any]]) -> None:
    """An MCAP file without its folder: topic, time of receipt [s] and content of each message."""
    folder, topics = path.with_suffix(".folder"), dict[str, Any]()
    with Ros2Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        for topic, received, message in messages:
            kind = message.__msgtype__
            if topic not in topics:
                topics[topic] = bag.add_connection(topic, kind, typestore=store)
            bag.write(topics[topic], round(1e9 * received), store.serialize_cdr(message, kind))
    next(file for file in folder.iterdir() if file.suffix == path.suffix).rename(path)
    shutil.rmtree(folder)


TOPICS = {
    "rosbag": "/joint_states/",
    "dynamic": "/dynamic_joint_states/",
    "ros-echo": "joint_states/",
}


def entry_of(format: str, path: Path, names: Sequence[str], kind: str = "") -> dict[str, Any]:
    """The entry of a study for a file written here; kind: of a bag, if not of JointState."""
    prefix = "run/" if format in ("hdf5", "mat") else ""
    suffix = ".txt" if format == "channel-files" else ""
    channels = {name: f"{prefix}{name}{suffix}" for name in ["time", *names]}
    if topic := TOPICS.get(kind or format):
        fields = {"time": "stamp", "actual_q": "position", "actual_qd": "velocity"}
        channels = {n: topic + fields.get(n, "effort") for n in ["time", *names]}
    if kind == "outputs":
        channels = {"time": "/timestamp"} | {name: f"/{name}" for name in names}
    whole = {"format": format, "folder": str(path.parent), "file": path.name, "channels": channels}
    if format == "channel-files":
        whole |= {"folder": str(path)}
        del whole["file"]
    return whole


WRITERS: dict[str, tuple[str, Callable[..., None]]] = {  # file, and how it is written
    "hdf5": ("run.h5", write_hdf5),
    "mat": ("run.mat", write_mat),
    "mat 7.3": ("run73.mat", write_mat73),
    "npz": ("run.npz", write_npz),
    "parquet": ("run.parquet", write_parquet),
    "feather": ("run.feather", write_feather),
    "channel-files": ("run", write_channel_files),
    "rosbag": ("run.db3", write_bag),
    "rosbag mcap": ("run.mcap", write_bag),
    "rosbag 1": ("run.bag", write_bag),
    "rosbag dynamic": ("dynamic.mcap", write_dynamic),
    "rosbag outputs": ("outputs.mcap", write_outputs),
    "ros-echo": ("run.yaml", write_echo),
}


def write(kind: str, folder: Path, time: np.ndarray, channels: Channels) -> dict[str, Any]:
    """Write a recording and return its entry; a bag holds positions, velocities and one effort."""
    name, writer = WRITERS[kind]
    if kind.startswith("ros"):
        channels = {n: channels[n] for n in ("actual_q", "actual_qd", "actual_current")}
    writer(folder / name, time, channels)
    format, _, of_bag = kind.partition(" ")
    own = of_bag if of_bag in ("dynamic", "outputs") else ""
    return entry_of(format, folder / name, [*channels], own)
