"""The description of a serial arm of two to eight revolute joints, from its URDF."""

import math
import re
from collections.abc import Iterator
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from pydantic import ValidationError
from pytorch_kinematics.urdf_parser_py.urdf import URDF
from scipy.spatial.transform import Rotation

from ur5lib.errors import InputError, some
from ur5lib.robots.description import INVALID_DESCRIPTION, Pose, Robot, mistakes_in
from ur5lib.robots.individual import link_matrix, pose_of
from ur5lib.robots.inertia import joined, tensor
from ur5lib.robots.possible_bodies import change, impossibility, nearest_possible
from ur5lib.robots.statics import STANDARD_GRAVITY
from ur5lib.strict import expect_file, quoted
from ur5lib.timeseries.arrays import Array

MIN_JOINTS = 2
MAX_JOINTS = 8
REVOLUTE_TYPES = ("revolute", "continuous")
PLACEHOLDER_MASS, PLACEHOLDER_INERTIA = 1.0, 0.01 * np.eye(3)  # kg, kg m²
ASSUMED_TORQUE, ASSUMED_VELOCITY = 1000.0, 3.0  # Nm, rad/s; for limits that a file lacks
GRAVITY = (0.0, 0.0, -STANDARD_GRAVITY)  # m/s², axes of the base link
MAX_USUAL_ANGLE, MAX_USUAL_LENGTH = 4 * np.pi, 10.0  # rad, m
NUMERIC_TAGS = ("origin", "axis", "mass", "inertia", "limit")
PHYSICAL = "physical"  # link model of possible bodies
XACRO = "xacro"  # part of the names of elements that xacro replaces
RIGHT_ANGLE_TOLERANCE = 1e-11  # a rotation's entry may err by this: 1.57079632679 is a right angle


def robot_from_urdf(
    path: Path, base: str | None = None, tip: str | None = None, physical: bool = False
) -> tuple[Robot, list[str]]:
    """Return the arm between two links of a URDF, and sentences on what had to be assumed.

    base: link that does not move, by default the root; tip: link with the flange's frame, by
    default the one that the last joint turns. Joint k turns about the z axis of frame k - 1; frame
    0 lies where the first axis is nearest to the base link's origin. Bodies fixed to a link belong
    to it; joints off the chain are at zero.
    If masses are left out, or the same in all links, the links are unknown; limits of effort or
    velocity that are left out are assumed. physical: add and choose the link model PHYSICAL, in
    which inertias that no body has are replaced by the nearest possible ones. Raises InputError
    where the file is no URDF, has no such chain of 2 to 8 revolute joints, or lacks limits of
    angles.
    """
    tree = _read(path)
    base = _known_link(tree, base or _root(tree, path), path)
    tip = _known_link(tree, tip or _tip(tree, base, path), path)
    joints = _chain(tree, base, tip, path)
    names = {joint.name for joint in joints}
    bodies = [dict(_hanging_links(tree, joint.child, np.eye(4), names)) for joint in joints]
    _expect_ranges(joints, path)
    start, *frames = _joint_frames(tree, base, tip, joints, bodies)
    tails = [_z_to(joint.axis).T @ frame for joint, frame in zip(joints, frames, strict=True)]
    # frame 0 may lie anywhere on the first axis: where it is nearest to the base link's origin
    along = np.eye(4)
    along[2, 3] = start[:3, 3] @ start[:3, 2]
    start, tails[0] = start @ np.linalg.inv(along), along @ tails[0]
    links = [_as_one(tree, *pair) for pair in zip(bodies, frames, strict=True)]
    models, impossible = {"maker": _model(links, path)}, _impossible_links(tree, bodies)
    if physical and impossible:
        possible = [_as_one(tree, *pair, physical) for pair in zip(bodies, frames, strict=True)]
        models[PHYSICAL] = _model(possible, path, f", {some([*impossible])} made possible")
    unknown = placeholders(tree, joints, bodies)
    description = {
        "name": re.sub(r"[^A-Za-z0-9_.-]+", "-", tree.name or path.stem).lstrip("."),
        "gravity": (start[:3, :3].T @ GRAVITY + 0.0).tolist(),
        "calibration": [pose_of(tail) for tail in tails],
        "joints": [joint.name for joint in joints],
        "effort": "torque",
        "motors": {joint.name: _motor(joint) for joint in joints},
        "endless_joints": [k for k, j in enumerate(joints, 1) if j.type == "continuous"] or None,
        "links": "unknown" if unknown else "known",
        "masses": [mass for mass, _, _ in links],
        "chosen_model": [*models][-1],
        "models": models,
    }
    try:
        robot = Robot.model_validate(description)
    except ValidationError as error:
        raise InputError(
            f"the arm of {path} {INVALID_DESCRIPTION}: {mistakes_in(error)}"
        ) from error
    remarks = [*_remarks(tree, base, tip, bodies, start)]
    return robot, [*remarks, *_missing(joints, unknown), *_bodies(tree, impossible, physical)]


def _read(path: Path) -> Any:
    """Return links and joints of a URDF. Raises InputError where it is none."""
    expect_file(path)
    if path.is_dir():
        raise InputError(
            f"{path} is a folder; name a URDF, or import recordings: ur5 import {path}"
        )
    try:
        root = ElementTree.fromstring(content := path.read_bytes())
    except (ElementTree.ParseError, OSError) as error:
        raise InputError(f"{path} is no URDF ({error})") from error
    if b"${" in content or any(XACRO in element.tag for element in root.iter()):
        raise InputError(f"{path} has macros of xacro; run xacro on it first")
    _expect_parts(root, path)
    try:
        _keep(root, "link", "joint")
        for link in root.iter("link"):
            _keep(link, "inertial")
        _expect_finite(root, path)
        with redirect_stderr(StringIO()):  # unknown tags of simulators
            return URDF.from_xml_string(ElementTree.tostring(root))
    except InputError:
        raise
    except Exception as error:  # the parser raises whatever its elements do
        raise InputError(f"{path} is no URDF ({' '.join(str(error).split())})") from error


def _expect_parts(root: ElementTree.Element, path: Path) -> None:
    """Raise InputError where links or joints are missing or repeated."""
    if root.tag != "robot":
        raise InputError(f"{path} is no URDF: it holds <{root.tag}>, not <robot>")
    names = {tag: [part.get("name", "") for part in root.findall(tag)] for tag in ("link", "joint")}
    if not names["link"]:
        raise InputError(f"{path} has no links of its own; give the whole arm's file")
    for tag, own in names.items():
        if repeated := sorted({name for name in own if own.count(name) > 1}):
            raise InputError(f"{path} has the {tag} {repeated[0]!r} twice; rename or remove one")
    for joint in root.findall("joint"):
        for end in [*joint.findall("parent"), *joint.findall("child")]:
            if end.get("link") not in names["link"]:
                raise InputError(
                    f"{path}: the {end.tag} of {joint.get('name')}, {end.get('link')!r}, is none "
                    "of its links; correct the name, or add the link"
                )


def _expect_finite(root: ElementTree.Element, path: Path) -> None:
    """Raise InputError for a number of a link or a joint that is NaN or infinite."""
    for part in root:
        for element in part.iter():
            numbers = element.items() if element.tag in NUMERIC_TAGS else ()
            for key, text in numbers:
                if any(map(_is_unbounded, text.split())):
                    raise InputError(
                        f"{path}: `{key}` in the <{element.tag}> of {part.get('name')} is "
                        f"{quoted(text)}; give a number"
                    )


def _is_unbounded(word: str) -> bool:
    """Return whether a word is NaN or an infinite number."""
    try:
        return not math.isfinite(float(word))
    except ValueError:
        return False


def _keep(element: ElementTree.Element, *tags: str) -> None:
    """Remove all children but those of some tags."""
    for child in [child for child in element if child.tag not in tags]:
        element.remove(child)


def _root(tree: Any, path: Path) -> str:
    roots = [link for link in tree.link_map if link not in tree.parent_map]
    if len(roots) == 1:
        return roots[0]
    if not roots:
        raise InputError(f"{path}: its links hang on each other in a circle; remove a joint")
    raise InputError(
        f"{path} has several links that hang on none: {some(roots)}; name the one that stands "
        "still by --base"
    )


def _known_link(tree: Any, link: str, path: Path) -> str:
    if link not in tree.link_map:
        raise InputError(f"{path} has no link {link!r}; its links: {', '.join(tree.link_map)}")
    return link


def _path(tree: Any, base: str, tip: str) -> list[Any] | None:
    """Return the joints from one link to another, None where the second is not attached to the
    first.
    """
    joints, link = list[Any](), tip
    while link != base:
        if link not in tree.parent_map or len(joints) > len(tree.joint_map):
            return None
        name, link = tree.parent_map[link]
        joints.insert(0, tree.joint_map[name])
    return joints


def _tip(tree: Any, base: str, path: Path) -> str:
    """Return the link at the end of the longest chain of revolute joints, if only one is."""
    turned = {j.child: _path(tree, base, j.child) for j in tree.joints if _turns(j)}
    counts = {link: sum(map(_turns, joints)) for link, joints in turned.items() if joints}
    ends = [link for link, count in counts.items() if count == max(counts.values())]
    if len(ends) != 1:
        ambiguity = (
            f"several chains are the longest; name the end of one by --tip: {', '.join(ends)}"
        )
        raise InputError(f"{path}: {ambiguity if ends else 'no revolute joint moves a link'}")
    return ends[0]


def _turns(joint: Any) -> bool:
    """Return whether a joint turns independently of other joints."""
    return joint.type in REVOLUTE_TYPES and joint.mimic is None


def _chain(tree: Any, base: str, tip: str, path: Path) -> list[Any]:
    """Return the joints that move a tip."""
    joints = _path(tree, base, tip)
    if joints is None:
        raise InputError(f"{path}: {tip} does not hang on {base}; name --base and --tip")
    moving = [joint for joint in joints if joint.type != "fixed"]
    for joint in moving:
        if not _turns(joint):
            kind = "follows another" if joint.mimic is not None else f"is {joint.type}"
            raise InputError(
                f"{path}: {joint.name} {kind}; only chains of revolute joints are described: name "
                f"the link behind it by --base, as {joint.child}, where it stands still"
            )
    if still := [joint.name for joint in moving if joint.axis is not None and not any(joint.axis)]:
        raise InputError(f"{path}: the `axis` of {some(still)} is 0 0 0; give its direction")
    if not MIN_JOINTS <= len(moving) <= MAX_JOINTS:
        raise InputError(
            f"{path}: {len(moving)} joints move {tip} against {base}; arms of {MIN_JOINTS} "
            f"to {MAX_JOINTS} revolute joints are described; name the arm's ends by --base "
            "and --tip"
        )
    return moving


def _hanging_links(
    tree: Any, link: str, place: Array, ends: set[str]
) -> Iterator[tuple[str, Array]]:
    """Yield (link, pose (4, 4)) of a link and of all links attached to it, up to the joints
    `ends`.
    """
    waiting, met = [(link, place)], set[str]()
    while waiting:
        link, place = waiting.pop()
        if link in met:  # of a circle
            continue
        met.add(link)
        yield link, place
        for name, child in reversed(tree.child_map.get(link, [])):
            if name not in ends:
                waiting.append((child, place @ _pose_matrix(tree.joint_map[name].origin)))


def _joint_frames(
    tree: Any, base: str, tip: str, joints: list[Any], bodies: list[dict[str, Array]]
) -> list[Array]:
    """Return frames 0 to n (4, 4), each in the link that carries it: the base and the joints'
    children.

    The z axis of frame k - 1 is the axis of joint k; frame n is the tip's.
    """
    names = {joint.name for joint in joints}
    standing = dict(_hanging_links(tree, base, np.eye(4), names))
    frames = []
    for joint, poses in zip(joints, [standing, *bodies], strict=False):
        frames.append(poses[joint.parent] @ _pose_matrix(joint.origin) @ _z_to(joint.axis))
    return [*frames, bodies[-1][tip]]


def _z_to(axis: Any) -> Array:
    """Return the smallest rotation (4, 4) that turns z into an axis, by default x (URDF's)."""
    x, y, z = (1.0, 0.0, 0.0) if axis is None else axis
    across = np.hypot(x, y)
    around = np.array([-y, x, 0]) / across if across else np.array([1.0, 0, 0])
    matrix = np.eye(4)
    turn = Rotation.from_rotvec(np.arctan2(across, z) * around)
    matrix[:3, :3] = _exact_rotation(turn.as_matrix())
    return matrix


def _pose_matrix(origin: Any) -> Array:
    """Return the transform (4, 4) of an `origin`, unity where it is left out."""
    if origin is None:
        return np.eye(4)
    pose = Pose(position=tuple(origin.xyz or (0, 0, 0)), rpy=tuple(origin.rpy or (0, 0, 0)))
    matrix = link_matrix(pose)
    matrix[:3, :3] = _exact_rotation(matrix[:3, :3])
    return matrix


def _exact_rotation(rotation: Array) -> Array:
    """Return a rotation with right angles made exact, as files give them with few digits."""
    rounded = np.round(rotation)
    return np.where(np.abs(rotation - rounded) < RIGHT_ANGLE_TOLERANCE, rounded, rotation) + 0.0


def _as_one(
    tree: Any, body: dict[str, Array], frame: Array, physical: bool = False
) -> tuple[float, Array, Array]:
    """Return links as one body: mass, centre of mass (3,) in a frame, and inertia tensor (3, 3)
    about it; placeholders if none has a mass.

    physical: inertias that no body has are replaced by the nearest possible ones. Links without
    mass are left out.
    """
    parts = []
    for link, place in body.items():
        inertial = tree.link_map[link].inertial
        if inertial is not None and _mass(inertial) > 0 and inertial.inertia is not None:
            pose = np.linalg.inv(frame) @ place @ _pose_matrix(inertial.origin)
            mass, R, about = _mass(inertial), pose[:3, :3], _tensor(inertial.inertia)
            if physical and impossibility(mass, about):
                about = nearest_possible(mass, about)
            parts.append((mass, pose[:3, 3], R @ about @ R.T))
    return joined(parts) if parts else (PLACEHOLDER_MASS, np.zeros(3), PLACEHOLDER_INERTIA)


def _mass(inertial: Any) -> float:
    """Return the mass [kg] of an `inertial`, 0 where it is left out."""
    return float(inertial.mass or 0.0)


def _impossible_links(tree: Any, bodies: list[dict[str, Array]]) -> dict[str, str]:
    """Return the links that state a mass and an inertia that no body has, with the reasons."""
    reasons = {}
    for link in (link for body in bodies for link in body):
        inertial = tree.link_map[link].inertial
        if inertial is not None and inertial.mass is not None and inertial.inertia is not None:
            reasons[link] = impossibility(_mass(inertial), _tensor(inertial.inertia))
    return {link: reason for link, reason in reasons.items() if reason}


def _bodies(tree: Any, impossible: dict[str, str], physical: bool) -> Iterator[str]:
    """Yield a sentence for each link with a mass and inertia that no body has; physical: whether
    these are replaced.
    """
    for link, reason in impossible.items():
        inertial = tree.link_map[link].inertial
        mass, about = _mass(inertial), _tensor(inertial.inertia)
        if mass <= 0:
            remedy = "left out; correct it in the file"
        elif physical:
            remedy = f"{change(about, nearest_possible(mass, about))} in the model `{PHYSICAL}`"
        else:
            remedy = "correct the file, or add the nearest possible one by --physical"
        yield f"{link} is no possible body: {reason}; {remedy}"


def _model(
    links: list[tuple[float, Array, Array]], path: Path, altered: str = ""
) -> dict[str, Any]:
    """Return the link model of links, (mass, centre of mass (3,), inertia tensor (3, 3)) each.

    path: of the URDF; altered: what was changed in it, "" for nothing, for the model's description.
    """
    tensors = [inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]] for _, _, inertia in links]
    return {
        "description": f"as in {path.name}{altered}",
        "centers_of_mass": [center.tolist() for _, center, _ in links],
        "inertias": [entries.tolist() for entries in tensors],
    }


def _motor(joint: Any) -> dict[str, float | None]:
    low, high = _range(joint)
    return {
        "position_min": None if np.isclose(low, -high) else low,
        "position_max": high,
        "velocity_max": _stated(joint, "velocity") or ASSUMED_VELOCITY,
        "torque_max": _stated(joint, "effort") or ASSUMED_TORQUE,
    }


def _range(joint: Any) -> tuple[float, float]:
    """Return a joint's lowest and highest angle [rad]; without limits, a turn each way."""
    if joint.type == "continuous":
        return -2 * np.pi, 2 * np.pi
    limit = joint.limit
    return (limit.lower or 0.0, limit.upper or 0.0) if limit else (0.0, 0.0)


def _stated(joint: Any, key: str) -> float | None:
    """Return a joint's limit of effort [Nm] or velocity [rad/s], None if it is 0 or left out."""
    return getattr(joint.limit, key, None) or None


def _expect_ranges(joints: list[Any], path: Path) -> None:
    """Raise InputError that names every joint without a range of angles."""
    missing = [
        joint.name
        for joint in joints
        if joint.type == "revolute"
        and not (joint.limit and (joint.limit.lower or joint.limit.upper))
    ]
    if missing:
        raise InputError(
            f"{path} lacks `lower` and `upper` in the `limit` of {', '.join(missing)}: add them to "
            "the file, or call joints that turn without limit continuous"
        )


def placeholders(tree: Any, joints: list[Any], bodies: list[dict[str, Array]]) -> str:
    """Return in words why the links' masses are mere placeholders; empty if they are not."""
    lacking, masses = [], []
    for joint, body in zip(joints, bodies, strict=True):
        inertials = [tree.link_map[link].inertial for link in body]
        heavy = [one for one in inertials if one is not None and _mass(one) > 0]
        masses.append(sum(float(one.mass) for one in heavy))
        if not heavy or any(one.inertia is None or not _of_a_body(one.inertia) for one in heavy):
            lacking.append(joint.child)
    if lacking:
        return f"no mass or inertia of a body for {', '.join(lacking)}"
    bare = masses[:-1] if len(masses) > MIN_JOINTS + 1 else masses  # the last may have a tool
    alike = len(masses) > MIN_JOINTS and len(set(bare)) == 1
    all_but = "" if len(set(masses)) == 1 else " but the last"
    return f"each link{all_but} weighs {masses[0]:g} kg, as a placeholder does" if alike else ""


def _of_a_body(inertia: Any) -> bool:
    """Return whether an inertia tensor is positive semidefinite."""
    return bool(np.linalg.eigvalsh(_tensor(inertia)).min() >= 0)


def _tensor(moments: Any) -> Array:
    """Return the inertia tensor (3, 3) of an `inertia`."""
    return tensor([moments.ixx, moments.iyy, moments.izz, moments.ixy, moments.ixz, moments.iyz])


def _missing(joints: list[Any], unknown: str) -> Iterator[str]:
    """Yield sentences on what a file lacks, and what is assumed instead."""
    if unknown:
        yield (
            f"{unknown}: links, rotors and friction are found from recordings with actual_torque "
            "(`links: unknown`); write the arm's `weight` [kg] of its data sheet into the file, or "
            "the side of the gears on which its torques are logged (`effort`)"
        )
    yield (
        f"a URDF has no gear and no rotor of {', '.join(joint.name for joint in joints)}: "
        "actual_torque counts as the joints', and rotors are fitted where it shows any; where it "
        "is the motors', write `effort: motor_torque`, and each `gear_ratio`"
    )
    for key, value, unit, setting in (
        ("effort", ASSUMED_TORQUE, "Nm", "torque_max"),
        ("velocity", ASSUMED_VELOCITY, "rad/s", "velocity_max"),
    ):
        names = [joint.name for joint in joints if _stated(joint, key) is None]
        if names:
            yield (
                f"no {key} in the `limit` of {', '.join(names)}: {value:g} {unit} taken; correct "
                f"`{setting}` in the file"
            )
    ends = {joint.name: max(map(abs, _range(joint))) for joint in joints}
    if wide := [f"{name} up to {end:.4g}" for name, end in ends.items() if end > MAX_USUAL_ANGLE]:
        yield f"angles are in rad, but these joints turn far: {', '.join(wide)}; is it in degrees?"
    if far := [joint.name for joint in joints if _length(joint) > MAX_USUAL_LENGTH]:
        yield f"lengths are in m, but the origins of {', '.join(far)} are far away: are they in mm?"


def _length(joint: Any) -> float:
    """Return the distance [m] of a joint from its parent joint."""
    return 0.0 if joint.origin is None else float(np.linalg.norm(joint.origin.xyz or 0.0))


def _remarks(
    tree: Any,
    base: str,
    tip: str,
    bodies: list[dict[str, Array]],
    start: Array,
) -> Iterator[str]:
    """Yield sentences on where the frames lie, and on joints off the chain, which are fixed at
    zero.
    """
    place = ", ".join(f"{value:.6g}" for value in start[:3, 3])
    turned = "" if np.allclose(start[:3, :3], np.eye(3)) else ", turned to the axis of joint 1"
    yield f"base frame at {place} m of {base}{turned}; forces act at the origin of {tip}"
    fixed_joints = [
        tree.joint_map[name].name
        for body in bodies
        for link in body
        for name, child in tree.child_map.get(link, [])
        if child in body and tree.joint_map[name].type != "fixed"
    ]
    if fixed_joints:
        yield f"held at 0, as they are beside the chain: {', '.join(fixed_joints)}"
