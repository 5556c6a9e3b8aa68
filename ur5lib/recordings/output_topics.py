"""Topics with one output of RTDE each, as UR's publisher of RTDE writes: rows by time of receipt.

Their messages have no stamp. Where a topic `timestamp` has the controller's clock, its messages
belong to the rows like all others.
"""

from collections import defaultdict
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from ur5lib.channels import RECORDED_CHANNELS
from ur5lib.recordings.array_files import Arrays, rows_of
from ur5lib.recordings.messages import Messages
from ur5lib.timeseries.arrays import Array

NUMBERS = "data"  # the field of their messages
CLOCK, RECEIPT = "timestamp", "bag_stamp"
CLOCK_KIND = "builtin_interfaces/msg/Time"
ARRAY_KINDS = ("Float64MultiArray", "Float32MultiArray", "Float64", "Float32", "Int32", "UInt32")
FIRST = "actual_q"  # to whose messages those of other topics are added
MAX_APART = 0.5  # of the usual step, that messages of one row are received apart


def names_output(topic: str, kind: str) -> bool:
    """Return whether a topic has an output of RTDE, by its name and the kind of its messages."""
    name, package = topic.rpartition("/")[2], kind.partition("/")[0]
    if name == CLOCK:
        return kind == CLOCK_KIND or kind.endswith("/Float64")
    is_array = package in ("std_msgs", "example_interfaces") and kind.endswith(ARRAY_KINDS)
    return is_array and name in RECORDED_CHANNELS


def numbers_of(message: Any) -> Any:
    """Return a message of numbers, or a time [s], as an array in the field NUMBERS."""
    is_time = hasattr(message, "nanosec")
    data = message.sec + 1e-9 * message.nanosec if is_time else message.data
    header = SimpleNamespace(stamp=SimpleNamespace(sec=0, nanosec=0))
    return SimpleNamespace(header=header, data=np.atleast_1d(np.asarray(data, float)))


def joined_outputs(topics: Mapping[str, Messages]) -> Arrays:
    """Return the outputs by topic, (n, k) or (n,), in rows of those messages of `actual_q`, or of
    the first topic; and `bag_stamp`, the time of their receipt. NaN where a topic has no message at
    that time.
    """
    groups, arrays = defaultdict[str, list[str]](list), Arrays()
    for topic in topics:
        groups[topic.rpartition("/")[0]].append(topic)
    for group, names in groups.items():
        names.sort(
            key=lambda name: (not name.endswith(f"/{CLOCK}"), not name.endswith(f"/{FIRST}"))
        )
        first = next((name for name in names if name.endswith(f"/{FIRST}")), names[0])
        received = np.array(topics[first].received)
        arrays |= {name: _rows_at(received, topics[name]) for name in names}
        arrays[f"{group}/{RECEIPT}"] = received
    return arrays


def _rows_at(received: Array, messages: Messages) -> Array:
    """Return the numbers (n, k) of the messages that were received nearest to the times (n,)."""
    widths = np.array(messages.widths[NUMBERS])
    width = int(np.bincount(widths).argmax())
    rows = rows_of(np.array(messages.values[NUMBERS]), widths, width)
    order = np.argsort(own := np.array(messages.received), kind="stable")
    own, rows = own[order], rows[order]
    after = np.clip(np.searchsorted(own, received), 1, max(len(own) - 1, 1))
    before, after = after - 1, np.minimum(after, len(own) - 1)
    nearest = np.where(received - own[before] <= own[after] - received, before, after)
    usual = np.median(np.diff(np.sort(received))) if len(received) > 1 else np.inf
    found = rows[nearest]
    found[np.abs(own[nearest] - received) > MAX_APART * usual] = np.nan
    return found[:, 0] if width == 1 else found
