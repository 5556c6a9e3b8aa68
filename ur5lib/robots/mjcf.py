"""Arms in MuJoCo: their bodies, and export as MJCF, its model format."""

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.robots.description import Pose, Robot
from ur5lib.robots.exports import JointFriction
from ur5lib.robots.inertia import WRITTEN_SHARE, link_tail, rigid_bodies, rigid_inertia, tensor
from ur5lib.timeseries.arrays import Array

TOOL_BODY = "tool"
POINT_MASS_INERTIA = 1e-12  # kg m²


def mjcf(robot: Robot, model: str, friction: JointFriction | None) -> str:
    """Return an arm with one of its link models as MJCF.

    Joints have the rotors' inertia as `armature`, friction as `frictionloss` and `damping`, and the
    limits of position; each has a motor with the limit of its torque. Numbers have six digits, as
    MuJoCo writes them.
    """
    spec = mujoco.MjSpec()
    spec.modelname, spec.compiler.degree = robot.name, False
    spec.option.gravity = robot.gravity
    add_arm(spec, robot, model, WRITTEN_SHARE)
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


def flange(model: mujoco.MjModel) -> int:
    """Return the number of the last link, which carries the tool."""
    return int(model.body(TOOL_BODY).parentid[0])


def _add_link(parent: mujoco.MjsBody, name: str, pose: Pose) -> mujoco.MjsBody:
    """Add a body with its link's Denavit-Hartenberg frame that turns about z_(k-1)."""
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
