"""Messages of ROS as columns of numbers, and the arrays that these make by topic and field."""

from array import array
from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from ur5lib.channels import MOST_JOINTS
from ur5lib.recordings.arm_joints import JOINTS, ArmJoints, arms_among, joint_order
from ur5lib.recordings.array_files import Arrays, report_unread, rows_of
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.timeseries.arrays import Array, Mask

JOINT_FIELDS = ("position", "velocity", "effort")


class Joints(NamedTuple):
    """The joints in a message: their names, empty unless it names each once, and their number."""

    names: tuple[str, ...] = ()
    width: int = 0


class Messages:
    """The messages of a topic, as columns of numbers, so that many take little memory.

    stamps: in their headers [s]; received: of their receipt [s]; values: by field, the numbers of
    all messages one after the other; widths: by field, how many each message has; joints: number of
    each different set of joints; places: that number of each message; others: names of what the
    messages have besides joints.
    """

    def __init__(self) -> None:
        self.stamps, self.received, self.places = array("d"), array("d"), array("q")
        self.values: defaultdict[str, array[float]] = defaultdict(lambda: array("d"))
        self.widths: defaultdict[str, array[int]] = defaultdict(lambda: array("q"))
        self.joints: dict[Joints, int] = {}
        self.others = set[str]()

    def add(self, message: Any, received: float, fields: Collection[str]) -> None:
        """Add a message. Raises an exception of any type where it lacks a field."""
        stamp, body = message.header.stamp, getattr(message, "wrench", message)
        seconds = stamp.sec + 1e-9 * stamp.nanosec
        joints = _joints_of(message)
        numbers = {name: _numbers(getattr(body, name)) for name in fields}
        self.others.update(getattr(message, "others", ()))
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


def by_topic(
    topics: Mapping[str, Messages],
    wanted: Collection[str] | None,
    path: Path,
    findings: list[Finding],
) -> Arrays:
    """Return the arrays of all topics, by `<topic>/<field>`."""
    arrays: Arrays = {}
    for topic, messages in topics.items():
        if messages.others and wanted is None:
            names = (f"{topic}/{name} ({len(messages.stamps):,})" for name in messages.others)
            report_unread(path, names, "interfaces without a position are not read", findings)
        arrays |= _topic_arrays(topic, messages, wanted, path, findings)
    return arrays


def dynamic_state(message: Any) -> Any:
    """Return a DynamicJointState with the attributes of a JointState, of the joints that have a
    position; `others`: names of what has none, as of inputs and outputs.
    """
    values = (
        dict(zip(own.interface_names, own.values, strict=True)) for own in message.interface_values
    )
    states = dict(zip(message.joint_names, values, strict=True))
    joints = [name for name, own in states.items() if "position" in own]
    fields = {
        field: np.array([states[name].get(field, np.nan) for name in joints])
        for field in JOINT_FIELDS
        if any(field in states[name] for name in joints)
    }
    others = [name for name in states if name not in joints]
    fields = dict.fromkeys(JOINT_FIELDS, np.empty(0)) | fields
    return SimpleNamespace(header=message.header, name=joints, others=others, **fields)


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
        code = Found.UNNAMED_JOINTS if names else Found.NAMELESS_JOINTS
        log.add(code, "note", count, meaning, channels=[place])
    rows = {field: messages.rows(field, kept, joints, ordered) for field in messages.values}
    return _stamps(place, messages, kept) | {
        f"{place}/{field}": found for field, found in rows.items() if len(found)
    }
