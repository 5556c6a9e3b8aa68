"""Messages that `ros2 topic echo` or `rostopic echo` printed, as YAML or, with --csv, in lines."""

import re
from collections import Counter
from collections.abc import Collection, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.array_files import Arrays, array_format, report_unread
from ur5lib.recordings.echo_start import ECHOED, LINE
from ur5lib.recordings.json_messages import is_wanted, joint_state, stamp_of
from ur5lib.recordings.limits import BYTES_PER_NUMBER, expect_room, longest_line, too_large
from ur5lib.recordings.messages import JOINT_FIELDS, Messages, by_topic, dynamic_state
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.strict import plain_yaml

BETWEEN = "---\n"  # messages
MOST_MESSAGE_BYTES = 100_000
LOST_NOTE = re.compile(r"A message was lost!!!\n\ttotal count change: ?\d+\n\ttotal count: ?\d+")
STATES, FORCES = "joint_states", "wrench"  # in place of the topic, which is not printed
FIELDS = {STATES: JOINT_FIELDS, FORCES: ("force", "torque")}
AXES = ("x", "y", "z")


@array_format(ECHOED, "echoed messages of ROS")
def echoed_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the fields of JointState, DynamicJointState and WrenchStamped messages by
    `joint_states/<field>` and `wrench/<field>`, as those of a bag.

    Messages that cannot be read are skipped and reported.
    """
    topics, lost, unread = dict[str, Messages](), Counter[str](), Counter[str]()
    expect_room(path, path.stat().st_size / BYTES_PER_NUMBER)
    for text in _printed(path):
        try:
            message = _of_line(text) if LINE.match(text.encode()) else plain_yaml(text, str(path))
            found = _known(message)
            if found is None:
                unread[_kind(message)] += 1
            elif is_wanted(found[0], wanted):
                topics.setdefault(found[0], Messages()).add(found[1], np.nan, FIELDS[found[0]])
        except Exception:  # whatever a damaged message lacks
            lost["echoed messages that are cut off or damaged; skipped"] += 1
    log = Log(path, "robot", findings)
    for meaning, count in lost.items():
        log.add(Found.DAMAGED_MESSAGES, "warning", count, meaning)
    if wanted is None:
        listed = (f"{kind} ({count:,})" for kind, count in unread.items())
        report_unread(path, listed, "echoed messages of this kind are not read", findings)
    if not topics and wanted is None:
        kinds = ", ".join(unread) or "no known kind"
        raise InputError(f"{path}: echoed messages with {kinds} are not read; record a bag")
    arrays = by_topic(topics, wanted, path, findings)
    return {name: own for name, own in arrays.items() if not name.endswith("/bag_stamp")}


def _printed(path: Path) -> Iterator[str]:
    """Yield the text of each message."""
    lines, size, most = list[str](), 0, longest_line()
    with path.open(encoding="utf-8", errors="replace") as stream:
        for line in iter(lambda: stream.readline(most), ""):
            if len(line) == most:
                raise too_large(path, f"{most:,} bytes in a line")
            if line == BETWEEN:
                yield LOST_NOTE.sub("", "".join(lines))
                lines, size = [], 0
            elif LINE.match(line.encode()):
                yield line
            elif (size := size + len(line)) < MOST_MESSAGE_BYTES:
                lines.append(line)
    if lines:
        yield LOST_NOTE.sub("", "".join(lines))


def _of_line(line: str) -> dict[str, Any]:
    """Return a JointState that is printed as a line: stamp, frame, names and three times as many
    numbers.
    """
    sec, nanosec, _, *rest = line.strip().split(",")
    names = [cell for cell in rest if re.match(r"(?!nan|inf)[A-Za-z_]", cell)]
    values, count = [float(cell) for cell in rest[len(names) :]], len(names)
    if len(values) % count:
        raise ValueError(line)
    fields = {field: values[k * count :][:count] for k, field in enumerate(JOINT_FIELDS)}
    stamp = {"sec": int(sec), "nanosec": int(nanosec)}
    return {"header": {"stamp": stamp}, "name": names} | fields


def _known(message: dict[str, Any]) -> tuple[str, Any] | None:
    """Return the topic of a message and the message with attributes as of a bag; None for a kind
    that is not read. Raises an exception of any type where it is incomplete.
    """
    if message.keys() <= {"header", "name", *JOINT_FIELDS}:
        whole = {"name": message["name"], "position": message["position"]}
        return STATES, joint_state(message | whole, np.nan)
    header = SimpleNamespace(stamp=stamp_of(message.get("header", {}).get("stamp"), np.nan))
    if "interface_values" in message:
        values = [SimpleNamespace(**own) for own in message["interface_values"]]
        names = message["joint_names"]
        given = SimpleNamespace(header=header, joint_names=names, interface_values=values)
        return STATES, dynamic_state(given)
    if "wrench" in message:
        parts = {
            field: SimpleNamespace(**{axis: float(message["wrench"][field][axis]) for axis in AXES})
            for field in FIELDS[FORCES]
        }
        return FORCES, SimpleNamespace(header=header, **parts)
    return None


def _kind(message: dict[str, Any]) -> str:
    """Return the fields of a message, which stand for its kind."""
    return ", ".join(f"`{key}`" for key in message if key != "header")[:100]
