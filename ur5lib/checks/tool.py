"""Check of the tool's pose against that of the flange, which the arm and its joints determine."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.channels import columns, joint_count
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

# In right recordings, the tool stays within 0.002 m of its place on the flange.
MAX_TOOL_DISTANCE = 0.01


def tool_off_flange(robot: pd.DataFrame, arm: Robot) -> Iterator[Finding]:
    """Find a tool that does not stay at its place on the flange; robot: a repaired table."""
    if "actual_TCP_pose_0" not in robot:
        return
    distance = tool_distance(*tool_and_angles(robot), arm)
    if distance > MAX_TOOL_DISTANCE:
        detail = (
            f"by actual_TCP_pose, the tool moves by {number(1000 * distance, '.0f')} mm (median) "
            f"on the flange of {arm.name}; correct `robot`, or columns and units"
        )
        yield contradiction(CauseCode.TOOL_OFF_FLANGE, "robot", detail)


def tool_and_angles(robot: pd.DataFrame) -> tuple[Array, Array]:
    """Return the tool's positions (N, 3) [m] and the angles (N, n) [rad] in about a thousand
    received frames of a repaired table, evenly chosen.
    """
    names = columns("actual_TCP_pose") + columns("actual_q", joint_count(robot))
    frames = robot.loc[~robot["interpolated"], names]
    frames = frames.dropna(subset=["actual_TCP_pose_0", "actual_q_0"])
    frames = frames.iloc[:: max(1, len(frames) // 1000)]
    return channel(frames, "actual_TCP_pose")[:, :3], channel(frames, "actual_q")


def shown_tool_center(robot: pd.DataFrame, arm: Robot) -> list[float] | None:
    """Return the tool centre point [m] in the last frame, by `actual_TCP_pose`; None where it
    was not recorded, or moves on the flange.
    """
    if "actual_TCP_pose_0" not in robot:
        return None
    tool, q = tool_and_angles(robot)
    if not len(q) or tool_distance(tool, q, arm) > MAX_TOOL_DISTANCE:
        return None
    center: list[float] = np.median(on_flange(tool, q, arm), axis=0).tolist()
    return center


def on_flange(tool: Array, q: Array, arm: Robot) -> Array:
    """Return the places (N, 3) [m] of the tool in the last joint's frame; arguments as of
    `tool_distance`.
    """
    rotation, origin = link_frames(arm, q)
    return np.einsum("nij,ni->nj", rotation[:, -1], tool - origin[:, -1])


def tool_distance(tool: Array, q: Array, arm: Robot) -> float:
    """Return how far the tool is from its place on the flange (median) [m].

    tool: positions (N, 3) [m]; q: angles (N, n) [rad].
    """
    place = on_flange(tool, q, arm)
    return float(np.median(np.linalg.norm(place - np.median(place, axis=0), axis=1)))
