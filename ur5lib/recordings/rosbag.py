"""Messages of bags, ROS 1 (.bag) or ROS 2 (.db3, .mcap), as arrays by topic and field."""

import re
from array import array
from collections import Counter, defaultdict
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.array_files import Arrays, array_format, rows_of
from ur5lib.recordings.bag_chunks import with_bounded_chunks
from ur5lib.recordings.limits import BYTES_PER_NUMBER, expect_room
from ur5lib.records.quality import Finding, Log
from ur5lib.timeseries.arrays import Array, Mask

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


class Messages:
    """The messages of a topic: columns of numbers, so that many take little memory.

    stamps: of their headers [s]; received: of their receipt [s]; values: of each field, of all
    messages one after the other; widths: how many each message has; names: of joints, each list of
    them once, and places: where each message's is.
    """

    def __init__(self) -> None:
        self.stamps, self.received, self.places = array("d"), array("d"), array("q")
        self.values: defaultdict[str, array[float]] = defaultdict(lambda: array("d"))
        self.widths: defaultdict[str, array[int]] = defaultdict(lambda: array("q"))
        self.names: dict[tuple[str, ...], int] = {}

    def add(self, message: Any, received: float, fields: Collection[str]) -> None:
        """Add a message. Raises where it lacks something."""
        stamp, body = message.header.stamp, getattr(message, "wrench", message)
        seconds = stamp.sec + 1e-9 * stamp.nanosec
        names = tuple(getattr(message, "name", ()))
        numbers = {name: _numbers(getattr(body, name)) for name in fields}
        self.stamps.append(seconds)
        self.received.append(received)
        self.places.append(self.names.setdefault(names, len(self.names)))
        for name, values in numbers.items():
            self.values[name].frombytes(values.tobytes())
            self.widths[name].append(len(values))

    def usual_names(self) -> tuple[str, ...]:
        """Return the names of the joints that most messages are about, those of an arm first."""
        counts = Counter(self.places)
        return max(
            self.names,
            key=lambda names: (joint_order(names) is not None, counts[self.names[names]]),
        )

    def about(self, joints: Collection[str]) -> Mask:
        """Return which messages are about these joints (N,), in any order."""
        alike = [frozenset(names) == frozenset(joints) for names in self.names]
        return np.array(alike)[np.array(self.places)]

    def rows(self, field: str, kept: Mask, names: tuple[str, ...]) -> Array:
        """Return a field of some messages in the arm's order, else in that of `names`.

        Nothing where none of them has it; NaN in those without it.
        """
        widths = np.array(self.widths[field])
        width = len(names) or int(widths[kept][0])
        rows = rows_of(np.array(self.values[field]), widths, width)[kept]
        if not (widths[kept] == width).any():
            return rows[:0]
        ordered = [names[k] for k in joint_order(names) or range(len(names))]
        for own, place in self.names.items():
            if frozenset(own) == frozenset(names) and names:
                these = np.array(self.places)[kept] == place
                rows[these] = rows[these][:, [own.index(name) for name in ordered]]
        return rows


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
    topics: dict[str, Messages] = {}
    lost = Counter[str]()
    try:
        with with_bounded_chunks(path), AnyReader([path], default_typestore=store) as bag:
            _collect(bag, wanted, topics, lost, path)
    except InputError:
        raise
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
    bag: Any,
    wanted: Collection[str] | None,
    topics: dict[str, Messages],
    lost: Counter[str],
    path: Path,
) -> None:
    """Read the messages of the wanted topics that can be read, and count the others."""
    known = [
        connection
        for connection in bag.connections
        if connection.msgtype in FIELDS
        and (wanted is None or any(name.startswith(f"{connection.topic}/") for name in wanted))
    ]
    missing, size = sum(connection.msgcount for connection in known), 0
    for connection, received, raw in bag.messages(connections=known) if known else ():
        missing -= 1
        size += len(raw)
        expect_room(path, size / BYTES_PER_NUMBER)
        try:
            message, kind = bag.deserialize(raw, connection.msgtype), connection.msgtype
            messages = topics.get(connection.topic, Messages())
            messages.add(message, received * 1e-9, FIELDS[kind])
            topics[connection.topic] = messages
        except Exception:  # of damaged messages, the library may raise anything
            lost["undecodable messages"] += 1
    if missing > 0:
        lost["missing messages"] += missing


def _numbers(field: Any) -> Array:
    """Return the numbers of an array, or the components of a vector."""
    if isinstance(field, np.ndarray):
        return field.astype(float)
    return np.array([getattr(field, axis) for axis in ("x", "y", "z")], float)


def _topic_arrays(topic: str, messages: Messages, path: Path, findings: list[Finding]) -> Arrays:
    """Return the arrays of a topic, of the messages about the joints that most of them name."""
    usual = messages.usual_names()
    kept = messages.about(usual)
    log, about = Log(path, "robot", findings), {"topic": topic, "joints": usual}
    log.add("other messages", "note", np.count_nonzero(~kept), "", **about)
    if joint_order(usual) is None:
        log.add("unnamed joints", "note", len(usual), "", **about)
    arrays = {
        f"{topic}/stamp": np.array(messages.stamps)[kept],
        f"{topic}/bag_stamp": np.array(messages.received)[kept],
    }
    rows = {field: messages.rows(field, kept, usual) for field in messages.values}
    return arrays | {f"{topic}/{field}": found for field, found in rows.items() if len(found)}
