"""Inverse kinematics of arms with the axes of a UR5: joints 2 to 4 parallel, 4 to 6 a wrist.

A closed form for the described lengths (Hawkins: Analytic Inverse Kinematics for the Universal
Robots UR-5/UR-10 Arms, 2013), refined by Newton's method for the frames of a calibrated arm.
"""

from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, link_frames
from ur5lib.timeseries.arrays import Array

NEWTON_STEPS = 3  # suffice for calibrations, which move frames by millimetres
POSE_TOLERANCE = 1e-6  # m, rad; largest error of a solution


def inverse_kinematics(robot: Robot, rotation: Array, position: Array) -> Array:
    """Return the joint angles (N, 8, 6) [rad] of poses of frame 6, NaN where one is out of reach.

    rotation: R_6 (N, 3, 3); position: (N, 3) [m]; both in the base frame. The eight solutions are
    ordered by the configuration of shoulder, wrist and elbow, so that each is continuous, except
    for whole turns, along a path without singularities.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        configurations = product((1, -1), repeat=3)
        q = np.stack(
            [
                _closed_form(robot, rotation, position, *configuration)
                for configuration in configurations
            ],
            axis=1,
        )
    return _refined_angles(
        robot, q.reshape(-1, 6), np.repeat(rotation, 8, axis=0), np.repeat(position, 8, axis=0)
    ).reshape(q.shape)


def _closed_form(
    robot: Robot, rotation: Array, position: Array, shoulder: int, wrist: int, elbow: int
) -> Array:
    """Return the solution (N, 6) [rad] of one configuration for the described lengths."""
    link_1, link_2, link_3, link_4, link_5, link_6 = robot.denavit_hartenberg
    # joint 1: frame 5's origin lies d4 off the plane of the upper arm
    x, y = (position - link_6.d * rotation[:, :, 2])[:, :2].T
    q1 = np.arctan2(y, x) + shoulder * np.arccos(link_4.d / np.hypot(x, y)) + np.pi / 2
    s1, c1 = np.sin(q1), np.cos(q1)
    # joints 5 and 6: R_6 seen along the axes of joints 2 to 4, which are (s1, -c1, 0)
    across = s1[:, None] * rotation[:, 0] - c1[:, None] * rotation[:, 1]
    q5 = wrist * np.arccos(np.clip(across[:, 2], -1, 1))
    side = np.sign(np.sin(q5))
    q6 = np.arctan2(-side * across[:, 1], side * across[:, 0])
    # joints 2 to 4: a planar arm in frame 1; its last link must point along frame 4
    before_wrist = rotation @ _wrist_rotation(q5, q6).mT
    forward = np.stack([c1, s1, np.zeros_like(s1)], axis=1)
    axis_4 = before_wrist[:, :, 2]
    center = position - link_6.d * rotation[:, :, 2] - link_5.d * axis_4
    across_plane, up = np.sum(center * forward, axis=1), center[:, 2] - link_1.d
    square = across_plane**2 + up**2
    q3 = elbow * np.arccos((square - link_2.a**2 - link_3.a**2) / (2 * link_2.a * link_3.a))
    q2 = np.arctan2(up, across_plane) - np.arctan2(
        link_3.a * np.sin(q3), link_2.a + link_3.a * np.cos(q3)
    )
    q234 = np.arctan2(before_wrist[:, 2, 0], np.sum(before_wrist[:, :, 0] * forward, axis=1))
    return np.stack([q1, q2, q3, q234 - q2 - q3, q5, q6], axis=1)


def _wrist_rotation(q5: Array, q6: Array) -> Array:
    """Return the rotation (N, 3, 3) from frame 4 to frame 6: R_z(q5) R_x(-90°) R_z(q6)."""
    angles = np.stack([q5, np.full_like(q5, -np.pi / 2), q6], axis=1)
    return Rotation.from_euler("ZXZ", np.nan_to_num(angles)).as_matrix()


def _refined_angles(robot: Robot, q: Array, rotation: Array, position: Array) -> Array:
    """Return angles (M, 6) [rad] corrected for the arm's calibrated frames, NaN if they miss the
    pose.
    """
    result = np.full_like(q, np.nan)
    rows = np.flatnonzero(np.isfinite(q).all(axis=1))
    q, rotation, position = q[rows], rotation[rows], position[rows]
    for _ in range(NEWTON_STEPS if robot.calibration else 0):
        # Δq = J⁺ Δx
        error = _pose_error(robot, q, rotation, position)
        q = q + np.matvec(np.linalg.pinv(geometric_jacobian(robot, q), rcond=1e-3), error)
    reached = (
        np.abs(_pose_error(robot, q, rotation, position)).max(axis=1, initial=0) < POSE_TOLERANCE
    )
    result[rows[reached]] = q[reached]
    return result


def _pose_error(robot: Robot, q: Array, rotation: Array, position: Array) -> Array:
    """Return by how much poses differ from those at the angles q, (M, 6) [m, rad], base frame."""
    rotations, origins = link_frames(robot, q)
    turn = Rotation.from_matrix(rotation @ rotations[:, 6].mT).as_rotvec()
    return np.hstack([position - origins[:, 6], turn])
