"""One individual arm: a described arm with other numbers, and its kinematic calibration.

The controller and the ROS driver describe the joints' calibrated axes by frames that cannot be
used: where two axes are almost parallel, their common normal, and with it a Denavit-Hartenberg
frame, can lie 100 m away. Each frame is therefore placed on its calibrated axis, as close as
possible to the nominal frame.
"""

import math
import warnings
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydantic import ValidationError

from ur5lib.errors import InputError
from ur5lib.robots.description import (
    INVALID_DESCRIPTION,
    DenavitHartenberg,
    Pose,
    Robot,
    mistakes_in,
    read_description,
    robot_of,
)
from ur5lib.robots.inertia import link_tail
from ur5lib.strict import expect_file
from ur5lib.timeseries.arrays import Array

DELTA_ENTRIES = ("delta_theta", "delta_d", "delta_a", "delta_alpha")
ROS_LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
# A calibration farther from the nominal frames than this belongs to another arm.
MAX_FRAME_DISTANCE = 0.05  # m
MAX_FRAME_TURN = 0.05  # rad
FIRST_AXIS_TOLERANCE = 1e-6  # m, rad; the first axis is within this of the base's


def calibrated_robot(robot: Robot, path: str | Path) -> Robot:
    """Return an arm with its individual calibration.

    path: calibration.conf of the controller, or the YAML file that `ur_calibration` of the ROS
    driver writes. Raises InputError where it is neither, or belongs to an arm of another type.
    """
    expect_file(Path(path))
    text = Path(path).read_text(encoding="utf-8")
    axes = _from_controller(text, robot.denavit_hartenberg, path) or _from_ros(text, path)
    nominal = chain([link_matrix(pose) for pose in robot.link_poses()])
    frames = [_on_axis(*pair) for pair in zip(axes[:-1], nominal[:-1], strict=True)] + axes[-1:]
    _expect_near(frames, nominal, robot.name, path)
    steps = [pose_of(np.linalg.inv(frame) @ next_frame) for frame, next_frame in pairwise(frames)]
    return robot.model_copy(update={"calibration": tuple(steps)})


def chain(steps: Sequence[Array]) -> list[Array]:
    """Return the frames (4, 4) along a chain of transforms (4, 4), starting with the base's."""
    frames = [np.eye(4)]
    for step in steps:
        frames.append(frames[-1] @ step)
    return frames


def link_matrix(pose: Pose) -> Array:
    """Return a pose as a homogeneous transform (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = link_tail(pose)
    return matrix


def pose_of(matrix: Array) -> Pose:
    """Return a homogeneous transform (4, 4) as position, and roll, pitch and yaw."""
    from scipy.spatial.transform import Rotation  # slow to import; few arms need it

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # roll and yaw are one turn where the pitch is 90°
        yaw, pitch, roll = Rotation.from_matrix(matrix[:3, :3]).as_euler("ZYX").tolist()
    x, y, z = matrix[:3, 3].tolist()
    return Pose(position=(x, y, z), rpy=(roll, pitch, yaw))


def _from_controller(
    text: str, links: Sequence[DenavitHartenberg], path: str | Path
) -> list[Array]:
    """Return frames 0 to 6 at q = 0 from deltas of θ, d, a, α; an empty list without deltas."""
    lines = [line.split("#")[0].split("=") for line in text.splitlines() if "=" in line]
    entries = {parts[0].strip(): parts[1].strip().strip("[]") for parts in lines}
    if not set(DELTA_ENTRIES) & set(entries):
        return []
    deltas = [_six_numbers(entries.get(name, ""), name, path) for name in DELTA_ENTRIES]
    steps = []
    for link, theta, d, a, alpha in zip(links, *deltas, strict=True):
        turn = link_matrix(Pose(position=(0, 0, 0), rpy=(0, 0, theta)))
        calibrated_link = DenavitHartenberg(a=link.a + a, d=link.d + d, alpha=link.alpha + alpha)
        steps.append(turn @ link_matrix(calibrated_link.pose()))
    return chain(steps)


def _six_numbers(text: str, name: str, path: str | Path) -> list[float]:
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 6 or not np.isfinite(values).all():
        raise InputError(
            f"{path}: `{name}` is not a list of six numbers; copy calibration.conf from the "
            "controller again"
        )
    return values


def _from_ros(text: str, path: str | Path) -> list[Array]:
    """Return frames on axes 1 to 6 and the flange's at q = 0, from transforms between links."""
    try:
        links = yaml.safe_load(text)["kinematics"]
        steps = [_ros_matrix(links[name]) for name in ROS_LINKS]
    except (yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"{path} is no calibration: it has neither `delta_theta` (calibration.conf of the "
            "controller) nor `kinematics` of six links (ur_calibration of the ROS driver)"
        ) from error
    frames = chain(steps)[1:]
    first = frames[0][:3, 2], frames[0][:2, 3]
    if np.abs(np.concatenate([first[0] - [0, 0, 1], first[1]])).max() > FIRST_AXIS_TOLERANCE:
        raise InputError(
            f"{path}: the first axis is not the base's z axis; give the file as the ROS driver "
            "writes it, and describe how the arm is mounted by `mounting` in the study"
        )
    return [*frames, frames[-1]]


def _ros_matrix(link: Mapping[str, float]) -> Array:
    x, y, z, roll, pitch, yaw = (
        float(link[key]) for key in ("x", "y", "z", "roll", "pitch", "yaw")
    )
    return link_matrix(Pose(position=(x, y, z), rpy=(roll, pitch, yaw)))


def _on_axis(axis: Array, nominal: Array) -> Array:
    """Return a frame with the z axis of `axis`, as close as possible to the nominal frame."""
    z, origin = axis[:3, 2], axis[:3, 3]
    # the nominal x axis, made perpendicular to z
    x = nominal[:3, 0] - z * (z @ nominal[:3, 0])
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    frame[:3, 3] = origin + z * (z @ (nominal[:3, 3] - origin))
    return frame


def _expect_near(
    frames: Sequence[Array], nominal: Sequence[Array], name: str, path: str | Path
) -> None:
    for k, (frame, nominal_frame) in enumerate(zip(frames, nominal, strict=True)):
        away = float(np.linalg.norm(frame[:3, 3] - nominal_frame[:3, 3]))
        # tr R = 1 + 2 cos of the angle between both frames
        cosine = (np.trace(frame[:3, :3].T @ nominal_frame[:3, :3]) - 1) / 2
        if away > MAX_FRAME_DISTANCE or math.acos(min(1.0, cosine)) > MAX_FRAME_TURN:
            raise InputError(
                f"{path} puts frame {k} {1000 * away:.3g} mm from where {name} has it; name the "
                "arm that the calibration belongs to"
            )


def individual_robot(
    path: str | Path, name: str, override: Mapping[str, Any], calibration: str | Path | None
) -> Robot:
    """Return the arm described in a file, with a name and overridden numbers.

    override: changed numbers, under the file's keys; an entry of a list has its number, from 1, as
    key. calibration: see `calibrated_robot`. Raises InputError where one of them is invalid.
    """
    try:
        robot = robot_of(overridden_data(read_description(path), {**override, "name": name}))
    except ValidationError as error:
        what = f"{path} with the `override` of {name}" if override else str(path)
        raise InputError(f"{what} {INVALID_DESCRIPTION}: {mistakes_in(error)}") from error
    return robot if calibration is None else calibrated_robot(robot, calibration)


def overridden_data(base: Any, changes: Any) -> Any:
    """Return plain data with changes: mappings key by key, lists entry by entry or as a whole."""
    if not isinstance(changes, Mapping):
        return changes
    if isinstance(base, list) and all(str(key).isdecimal() for key in changes):
        place = {int(key): change for key, change in changes.items()}
        changed_entries = [overridden_data(e, place.pop(k, e)) for k, e in enumerate(base, start=1)]
        return changed_entries + list(place.values())
    entries = base if isinstance(base, Mapping) else {}
    return {
        **entries,
        **{key: overridden_data(entries.get(key), part) for key, part in changes.items()},
    }
