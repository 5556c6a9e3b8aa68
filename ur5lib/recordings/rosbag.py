"""Messages of bags, ROS 1 (.bag) or ROS 2 (.db3, .mcap), as arrays by topic and field."""

import re
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ur5lib.recordings.array_files import Arrays, array_format
from ur5lib.recordings.quality import Finding, Log

JOINTS = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
JOINT_NAMES = [  # of drivers, and as the teach panel has them
    re.compile(name, re.IGNORECASE)
    for name in (
        r"shoulder[ _]?pan|(?<![a-z])base(?=[ _.][a-z]+$|$)",
        r"shoulder[ _]?lift|(?<![a-z])shoulder(?![ _]?pan)",
        *("elbow", r"wrist[ _]?1", r"wrist[ _]?2", r"wrist[ _]?3"),
    )
]
FIELDS = {  # that are read of each kind of message
    "sensor_msgs/msg/JointState": ("position", "velocity", "effort"),
    "geometry_msgs/msg/WrenchStamped": ("force", "torque"),
    "franka_msgs/msg/FrankaState": (
        *("q", "dq", "tau_J", "tau_ext_hat_filtered", "O_F_ext_hat_K", "O_T_EE"),
    ),
    "sensor_msgs/msg/Imu": ("linear_acceleration", "angular_velocity"),
}


class Message(NamedTuple):
    """A message's stamps [s]: of its header, and of its receipt; and its fields."""

    stamp: float
    bag_stamp: float
    fields: dict[str, list[float]]
    names: tuple[str, ...] = ()


@array_format("rosbag", "a ROS bag", ".bag", ".db3", ".mcap")
def rosbag_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the fields of JointState, WrenchStamped, Imu and FrankaState messages by
    `<topic>/<field>`.

    `<topic>/stamp` is the time in the messages' headers, `<topic>/bag_stamp` that of their receipt
    [s]. Joints come in the arm's order where the messages name them. Messages that cannot be read
    are skipped and reported. Raises InputError when the file is damaged or no bag.
    """
    from rosbags.highlevel import AnyReader  # slow to import, and few recordings are bags
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    topics: dict[str, list[Message]] = {}
    lost = Counter[str]()
    try:
        with AnyReader([path], default_typestore=store) as bag:
            _collect(bag, wanted, topics, lost)
    except Exception:  # of damaged files, the library may raise anything
        if not topics:
            raise
        lost["unreadable end"] += 1
    for code, count in lost.items():
        Log(path, "robot", findings).add("damaged messages", "warning", count, code)
    arrays: Arrays = {}
    for topic, messages in topics.items():
        arrays |= _topic_arrays(topic, messages, path, findings)
    return arrays


def joint_order(names: tuple[str, ...]) -> list[int] | None:
    """Return where joints 1 to 6 stand among named ones; None where the names leave it open."""
    places = [[k for k, name in enumerate(names) if joint.search(name)] for joint in JOINT_NAMES]
    return [found[0] for found in places] if all(len(found) == 1 for found in places) else None


def _collect(
    bag: Any, wanted: Collection[str] | None, topics: dict[str, list[Message]], lost: Counter[str]
) -> None:
    """Read the messages of the wanted topics that can be read, and count the others."""
    known = [
        connection
        for connection in bag.connections
        if connection.msgtype in FIELDS
        and (wanted is None or any(name.startswith(f"{connection.topic}/") for name in wanted))
    ]
    missing = sum(connection.msgcount for connection in known)
    for connection, received, raw in bag.messages(connections=known) if known else ():
        missing -= 1
        try:
            message = bag.deserialize(raw, connection.msgtype)
            body = getattr(message, "wrench", message)
            fields = {name: _numbers(getattr(body, name)) for name in FIELDS[connection.msgtype]}
            names = tuple(getattr(message, "name", ()))
            stamp = message.header.stamp
            seconds = stamp.sec + 1e-9 * stamp.nanosec
        except Exception:  # of damaged messages, the library may raise anything
            lost["undecodable messages"] += 1
            continue
        topics.setdefault(connection.topic, []).append(
            Message(seconds, received * 1e-9, fields, names)
        )
    if missing > 0:
        lost["missing messages"] += missing


def _numbers(field: Any) -> list[float]:
    """Return the numbers of an array, or the components of a vector."""
    if isinstance(field, np.ndarray):
        return list(field.tolist())
    return [getattr(field, axis) for axis in ("x", "y", "z")]


def _topic_arrays(
    topic: str, messages: list[Message], path: Path, findings: list[Finding]
) -> Arrays:
    """Return the arrays of a topic, of the messages about the joints that most of them name."""
    usual = _usual_names(messages)
    kept = [m for m in messages if frozenset(m.names) == frozenset(usual)]
    log, about = Log(path, "robot", findings), {"topic": topic, "joints": usual}
    log.add("other messages", "note", len(messages) - len(kept), "", **about)
    if joint_order(usual) is None:
        log.add("unnamed joints", "note", len(usual), "", **about)
    arrays = {
        f"{topic}/stamp": np.array([message.stamp for message in kept]),
        f"{topic}/bag_stamp": np.array([message.bag_stamp for message in kept]),
    }
    for field in messages[0].fields:
        if rows := [*_rows(kept, field, usual)]:
            arrays[f"{topic}/{field}"] = np.array(rows)
    return arrays


def _usual_names(messages: list[Message]) -> tuple[str, ...]:
    """Return the names of the joints that most messages are about, those of an arm first."""
    counts = Counter(message.names for message in messages)
    return max(counts, key=lambda names: (joint_order(names) is not None, counts[names]))


def _rows(messages: list[Message], field: str, names: tuple[str, ...]) -> Iterator[list[float]]:
    """Yield a field of each message in the arm's order, else in that of `names`.

    Nothing where no message has it; NaN in those without it.
    """
    width = len(names) or len(messages[0].fields[field])
    if not any(len(message.fields[field]) == width for message in messages):
        return
    order = [names[k] for k in joint_order(names) or range(len(names))]
    for message in messages:
        values = message.fields[field]
        if len(values) != width:
            yield [np.nan] * (len(order) or width)
        else:
            yield [values[message.names.index(name)] for name in order] if names else values
