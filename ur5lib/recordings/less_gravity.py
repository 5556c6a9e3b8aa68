"""Torques from which a controller took the gravity of its arm and payload: both are added again."""

import numpy as np
import pandas as pd

from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, add_finding
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import channel, named
from ur5lib.timeseries.arrays import Array

TORQUE_LESS_GRAVITY = "actual_torque_less_gravity"
ROWS = 2000  # that show whether gravity is in a torque
FULL_FRICTION_SPEED = 0.02  # rad/s
MIN_CHANGE = 2.0  # Nm, by which a joint's gravity changes where it bears
MIN_BEARING_JOINTS = 2
MAX_SHARE_OF_GRAVITY = 0.2
MAX_BESIDE_MOTION = 0.15  # of the squares of a torque less gravity; of others, 0.29 and more


def with_gravity(
    table: pd.DataFrame, whole: str, arm: Robot, payload: Payload | None, findings: list[Finding]
) -> pd.DataFrame:
    """Return a table in which torques less gravity are complete, under the name `whole`.

    payload: as declared. A UR's torques named `whole` count as less gravity if it is not in them.
    """
    name = TORQUE_LESS_GRAVITY
    if f"{whole}_0" in table:
        if not (arm.is_ur() and lacks_gravity(table, whole, arm)):
            return table
        name = whole
        detail = (
            f"{whole} has no gravity in it, as UR's controller and its ROS 2 driver since 2026 "
            f"report it: read as {TORQUE_LESS_GRAVITY}"
        )
        add_finding(findings, "robot", Found.LESS_GRAVITY, "warning", len(table), detail)
    if f"{name}_0" not in table:
        return table
    loaded = arm.carrying(payload)
    gravity = gravity_torque(loaded, loaded.chosen_model, channel(table, "actual_q"))
    load = f" and of the declared payload of {payload.mass:.3g} kg" if payload else ""
    detail = (
        f"{name}: the gravity torque of {arm.name}{load} is added again; the controller took off "
        "that of the payload that it was given"
    )
    add_finding(findings, "robot", Found.GRAVITY_ADDED, "note", len(table), detail)
    return table.assign(**named(channel(table, name) + gravity, whole))


def lacks_gravity(table: pd.DataFrame, name: str, arm: Robot) -> bool:
    """Return whether friction and inertia alone explain a torque of joints that bear gravity."""
    if not arm.tells_gravity() or "actual_q_0" not in table:
        return False
    rows = np.unique(np.linspace(0, len(table) - 1, min(ROWS, len(table))).astype(int))
    q, torque = (channel(table, one)[rows] for one in ("actual_q", name))
    rate = np.gradient(q, axis=0) if len(rows) > 1 else np.zeros_like(q)
    if "actual_qd_0" in table:
        rate = channel(table, "actual_qd")[rows]
    finite = np.isfinite(np.hstack([q, torque, rate])).all(axis=1)
    if finite.sum() < ROWS / 10 or torque.shape != q.shape:
        return False
    q, torque, rate = q[finite], torque[finite], rate[finite]
    gravity = gravity_torque(arm, arm.chosen_model, q)
    bearing = np.flatnonzero(np.ptp(gravity, axis=0) > MIN_CHANGE)
    shown = [_shares(torque[:, k], gravity[:, k], rate[:, k]) for k in bearing]
    return len(shown) >= MIN_BEARING_JOINTS and all(
        abs(share) < MAX_SHARE_OF_GRAVITY and left < MAX_BESIDE_MOTION for share, left in shown
    )


def _shares(torque: Array, gravity: Array, rate: Array) -> tuple[float, float]:
    """Return the coefficient of gravity in a torque (N,), and the share of the torque's squares
    that friction does not explain.
    """
    motion = np.column_stack([np.tanh(rate / FULL_FRICTION_SPEED), rate, np.gradient(rate)])
    both = np.column_stack([gravity, motion])
    share = float(np.linalg.lstsq(both, torque, rcond=None)[0][0])
    left = torque - motion @ np.linalg.lstsq(motion, torque, rcond=None)[0]
    return share, float((left**2).sum() / ((torque**2).sum() + 1e-300))
