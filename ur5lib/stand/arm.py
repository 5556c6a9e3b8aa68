"""MuJoCo model of an arm, built from its description, with the sensors on its flange."""

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.robots.description import Mounting, Pose, Robot
from ur5lib.robots.inertia import rigid_bodies, tensor
from ur5lib.robots.urdf import link_tail, thick
from ur5lib.timeseries.arrays import Array

FLANGE, TOOL = "link_6", "tool"
SENSORS = {  # name: MuJoCo type, site where it is mounted
    "force": (mujoco.mjtSensor.mjSENS_FORCE, "force_sensor"),
    "torque": (mujoco.mjtSensor.mjSENS_TORQUE, "force_sensor"),
    "accelerometer": (mujoco.mjtSensor.mjSENS_ACCELEROMETER, "imu"),
    "gyroscope": (mujoco.mjtSensor.mjSENS_GYRO, "imu"),
}
POINT = 1e-12  # kg m², inertia that stands for a point mass
AT_ORIGIN = Mounting(imu=(0.0, 0.0, 0.0), force_sensor=(0.0, 0.0, 0.0))


def build_arm(robot: Robot, model: str, imu_turn: Array, step: float) -> mujoco.MjModel:
    """Return the MuJoCo model of an arm with one of its link models.

    The frame of body `link_k` is the Denavit-Hartenberg frame k; `tool`, fixed to link 6, carries
    the payload. imu_turn: rotation vector from the axes of frame 6 to the IMU's [rad]; step: of the
    integration [s]. Sensor data (12,): force, torque, accelerometer, gyroscope, each in its own
    axes. Force and torque are those of the flange on the tool, at the sensor's origin.
    """
    spec = mujoco.MjSpec()
    spec.option.gravity = robot.gravity
    spec.option.timestep = step
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    flange = _add_links(spec, robot, model)
    mounting = robot.mounting or AT_ORIGIN
    turn = Rotation.from_rotvec(imu_turn).as_quat(scalar_first=True)
    flange.add_site(name="imu", pos=mounting.imu, quat=turn)
    tool = _add_tool(flange, robot, model)
    tool.add_site(name="force_sensor", pos=mounting.force_sensor)
    for name, (kind, site) in SENSORS.items():
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)
    return spec.compile()


def _add_links(spec: mujoco.MjSpec, robot: Robot, model: str) -> mujoco.MjsBody:
    """Add the six links in series; return the last."""
    bare = robot.models[model].model_copy(update={"payload": None})
    bodies = rigid_bodies(robot.model_copy(update={"models": {model: bare}}), model)
    body = spec.worldbody
    for k, pose in enumerate(robot.link_poses()):
        body = _add_link(body, f"link_{k + 1}", pose)
        body.joints[0].armature = bodies.rotor_inertia[k]
        _set_inertia(body, bodies.mass[k], bodies.center_of_mass[k], bodies.inertia[k])
    return body


def _add_link(parent: mujoco.MjsBody, name: str, pose: Pose) -> mujoco.MjsBody:
    """Add a body with its link's Denavit-Hartenberg frame that turns about z_(k-1)."""
    rotation, translation = link_tail(pose)
    quaternion = Rotation.from_matrix(rotation).as_quat(scalar_first=True)
    body = parent.add_body(name=name, pos=translation, quat=quaternion)
    hinge = mujoco.mjtJoint.mjJNT_HINGE
    body.add_joint(name=name, type=hinge, axis=rotation[2], pos=-translation @ rotation)
    return body


def _add_tool(flange: mujoco.MjsBody, robot: Robot, model: str) -> mujoco.MjsBody:
    tool = flange.add_body(name=TOOL)
    payload = robot.models[model].payload
    if payload is not None:
        center = np.array(payload.center_of_mass)
        # MuJoCo accepts no point mass, so the mass gets a negligible inertia.
        _set_inertia(tool, payload.mass, center, tensor(payload.inertia) + POINT * np.eye(3))
    return tool


def _set_inertia(body: mujoco.MjsBody, mass: float, center: Array, inertia: Array) -> None:
    """Set mass [kg], centre of mass [m] and inertia tensor about it, axes of the body's frame."""
    full = thick(inertia)[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    body.mass, body.ipos, body.fullinertia = mass, center, full
    body.explicitinertial = True
