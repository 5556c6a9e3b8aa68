"""Messages of bags, ROS 1 (.bag) or ROS 2 (.db3, .mcap), as arrays by topic and field."""

from array import array
from collections import Counter, defaultdict
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from ur5lib.channels import MOST_JOINTS
from ur5lib.errors import InputError
from ur5lib.recordings.arm_joints import JOINTS, ArmJoints, arms_among, joint_order
from ur5lib.recordings.array_files import Arrays, report_unread, rows_of
from ur5lib.recordings.bag_chunks import Unpack, with_bounded_chunks
from ur5lib.recordings.bag_files import bag_files, unpacked
from ur5lib.recordings.json_messages import (
    JOINT_FIELDS,
    JSON_STATES,
    are_numbers,
    is_json,
    is_wanted,
    joint_state,
    json_messages,
    number_arrays,
)
from ur5lib.recordings.limits import BYTES_PER_NUMBER, expect_room
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.timeseries.arrays import Array, Mask

PACKED_MESSAGE = b"\x28\xb5\x2f\xfd"  # how zstd begins, and no message of ROS 2 by itself
FIELDS = {  # that are read of each kind of message
    "sensor_msgs/msg/JointState": JOINT_FIELDS,
    "geometry_msgs/msg/WrenchStamped": ("force", "torque"),
    "franka_msgs/msg/FrankaState": (
        *("q", "dq", "tau_J", "tau_ext_hat_filtered", "O_F_ext_hat_K", "O_T_EE"),
    ),
    "sensor_msgs/msg/Imu": ("linear_acceleration", "angular_velocity"),
}


class Joints(NamedTuple):
    """The joints in a message: their names, empty unless it names each once, and their number."""

    names: tuple[str, ...] = ()
    width: int = 0


class Messages:
    """The messages of a topic, as columns of numbers, so that many take little memory.

    stamps: in their headers [s]; received: of their receipt [s]; values: by field, the numbers of
    all messages one after the other; widths: by field, how many each message has; joints: number of
    each different set of joints; places: that number of each message.
    """

    def __init__(self) -> None:
        self.stamps, self.received, self.places = array("d"), array("d"), array("q")
        self.values: defaultdict[str, array[float]] = defaultdict(lambda: array("d"))
        self.widths: defaultdict[str, array[int]] = defaultdict(lambda: array("q"))
        self.joints: dict[Joints, int] = {}

    def add(self, message: Any, received: float, fields: Collection[str]) -> None:
        """Add a message. Raises an exception of any type where it lacks a field."""
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
        """Return the joints of most messages, preferring those of an arm."""
        counts = Counter(self.places)
        return max(
            self.joints,
            key=lambda joints: (
                bool(arms_among(joints.names)),
                len(JOINTS) <= joints.width <= MOST_JOINTS,
                counts[self.joints[joints]],
            ),
        )

    def about(self, joints: Joints) -> Mask:
        """Return which messages (N,) are about these joints, in any order."""
        alike = [_in_any_order(own) == _in_any_order(joints) for own in self.joints]
        return np.array(alike)[np.array(self.places)]

    def arms(self) -> list[tuple[Joints, ArmJoints]]:
        """Return each arm among the joints once, with the joints of the messages that name it."""
        kinds = sorted(self.joints, key=lambda joints: joints != self.usual_joints())
        found = {frozenset(arm.names): (own, arm) for own in kinds for arm in arms_among(own.names)}
        return [*found.values()]

    def rows(self, field: str, kept: Mask, joints: Joints, ordered: Sequence[str]) -> Array:
        """Return a field (n, k) of the messages `kept`, with the joints `ordered`, or all if that
        is empty.

        (0, 0) if none of them has the field; NaN in messages without it.
        """
        widths = np.array(self.widths[field])
        width = joints.width or int(widths[kept][0])
        if not width or not (widths[kept] == width).any():
            return np.empty((0, 0))
        rows = rows_of(np.array(self.values[field]), widths, width)[kept]
        if not ordered:
            return rows
        chosen, places = np.empty((len(rows), len(ordered))), np.array(self.places)[kept]
        for own, place in self.joints.items():
            if _in_any_order(own) == _in_any_order(joints):
                columns = [own.names.index(name) for name in ordered]
                chosen[places == place] = rows[places == place][:, columns]
        return chosen


def arrays_of_bag(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the fields of JointState, WrenchStamped, Imu and FrankaState messages by
    `<topic>/<field>`.

    path: a file, or a folder with one bag. `<topic>/stamp` is the time in the messages' headers,
    `<topic>/bag_stamp` that of their receipt [s]. Joints come in the arm's order where the messages
    name them. Messages that cannot be read are skipped and reported. Raises InputError when the
    file is damaged or no bag, and where a folder has none or several.
    """
    topics: dict[str, Messages] = {}
    files, missing = bag_files(path)
    if is_json(files[0]):
        return _of_json(files, wanted, path, findings)
    failures = [_read_part(file, wanted, topics, findings) for file in files]
    if not topics and (failure := next(filter(None, failures), None)):
        raise failure
    lacking = "parts that metadata.yaml lists, but that the folder lacks"
    Log(path, "robot", findings).add(Found.DAMAGED_MESSAGES, "warning", missing, lacking)
    return _by_topic(topics, wanted, path, findings)


def _of_json(
    files: list[Path], wanted: Collection[str] | None, path: Path, findings: list[Finding]
) -> Arrays:
    """Return the arrays of JSON messages: states of joints, and messages of named numbers."""
    topics, tables = dict[str, Messages](), defaultdict[str, list[dict[str, float]]](list)
    unread, lost = set[str](), Counter[str]()
    for topic, kind, received, content in (m for file in files for m in json_messages(file, lost)):
        if not is_wanted(topic, wanted):
            continue
        if kind in JSON_STATES:
            state = joint_state(content, received)
            topics.setdefault(topic, Messages()).add(state, received, JOINT_FIELDS)
        elif are_numbers(content):
            tables[topic].append({"bag_stamp": received} | content)
        else:
            unread.add(f"{topic} ({kind})")
    for one in sorted(unread):
        kind = one.partition("(")[2].rstrip(")")
        report_unread(path, [one], f"JSON messages of schema {kind} are not read", findings)
    for meaning, count in lost.items():
        Log(path, "robot", findings).add(Found.DAMAGED_MESSAGES, "warning", count, meaning)
    if wanted is None and not topics and not tables:
        kinds = ", ".join(sorted(one.partition("(")[2].rstrip(")") for one in unread))
        raise InputError(f"{path}: JSON messages of schema {kinds} are not read")
    arrays = _by_topic(topics, wanted, path, findings)
    for topic, rows in tables.items():
        arrays |= number_arrays(topic, rows)
    return arrays


def _by_topic(
    topics: dict[str, Messages],
    wanted: Collection[str] | None,
    path: Path,
    findings: list[Finding],
) -> Arrays:
    arrays: Arrays = {}
    for topic, messages in topics.items():
        arrays |= _topic_arrays(topic, messages, wanted, path, findings)
    return arrays


def _read_part(
    path: Path,
    wanted: Collection[str] | None,
    topics: dict[str, Messages],
    findings: list[Finding],
) -> Exception | None:
    """Add the messages of one file of a bag to `topics`; return the exception that ended its
    reading, None if it was complete.
    """
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
        Log(path, "robot", findings).add(Found.DAMAGED_MESSAGES, "warning", count, meaning)
    return failure


def _collect(
    bag: Any,
    unpack: Unpack,
    wanted: Collection[str] | None,
    topics: dict[str, Messages],
    lost: Counter[str],
    path: Path,
) -> None:
    """Read the messages of the wanted topics into `topics`; those that cannot be read are counted
    in `lost`.
    """
    known = [
        connection
        for connection in bag.connections
        if connection.msgtype in FIELDS and is_wanted(connection.topic, wanted)
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
    """Return the joints of a message: their names if each is named once, and how many numbers it
    has of them.
    """
    if not hasattr(message, "name"):
        return Joints()
    names, fields = tuple(message.name), (message.position, message.velocity, message.effort)
    count = next(filter(None, map(len, fields)), len(names))
    return Joints(names if len({*names}) == len(names) == count else (), count)


def _in_any_order(joints: Joints) -> tuple[frozenset[str], int]:
    return frozenset(joints.names), joints.width


def _numbers(field: Any) -> Array:
    """Return the numbers of an array, or x, y and z of a vector."""
    if isinstance(field, np.ndarray):
        return field.astype(float)
    return np.array([getattr(field, axis) for axis in ("x", "y", "z")], float)


def _topic_arrays(
    topic: str,
    messages: Messages,
    wanted: Collection[str] | None,
    path: Path,
    findings: list[Finding],
) -> Arrays:
    """Return the arrays of a topic by name: of the wanted joints, of each of several arms, or of
    the usual joints.
    """
    if named := _named_joints(topic, messages, wanted):
        return named
    usual, arms = messages.usual_joints(), messages.arms()
    if len(arms) < 2 or (wanted and f"{topic}/position" in wanted):
        arm = next((arm for joints, arm in arms if joints == usual), ArmJoints("", ()))
        return _arm_arrays(topic, messages, usual, arm.names, Log(path, "robot", findings))
    arrays: Arrays = {}
    for k, (joints, arm) in enumerate(arms):
        place = f"{topic}/{arm.label or f'arm_{k + 1}'}"
        if wanted is None or any(name.startswith(f"{place}/") for name in wanted):
            log = Log(path, "robot", [] if k and wanted is None else findings)
            arrays |= _arm_arrays(place, messages, joints, arm.names, log)
    return arrays


def _named_joints(topic: str, messages: Messages, wanted: Collection[str] | None) -> Arrays:
    """Return the wanted columns `<topic>/<field>/<joint>` with their stamps; empty if none is
    wanted.
    """
    asked = {name.removeprefix(f"{topic}/").partition("/")[2] for name in wanted or ()}
    joints = max(messages.joints, key=lambda one: len(asked.intersection(one.names)))
    ordered = [name for name in joints.names if name in asked]
    if not ordered:
        return {}
    kept = messages.about(joints)
    arrays = _stamps(topic, messages, kept)
    for field in messages.values:
        rows = messages.rows(field, kept, joints, ordered)
        if len(rows):
            arrays |= {f"{topic}/{field}/{name}": rows[:, k] for k, name in enumerate(ordered)}
    return arrays


def _stamps(place: str, messages: Messages, kept: Mask) -> Arrays:
    return {
        f"{place}/stamp": np.array(messages.stamps)[kept],
        f"{place}/bag_stamp": np.array(messages.received)[kept],
    }


def _arm_arrays(
    place: str, messages: Messages, joints: Joints, of_arm: tuple[str, ...], log: Log
) -> Arrays:
    """Return the arrays of one arm, from the messages that name its joints."""
    kept, names = messages.about(joints), joints.names
    order = joint_order(names)
    whole = len(of_arm) in (0, len(names)) or (order is not None and len(names) == len(JOINTS))
    ordered = [names[k] for k in order or range(len(names))] if whole else of_arm
    listed = ", ".join(ordered) or f"the {joints.width} of most"
    others = f"messages on {place} about other joints than {listed}; left out"
    log.add(Found.OTHER_MESSAGES, "note", np.count_nonzero(~kept), others)
    rest = [name for name in names if name not in ordered]
    if rest:
        report_unread(log.path, rest, f"no joint of the arm on {place}", log.findings)
    if joint_order(tuple(ordered)) is None:
        named = f"{listed} on {place} are not the names of an arm's joints; kept in order"
        nameless = f"the messages on {place} name no joints; kept in order"
        meaning = named if names else nameless
        count = len(ordered) or joints.width
        log.add(Found.UNNAMED_JOINTS, "note", count, meaning, channels=[place])
    rows = {field: messages.rows(field, kept, joints, ordered) for field in messages.values}
    return _stamps(place, messages, kept) | {
        f"{place}/{field}": found for field, found in rows.items() if len(found)
    }
