"""Conversion between a controller's counts and the joints: gears, directions, home offsets, coupled
motors.

With C of the coupling (unit diagonal), d of the directions and N of the gear ratios, motors turn by
θ = N C d (q - q_home), and, as their power is that of the joints, τ = d Cᵀ N τ_motor.
"""

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array, Mask

POSITIONS, RATES = ("actual_q", "target_q"), ("actual_qd", "target_qd", "target_qdd")
TORQUES = ("actual_torque", "target_moment", "actual_current_as_torque")


def of_the_joints(name: str, counts: Array, arm: Robot) -> Array:
    """Return a channel (N, n) in the joints' scale and signs, converted from the controller's
    counts (N, n).
    """
    turns, home = turns_matrix(arm), np.radians(arm.drives.home_deg or 0.0)
    if name in (*POSITIONS, *RATES):
        return counts @ np.linalg.inv(turns).T + home * (name in POSITIONS)
    return counts @ torque_matrix(arm) if name in TORQUES else counts * directions(arm)


def as_counted(name: str, values: Array, arm: Robot) -> Array:
    """Return a channel (N, n) in the controller's counts, converted from the joints' scale and
    signs (N, n).
    """
    turns, home = turns_matrix(arm), np.radians(arm.drives.home_deg or 0.0)
    if name in (*POSITIONS, *RATES):
        return (values - home * (name in POSITIONS)) @ turns.T
    if name in TORQUES:
        return values @ np.linalg.inv(torque_matrix(arm))
    return values * directions(arm)


def turns_matrix(arm: Robot) -> Array:
    """Return the matrix (n, n) of counted rates per joint rate: N C d of motors, C d where the
    controller counts coupled joint angles, d where it counts joint angles.
    """
    counts = {"motor": motor_matrix, "coupled": Robot.coupling_matrix, "joint": _uncoupled}
    return counts[arm.drives.positions](arm) * directions(arm)


def torque_matrix(arm: Robot) -> Array:
    """Return M (n, n) of τᵀ = τ_countedᵀ M: N C d, or d where the controller states joint
    torques.
    """
    turns = motor_matrix(arm) if arm.effort == "motor_torque" else np.eye(len(arm.joints))
    return turns * directions(arm)


def motor_matrix(arm: Robot) -> Array:
    """Return N C (n, n), motor turns per joint turn, in the signs of the counts."""
    return np.array(arm.gear_ratios())[:, None] * _shafts(arm)


def directions(arm: Robot) -> Array:
    """Return d (n,): -1 of a joint that is counted against its axis."""
    return np.array(arm.drives.directions or np.ones(len(arm.joints)), dtype=float)


def shaft_matrix(arm: Robot) -> Array:
    """Return S = d C d (n, n): shafts turn by S q̇, in the joints' scale and signs."""
    signs = directions(arm)
    return signs[:, None] * _shafts(arm) * signs


def _shafts(arm: Robot) -> Array:
    """Return C (n, n) of the motors' shafts, which counts that are coupled do not couple."""
    return _uncoupled(arm) if arm.drives.positions == "coupled" else arm.coupling_matrix()


def _uncoupled(arm: Robot) -> Array:
    return np.eye(len(arm.joints))


def coupled_motors(shafts: Array) -> Mask:
    """Return the mask (n,) of motors that turn with other joints than their own, too."""
    return np.count_nonzero(shafts, axis=1) > 1
