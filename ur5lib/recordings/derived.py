"""Channels found from others: the arm's own force sensor, and currents from motor torques."""

import numpy as np
import pandas as pd

from ur5lib.recordings.quality import Finding, add_finding
from ur5lib.recordings.sensors import FORCE_CHANNELS
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque, link_frames
from ur5lib.tables import channel, named
from ur5lib.timeseries.arrays import Array

RAW, FREED = "ft_raw_wrench", "actual_TCP_force"
TORQUE, CURRENT = "actual_current_as_torque", "actual_current"
SENSED = "actual_torque"
FREE = "actual_torque_less_gravity"


def with_wrist_sensor(
    robot: pd.DataFrame, arm: Robot, other: bool, findings: list[Finding]
) -> pd.DataFrame:
    """Return a repaired table with `ft_fx` .. `ft_tz` of the arm's own force sensor.

    [N, Nm], environment on the arm, axes of frame 6, at the flange. robot: a repaired table; other:
    whether the study names a force sensor, whose readings are used instead.
    """
    found = _reading(robot, arm) if arm.wrist_sensor else None
    if found is None:
        return robot
    name, reading = found
    code = "other force sensor" if other else ""
    add_finding(findings, "force", "wrist sensor", "note", 1, code, name=name)
    return robot if other else robot.assign(**dict(zip(FORCE_CHANNELS, reading.T, strict=True)))


def _reading(robot: pd.DataFrame, arm: Robot) -> tuple[str, Array] | None:
    """Return the channel of the wrist sensor and its reading (N, 6) in axes of frame 6.

    The raw reading, else the controller's `actual_TCP_force` (base axes, without the configured
    payload, zeroed by the program): on a real UR5e both have the same moments, at the flange.
    """
    if _varies(robot, RAW):
        return RAW, channel(robot, RAW)
    if not _varies(robot, FREED):
        return None
    rotation = link_frames(arm, channel(robot, "actual_q"))[0][:, -1]
    halves = channel(robot, FREED).reshape(-1, 2, 3)
    return FREED, (halves @ rotation).reshape(-1, 6)


def _varies(robot: pd.DataFrame, name: str) -> bool:
    """Return whether a channel was recorded and is not one constant, as without a sensor."""
    if f"{name}_0" not in robot:
        return False
    values = channel(robot, name)
    return bool((np.nanmax(values, axis=0) > np.nanmin(values, axis=0)).any())


def with_currents(table: pd.DataFrame, arm: Robot, findings: list[Finding]) -> pd.DataFrame:
    """Return a table with currents [A] where it has only motor torques [Nm].

    They are divided by the torque constants of the arm's joints. A fit of friction finds the
    constants anew, so that errors of these cancel where currents become torques again. To torques
    less gravity, that of the arm is added before. Of joints that sense their torque,
    the constants are 1: for A, read Nm.
    """
    if f"{FREE}_0" in table and f"{TORQUE}_0" not in table:
        gravity = gravity_torque(arm, arm.chosen_model, channel(table, "actual_q"))
        table = table.assign(**named(channel(table, FREE) + gravity, TORQUE))
        add_finding(findings, "robot", "gravity added", "note", len(table), arm=arm.name)
    name = next((name for name in (TORQUE, SENSED) if f"{name}_0" in table), None)
    if name is None or f"{CURRENT}_0" in table:
        return table
    constants = np.array(arm.maker_torque_constants())
    if np.isnan(constants).any():
        add_finding(findings, "robot", "no currents", "warning", len(table), arm=arm.name)
        return table
    if name == TORQUE:
        known = {"constants": constants.tolist(), "arm": arm.name}
        add_finding(findings, "robot", "currents from torques", "note", len(table), **known)
    return table.assign(**named(channel(table, name) / constants, CURRENT))
