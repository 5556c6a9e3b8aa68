"""The force sensor in the wrist of an e-Series arm, which the controller records."""

import numpy as np
import pandas as pd

from ur5lib.recordings.quality import Finding
from ur5lib.recordings.sensors import FORCE_CHANNELS
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

RAW, FREED = "ft_raw_wrench", "actual_TCP_force"


def with_wrist_sensor(
    robot: pd.DataFrame, arm: Robot, other: bool
) -> tuple[pd.DataFrame, list[Finding]]:
    """Return a repaired table with `ft_fx` .. `ft_tz` of the arm's own force sensor, and notes.

    [N, Nm], environment on the arm, axes of frame 6, at the flange. robot: a repaired table; other:
    whether the study names a force sensor, whose readings are used instead.
    """
    found = _reading(robot, arm) if arm.wrist_sensor else None
    if found is None:
        return robot, []
    name, reading = found
    if other:
        note = Finding("force", "wrist sensor", "note", 1, {"name": name}, "other force sensor")
        return robot, [note]
    columns = dict(zip(FORCE_CHANNELS, reading.T, strict=True))
    return robot.assign(**columns), [Finding("force", "wrist sensor", "note", 1, {"name": name})]


def _reading(robot: pd.DataFrame, arm: Robot) -> tuple[str, Array] | None:
    """Return the channel of the wrist sensor and its reading (N, 6) in axes of frame 6.

    The raw reading, else the controller's `actual_TCP_force` (base axes, without the configured
    payload, zeroed by the program): on a real UR5e both have the same moments, at the flange.
    """
    if _tells(robot, RAW):
        return RAW, channel(robot, RAW)
    if not _tells(robot, FREED):
        return None
    rotation = link_frames(arm, channel(robot, "actual_q"))[0][:, 6]
    halves = channel(robot, FREED).reshape(-1, 2, 3)
    return FREED, (halves @ rotation).reshape(-1, 6)


def _tells(robot: pd.DataFrame, name: str) -> bool:
    """Return whether a channel was recorded and is not one constant, as without a sensor."""
    if f"{name}_0" not in robot:
        return False
    values = channel(robot, name)
    return bool((np.nanmax(values, axis=0) > np.nanmin(values, axis=0)).any())
