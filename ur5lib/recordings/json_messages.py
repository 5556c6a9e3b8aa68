"""Messages of MCAP files in JSON: states of joints, as Foxglove or ROS has them, and numbers."""

import json
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
from mcap.reader import make_reader

from ur5lib.recordings.limits import BYTES_PER_NUMBER, expect_room
from ur5lib.recordings.messages import JOINT_FIELDS
from ur5lib.timeseries.arrays import Array

MCAP_ENDING = ".mcap"
JSON_STATES = ("foxglove.JointStates", "sensor_msgs/msg/JointState", "sensor_msgs/JointState")


def is_json(path: Path) -> bool:
    """Return whether a file is an MCAP file with messages in JSON alone."""
    if path.suffix != MCAP_ENDING:
        return False
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    channels = summary.channels.values() if summary else ()
    return bool(channels) and all(one.message_encoding == "json" for one in channels)


def json_messages(path: Path, lost: Counter[str]) -> Iterator[tuple[str, str, float, Any]]:
    """Yield topic, schema, time of receipt [s] and content of each message; messages that are no
    JSON are counted in `lost`.
    """
    size = 0
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            size += len(message.data)
            expect_room(path, size / BYTES_PER_NUMBER)
            try:
                content = json.loads(message.data)
            except ValueError:
                lost["messages that are no JSON; skipped"] += 1
                continue
            kind = schema.name if schema else "no name"
            yield channel.topic, kind, 1e-9 * message.log_time, content


def joint_state(content: Mapping[str, Any], received: float) -> Any:
    """Return a state of joints with the attributes of ROS's JointState; NaN for numbers that a
    joint lacks.
    """
    if "joints" in content:
        parts = content["joints"]
        names = [str(part.get("name", "")) for part in parts]
        fields = {field: [part.get(field) for part in parts] for field in JOINT_FIELDS}
    else:
        names = [*map(str, content.get("name") or [])]
        fields = {field: content.get(field) or [] for field in JOINT_FIELDS}
    stamp = content.get("timestamp") or content.get("header", {}).get("stamp")
    header = SimpleNamespace(stamp=stamp_of(stamp, received))
    return SimpleNamespace(header=header, name=names, **{n: _row(v) for n, v in fields.items()})


def _row(values: list[float | None]) -> Array:
    """Return values as numbers, NaN for None; empty if all are None."""
    known = any(value is not None for value in values)
    return np.array(values if known else [], float)


def stamp_of(stamp: Any, received: float) -> Any:
    """Return a stamp with `sec` and `nanosec`; without one, that of the receipt."""
    if not isinstance(stamp, dict):
        return SimpleNamespace(sec=received, nanosec=0)
    nanoseconds = next((stamp[key] for key in ("nsec", "nanosec", "nsecs") if key in stamp), 0)
    return SimpleNamespace(sec=stamp.get("sec", stamp.get("secs", 0)), nanosec=nanoseconds)


def number_arrays(topic: str, rows: list[dict[str, float]]) -> dict[str, Array]:
    """Return the numbers of a topic's messages by `<topic>/<name>`, NaN where a message lacks a
    name.
    """
    table = pd.DataFrame(rows)
    return {f"{topic}/{name}": table[name].to_numpy(float) for name in table}


def are_numbers(content: Any) -> bool:
    """Return whether a message consists only of named numbers or truth values."""
    return isinstance(content, dict) and all(
        isinstance(value, int | float) for value in content.values()
    )


def is_wanted(topic: str, wanted: Collection[str] | None) -> bool:
    """Return whether any wanted name is of a topic; wanted: None for all names."""
    return wanted is None or any(f"{name}/".startswith(f"{topic}/") for name in wanted)
