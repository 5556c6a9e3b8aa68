"""Messages of bags, ROS 1 (.bag) or ROS 2 (.db3, .mcap), as arrays by topic and field."""

from collections import Counter, defaultdict
from collections.abc import Callable, Collection
from functools import cache
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from ur5lib.errors import InputError
from ur5lib.recordings.array_files import Arrays, report_unread
from ur5lib.recordings.bag_chunks import Unpack, with_bounded_chunks
from ur5lib.recordings.bag_files import bag_files, unpacked
from ur5lib.recordings.json_messages import (
    JSON_STATES,
    are_numbers,
    is_json,
    is_wanted,
    joint_state,
    json_messages,
    number_arrays,
)
from ur5lib.recordings.limits import BYTES_PER_NUMBER, expect_room
from ur5lib.recordings.messages import JOINT_FIELDS, Messages, by_topic, dynamic_state
from ur5lib.recordings.output_topics import NUMBERS, joined_outputs, names_output, numbers_of
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log

PACKED_MESSAGE = b"\x28\xb5\x2f\xfd"  # how zstd begins, and no message of ROS 2 by itself
DYNAMIC_STATE = "control_msgs/msg/DynamicJointState"
FRANKA_STATE = "franka_msgs/msg/FrankaState"
FIELDS = {  # that are read of each kind of message
    "sensor_msgs/msg/JointState": JOINT_FIELDS,
    DYNAMIC_STATE: JOINT_FIELDS,
    "geometry_msgs/msg/WrenchStamped": ("force", "torque"),
    FRANKA_STATE: (
        *("q", "dq", "tau_J", "tau_J_d", "tau_ext_hat_filtered", "O_F_ext_hat_K", "O_T_EE"),
    ),
    "sensor_msgs/msg/Imu": ("linear_acceleration", "angular_velocity"),
}
AS_STATE: dict[str, Callable[[Any], Any]] = {DYNAMIC_STATE: dynamic_state}
HEADER = "std_msgs/Header header\n"
DEFINITIONS = {  # of kinds that bags of SQLite do not define, and no release of ROS has in its core
    "control_msgs/msg/InterfaceValue": "string[] interface_names\nfloat64[] values\n",
    DYNAMIC_STATE: f"{HEADER}string[] joint_names\nInterfaceValue[] interface_values\n",
}


def arrays_of_bag(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the fields of JointState, DynamicJointState, WrenchStamped, Imu and FrankaState
    messages by `<topic>/<field>`, and topics that are named like RTDE's outputs by `<topic>`.

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
    outputs = {topic: own for topic, own in topics.items() if NUMBERS in own.values}
    states = {topic: own for topic, own in topics.items() if topic not in outputs}
    return by_topic(states, wanted, path, findings) | joined_outputs(outputs)


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
    arrays = by_topic(topics, wanted, path, findings)
    for topic, rows in tables.items():
        arrays |= number_arrays(topic, rows)
    return arrays


def _as_it_is(message: Any) -> Any:
    return message


@cache
def typestore() -> Any:
    """Return the kinds of messages that bags may lack the definitions of."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    for kind, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, kind))
    return store


def _fields_of(kind: str, message: Any) -> Collection[str]:
    """Return the fields that are read of a message; Franka's differ by the driver's version."""
    fields = FIELDS.get(kind, (NUMBERS,))
    return [n for n in fields if hasattr(message, n)] if kind == FRANKA_STATE else fields


def _is_read(connection: Any) -> bool:
    """Return whether the messages of a topic are read, by their kind, or kind and name."""
    return connection.msgtype in FIELDS or names_output(connection.topic, connection.msgtype)


def _read_part(
    path: Path,
    wanted: Collection[str] | None,
    topics: dict[str, Messages],
    findings: list[Finding],
) -> Exception | None:
    """Add the messages of one file of a bag to `topics`; return the exception that ended its
    reading, None if it was complete.
    """
    lost, failure = Counter[str](), None
    try:
        with (
            unpacked(path) as plain,
            with_bounded_chunks(path) as unpack,
            AnyReader([plain], default_typestore=typestore()) as bag,
        ):
            if wanted is None:
                others = (c for c in bag.connections if not _is_read(c))
                named = (f"{one.topic} ({one.msgtype}, {one.msgcount:,})" for one in others)
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
        if _is_read(connection) and is_wanted(connection.topic, wanted)
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
            known_as = AS_STATE.get(kind, _as_it_is) if kind in FIELDS else numbers_of
            messages = topics.get(connection.topic, Messages())
            messages.add(known_as(message), received * 1e-9, _fields_of(kind, message))
            topics[connection.topic] = messages
        except InputError:
            raise
        except Exception:  # of damaged messages, the library may raise anything
            lost["messages that cannot be decoded as their type; skipped"] += 1
    if missing > 0:
        lost["messages of the index that the bag does not contain"] += missing
