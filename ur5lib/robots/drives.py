"""From the counts of a controller to the joints: gears, directions, home offsets, coupled motors.

With C of the coupling (unit diagonal), d of the directions and N of the gear ratios, motors turn by
θ = N C (q - q_home) / d, and, as their power is that of the joints, τ = d Cᵀ N τ_motor.
"""

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


def directions(arm: Robot) -> Array:
    """Return d (n,): -1 of a joint that is counted against its axis."""
    return np.array(arm.drives.directions or np.ones(len(arm.joints)), dtype=float)


def gear_ratios(arm: Robot, side: str) -> Array:
    """Return the motors' turns per turn of their joints (n,), 1 for counts on the joints' side."""
    ratios = [arm.motor(joint).gear_ratio or 1.0 for joint in arm.joint_numbers]
    return np.array(ratios if side == "motor" else np.ones(len(ratios)))


def coupling_matrix(arm: Robot) -> Array:
    """Return C (n, n) of shafts C q̇, in the joints' scale and the controller's signs."""
    matrix = np.eye(len(arm.joints))
    for coupled in arm.drives.coupling:
        matrix[coupled.motor - 1, coupled.joint - 1] = coupled.ratio
    return matrix


def joint_positions(arm: Robot, counts: Array) -> Array:
    """Return q (N, n) [rad] of counted positions."""
    return joint_rates(arm, counts) + np.radians(arm.drives.home_deg or 0.0)


def joint_rates(arm: Robot, counts: Array) -> Array:
    """Return q̇ = d C⁻¹ N⁻¹ θ̇ (N, n) of counted rates; counts at the joints are free of C and N."""
    side = arm.drives.positions
    turned = counts / gear_ratios(arm, side)
    if side == "motor":
        turned = turned @ np.linalg.inv(coupling_matrix(arm)).T
    return turned * directions(arm)


def joint_torques(arm: Robot, counts: Array) -> Array:
    """Return τ = d Cᵀ N τ_motor (N, n) of counted torques; those at the joints are free of C, N."""
    side = arm.drives.torques
    shaft = counts * gear_ratios(arm, side)
    return (shaft @ coupling_matrix(arm) if side == "motor" else shaft) * directions(arm)


def shaft_rates(arm: Robot, rates: Array) -> Array:
    """Return the rates (N, n) of the motors' shafts, d C d q̇, in the joints' scale and signs."""
    signs = directions(arm)
    return (rates * signs) @ coupling_matrix(arm).T * signs
