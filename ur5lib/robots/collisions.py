"""Collisions of an arm with itself and with the table, by capsules around its links, in MuJoCo.

A capsule reaches from one Denavit-Hartenberg frame to the next, as thick as the joint's housing:
coarse, and meant for a warning before an arm moves, not for planning close to things.
"""

from itertools import combinations

import mujoco
import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.robots.mjcf import add_arm
from ur5lib.timeseries.arrays import Array

THICKNESS = 0.09  # radius of a capsule as a share of the longest link's length, at joint 1
THINNER = (1.0, 1.0, 0.8, 0.65, 0.65, 0.65)  # of the further links
TABLE = "table"


def collisions(robot: Robot, q: Array, table: float | None) -> list[tuple[int, str, str]]:
    """Return the collisions along a path: sample, and the two parts, each pair of these once.

    q: (N, 6) [rad], so dense that nothing is skipped; table: height of a horizontal plane in the
    base frame [m], None for none. Links are `link_1` to `link_6`; `table` is the plane.
    """
    model = _capsules(robot, table)
    data, found = mujoco.MjData(model), dict[tuple[str, str], int]()
    for sample, data.qpos in enumerate(q):
        mujoco.mj_fwdPosition(model, data)
        for contact in data.contact:
            names = sorted(model.geom(geom).name for geom in contact.geom)
            found.setdefault((names[0], names[1]), sample)
    return [(sample, *pair) for pair, sample in found.items()]


def _capsules(robot: Robot, table: float | None) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    add_arm(spec, robot, robot.chosen_model)
    poses = [np.array(pose.position) for pose in robot.link_poses()]
    radius = THICKNESS * max(float(np.linalg.norm(position)) for position in poses)
    links = [body for body in spec.bodies if body.name.startswith("link_")]
    for body, thinner in zip(links, THINNER, strict=True):
        near = np.array(body.joints[0].pos)
        body.add_geom(
            name=body.name,
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[radius * thinner, 0, 0],
            fromto=[*near, *_far_end(near)],
        )
    _exclude_neighbours(spec, [body.name for body in links])
    if table is not None:
        plane = mujoco.mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(name=TABLE, type=plane, size=[5, 5, 1], pos=[0, 0, table])
        spec.add_exclude(bodyname1="world", bodyname2="link_1")
    return spec.compile()


def _far_end(near: Array) -> Array:
    """Return the far end of a capsule: the frame's origin, or just beside where both coincide."""
    return np.zeros(3) if np.linalg.norm(near) > 1e-3 else np.array([0.0, 0.0, 1e-3])


def _exclude_neighbours(spec: mujoco.MjSpec, names: list[str]) -> None:
    """Links that a joint joins, or two, at the wrist three, overlap by construction."""
    for first, second in combinations(range(6), 2):
        if second - first <= (3 if first >= 2 else 1):
            spec.add_exclude(bodyname1=names[first], bodyname2=names[second])
