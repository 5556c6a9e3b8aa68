"""Arms in MuJoCo: their bodies, and export as MJCF, its model format."""

from collections.abc import Sequence

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.robots.description import Pose, Robot
from ur5lib.robots.exports import JointFriction
from ur5lib.robots.inertia import WRITTEN_SHARE, link_tail, rigid_bodies, rigid_inertia, tensor
from ur5lib.timeseries.arrays import Array

TOOL_BODY = "tool"
RADIUS_SHARE = 0.09  # radius of a capsule at joint 1 over the longest link
UR_RADIUS_FACTORS = (1.0, 1.0, 0.8, 0.65, 0.65, 0.65)  # relative radii of a UR's links
OTHER_RADIUS_FACTOR = 1.7  # links of another arm are thicker by this; a Panda's radius is 6 cm
POINT_MASS_INERTIA = 1e-12  # kg m²


def mjcf(
    robot: Robot, model: str, friction: JointFriction | None, tcp: Sequence[float] | None = None
) -> str:
    """Return an arm with one of its link models as MJCF.

    Joints have the rotors' inertia as `armature`, friction as `frictionloss` and `damping`, and the
    limits of position; each has a motor with the limit of its torque. Links are capsules, which
    touch other objects of a scene, but not one another. The site `flange` is frame n; the site
    `tcp` is the pose tcp in it, position [m] and rotation vector [rad], without tcp the flange.
    Numbers have six digits, as MuJoCo writes them.
    """
    spec = mujoco.MjSpec()
    spec.modelname, spec.compiler.degree = robot.name, False
    spec.option.gravity = robot.gravity
    tool = add_arm(spec, robot, model, WRITTEN_SHARE)
    add_capsules(spec, robot)
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = 1, 0
    position, rotation = np.reshape(tcp or np.zeros(6), (2, 3))
    tool.parent.add_site(name="flange")
    quaternion = Rotation.from_rotvec(rotation).as_quat(scalar_first=True)
    tool.parent.add_site(name="tcp", pos=position, quat=quaternion)
    for k, (joint, ends) in enumerate(zip(spec.joints, robot.position_limits(), strict=True)):
        joint.name = f"joint_{k + 1}"
        joint.limited = np.isfinite(ends).all()
        if joint.limited:
            joint.range = ends
        if friction is not None and (coefficients := friction.coefficients(k + 1)):
            joint.frictionloss, viscous = coefficients
            joint.damping = (viscous, 0, 0)  # a polynomial of the velocity
        torque_max = robot.motor(k + 1).torque_max
        motor = spec.add_actuator(name=f"motor_{k + 1}", target=joint.name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.ctrllimited, motor.ctrlrange = True, (-torque_max, torque_max)
    spec.compile()
    note = "" if friction is None else f"<!-- {friction.note()} -->\n"
    return note + str(spec.to_xml())


def add_arm(spec: mujoco.MjSpec, robot: Robot, model: str, share: float = 1e-12) -> mujoco.MjsBody:
    """Add the links in series, and the tool, which carries the payload; return the tool.

    The frame of body `link_k` is the Denavit-Hartenberg frame k; `tool` is fixed to the last link.
    share: see `rigid_inertia`.
    """
    bare = robot.models[model].model_copy(update={"payload": None})
    bodies = rigid_bodies(robot.model_copy(update={"models": {model: bare}}), model)
    body = spec.worldbody
    for k, pose in enumerate(robot.link_poses()):
        body = _add_link(body, f"link_{k + 1}", pose)
        body.joints[0].armature = bodies.rotor_inertia[k]
        _set_inertia(body, bodies.mass[k], bodies.center_of_mass[k], bodies.inertia[k], share)
    tool, payload = body.add_body(name=TOOL_BODY), robot.models[model].payload
    if payload is not None:
        # MuJoCo accepts no point mass, so the mass gets a negligible inertia.
        inertia = tensor(payload.inertia) + POINT_MASS_INERTIA * np.eye(3)
        _set_inertia(tool, payload.mass, np.array(payload.center_of_mass), inertia, share)
    return tool


def add_capsules(spec: mujoco.MjSpec, robot: Robot) -> Array:
    """Add a capsule to each link of an arm in `spec`; return their radii (n,) [m].

    A capsule reaches from one link's frame to the next, as thick as the joint's housing.
    """
    longest = max(float(np.linalg.norm(np.array(pose.position))) for pose in robot.link_poses())
    factors = UR_RADIUS_FACTORS if robot.is_ur() else [OTHER_RADIUS_FACTOR] * len(robot.joints)
    radii = RADIUS_SHARE * longest * np.array(factors)
    links = [body for body in spec.bodies if body.name.startswith("link_")]
    for body, radius in zip(links, radii, strict=True):
        near_end = np.array(body.joints[0].pos)
        body.add_geom(
            name=body.name,
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            size=[radius, 0, 0],
            # to the frame's origin, or 1 mm off where both coincide
            fromto=[*near_end, 0, 0, 0 if np.linalg.norm(near_end) > 1e-3 else 1e-3],
        )
    return radii


def flange(model: mujoco.MjModel) -> int:
    """Return the index of the last link's body, which carries the tool."""
    return int(model.body(TOOL_BODY).parentid[0])


def _add_link(parent: mujoco.MjsBody, name: str, pose: Pose) -> mujoco.MjsBody:
    """Add a body that turns about z_(k-1); its frame is the link's Denavit-Hartenberg frame."""
    rotation, translation = link_tail(pose)
    quaternion = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
    body = parent.add_body(name=name, pos=translation, quat=quaternion)
    hinge = mujoco.mjtJoint.mjJNT_HINGE
    body.add_joint(name=name, type=hinge, axis=rotation[2], pos=-translation @ rotation)
    return body


def _set_inertia(
    body: mujoco.MjsBody, mass: float, center: Array, inertia: Array, share: float
) -> None:
    """Set mass [kg], centre of mass [m] and inertia tensor about it, axes of the body's frame."""
    full = rigid_inertia(inertia, share)[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    body.mass, body.ipos, body.fullinertia = mass, center, full
    body.explicitinertial = True
