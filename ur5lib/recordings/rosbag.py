"""Messages of bags, ROS 1 (.bag) or ROS 2 (.db3, .mcap), as arrays by topic and field."""

import re
from array import array
from collections import Counter, defaultdict
from collections.abc import Collection
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from ur5lib.channels import MOST_JOINTS
from ur5lib.errors import InputError
from ur5lib.recordings.array_files import Arrays, array_format, report_unread, rows_of
from ur5lib.recordings.bag_chunks import Unpack, with_bounded_chunks
from ur5lib.recordings.bag_files import PACKED_ENDING, bag_files, unpacked
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
PACKED_MESSAGE = b"\x28\xb5\x2f\xfd"  # how zstd begins, and no message of ROS 2 by itself
FIELDS = {  # that are read of each kind of message
    "sensor_msgs/msg/JointState": ("position", "velocity", "effort"),
    "geometry_msgs/msg/WrenchStamped": ("force", "torque"),
    "franka_msgs/msg/FrankaState": (
        *("q", "dq", "tau_J", "tau_ext_hat_filtered", "O_F_ext_hat_K", "O_T_EE"),
    ),
    "sensor_msgs/msg/Imu": ("linear_acceleration", "angular_velocity"),
}


class Joints(NamedTuple):
    """The joints of a message: their names, none where it does not name each once, and how many."""

    names: tuple[str, ...] = ()
    width: int = 0


class Messages:
    """The messages of a topic: columns of numbers, so that many take little memory.

    stamps: of their headers [s]; received: of their receipt [s]; values: of each field, of all
    messages one after the other; widths: how many each message has; joints: each kind of them
    once, and places: where each message's is.
    """

    def __init__(self) -> None:
        self.stamps, self.received, self.places = array("d"), array("d"), array("q")
        self.values: defaultdict[str, array[float]] = defaultdict(lambda: array("d"))
        self.widths: defaultdict[str, array[int]] = defaultdict(lambda: array("q"))
        self.joints: dict[Joints, int] = {}

    def add(self, message: Any, received: float, fields: Collection[str]) -> None:
        """Add a message. Raises where it lacks something."""
        stamp, body = message.header.stamp, getattr(message, "wrench", message)
        seconds = stamp.sec + 1e-9 * stamp.nanosec
        joints = _joints_of(message)
        numbers = {name: _numbers(getattr(body, name)) for name in fields}
        self.stamps.append(seconds)
        self.received.append(received)
        self.places.append(self.joints.setdefault(joints, len(self.joints)))
        for name, values in numbers.items():
            self.values[name].frombytes(values.tobytes())
            self.widths[name].append(len(values))

    def size(self) -> int:
        """Return how many numbers the messages have."""
        return sum(map(len, self.values.values()))

    def usual_joints(self) -> Joints:
        """Return the joints that most messages are about, those of an arm first."""
        counts = Counter(self.places)
        return max(
            self.joints,
            key=lambda joints: (
                joint_order(joints.names) is not None,
                len(JOINTS) <= joints.width <= MOST_JOINTS,
                counts[self.joints[joints]],
            ),
        )

    def about(self, joints: Joints) -> Mask:
        """Return which messages are about these joints (N,), in any order."""
        alike = [_in_any_order(own) == _in_any_order(joints) for own in self.joints]
        return np.array(alike)[np.array(self.places)]

    def rows(self, field: str, kept: Mask, joints: Joints) -> Array:
        """Return a field of some messages in the arm's order, else in that of `joints`.

        Nothing where none of them has it; NaN in those without it.
        """
        widths = np.array(self.widths[field])
        width, names = joints.width or int(widths[kept][0]), joints.names
        if not width or not (widths[kept] == width).any():
            return np.empty((0, 0))
        rows = rows_of(np.array(self.values[field]), widths, width)[kept]
        ordered = [names[k] for k in joint_order(names) or range(len(names))]
        for own, place in self.joints.items():
            if _in_any_order(own) == _in_any_order(joints) and names:
                these = np.array(self.places)[kept] == place
                rows[these] = rows[these][:, [own.names.index(name) for name in ordered]]
        return rows


@array_format("rosbag", "a ROS bag", ".bag", ".db3", ".mcap", PACKED_ENDING, is_folder=True)
def rosbag_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the fields of JointState, WrenchStamped, Imu and FrankaState messages by
    `<topic>/<field>`.

    path: a file, or a folder with one bag. `<topic>/stamp` is the time in the messages' headers,
    `<topic>/bag_stamp` that of their receipt [s]. Joints come in the arm's order where the messages
    name them. Messages that cannot be read are skipped and reported. Raises InputError when the
    file is damaged or no bag, and where a folder holds none or several.
    """
    topics: dict[str, Messages] = {}
    files, missing = bag_files(path)
    failures = [_read_part(file, wanted, topics, findings) for file in files]
    if not topics and (failure := next(filter(None, failures), None)):
        raise failure
    lacking = "parts that metadata.yaml lists, but that the folder lacks"
    Log(path, "robot", findings).add("damaged messages", "warning", missing, lacking)
    arrays: Arrays = {}
    for topic, messages in topics.items():
        arrays |= _topic_arrays(topic, messages, path, findings)
    return arrays


def _read_part(
    path: Path,
    wanted: Collection[str] | None,
    topics: dict[str, Messages],
    findings: list[Finding],
) -> Exception | None:
    """Add the messages of a file to those of its bag; return what stopped its reading, if any."""
    store, lost, failure = get_typestore(Stores.ROS2_HUMBLE), Counter[str](), None
    try:
        with (
            unpacked(path) as plain,
            with_bounded_chunks(path) as unpack,
            AnyReader([plain], default_typestore=store) as bag,
        ):
            if wanted is None:
                others = (c for c in bag.connections if c.msgtype not in FIELDS)
                named = (f"{one.topic} ({one.msgtype})" for one in others)
                report_unread(path, named, "messages of this kind are not read", findings)
            _collect(bag, unpack, wanted, topics, lost, path)
    except InputError:
        raise
    except Exception as error:  # of damaged files, the library may raise anything
        lost["the end of the file cannot be read"] += 1
        failure = error
    for meaning, count in lost.items():
        Log(path, "robot", findings).add("damaged messages", "warning", count, meaning)
    return failure


def joint_order(names: tuple[str, ...]) -> list[int] | None:
    """Return where joints 1 to 6 stand among named ones; None where the names leave it open."""
    places = [[k for k, name in enumerate(names) if joint.search(name)] for joint in JOINT_NAMES]
    return [found[0] for found in places] if all(len(found) == 1 for found in places) else None


def _collect(
    bag: Any,
    unpack: Unpack,
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
    missing = sum(connection.msgcount for connection in known)
    size = BYTES_PER_NUMBER * sum(messages.size() for messages in topics.values())
    for connection, received, raw in bag.messages(connections=known) if known else ():
        missing -= 1
        try:
            plain = unpack(raw) if bag.is2 and raw.startswith(PACKED_MESSAGE) else raw
            size += len(plain)
            expect_room(path, size / BYTES_PER_NUMBER)
            message, kind = bag.deserialize(plain, connection.msgtype), connection.msgtype
            messages = topics.get(connection.topic, Messages())
            messages.add(message, received * 1e-9, FIELDS[kind])
            topics[connection.topic] = messages
        except InputError:
            raise
        except Exception:  # of damaged messages, the library may raise anything
            lost["messages that cannot be decoded as their type; skipped"] += 1
    if missing > 0:
        lost["messages of the index that the bag does not contain"] += missing


def _joints_of(message: Any) -> Joints:
    """Return the joints of a message, by its names or by how many numbers it has of them."""
    if not hasattr(message, "name"):
        return Joints()
    names, fields = tuple(message.name), (message.position, message.velocity, message.effort)
    count = next(filter(None, map(len, fields)), len(names))
    return Joints(names if len({*names}) == len(names) == count else (), count)


def _in_any_order(joints: Joints) -> tuple[frozenset[str], int]:
    return frozenset(joints.names), joints.width


def _numbers(field: Any) -> Array:
    """Return the numbers of an array, or the components of a vector."""
    if isinstance(field, np.ndarray):
        return field.astype(float)
    return np.array([getattr(field, axis) for axis in ("x", "y", "z")], float)


def _topic_arrays(topic: str, messages: Messages, path: Path, findings: list[Finding]) -> Arrays:
    """Return the arrays of a topic, of the messages about the joints that most of them name."""
    usual = messages.usual_joints()
    kept = messages.about(usual)
    log = Log(path, "robot", findings)
    joints = ", ".join(usual.names) or f"the {usual.width} of most"
    others = f"messages on {topic} about other joints than {joints}; left out"
    log.add("other messages", "note", np.count_nonzero(~kept), others)
    if joint_order(usual.names) is None:
        named = f"{joints} on {topic} are not the names of an arm's joints; kept in order"
        nameless = f"the messages on {topic} name no joints; kept in order"
        meaning = named if usual.names else nameless
        log.add("unnamed joints", "note", usual.width, meaning, channels=[topic])
    arrays = {
        f"{topic}/stamp": np.array(messages.stamps)[kept],
        f"{topic}/bag_stamp": np.array(messages.received)[kept],
    }
    rows = {field: messages.rows(field, kept, usual) for field in messages.values}
    return arrays | {f"{topic}/{field}": found for field, found in rows.items() if len(found)}
