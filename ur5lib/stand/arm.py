"""MuJoCo model of an arm, built from its description, with the sensors on its flange."""

import mujoco
from scipy.spatial.transform import Rotation

from ur5lib.robots.description import Mounting, Robot
from ur5lib.robots.mjcf import TOOL, add_arm
from ur5lib.timeseries.arrays import Array

SENSORS = {  # name: MuJoCo type, site where it is mounted
    "force": (mujoco.mjtSensor.mjSENS_FORCE, "force_sensor"),
    "torque": (mujoco.mjtSensor.mjSENS_TORQUE, "force_sensor"),
    "accelerometer": (mujoco.mjtSensor.mjSENS_ACCELEROMETER, "imu"),
    "gyroscope": (mujoco.mjtSensor.mjSENS_GYRO, "imu"),
}
AT_ORIGIN = Mounting(imu=(0.0, 0.0, 0.0), force_sensor=(0.0, 0.0, 0.0))


def build_arm(robot: Robot, model: str, imu_turn: Array, step: float) -> mujoco.MjModel:
    """Return the MuJoCo model of an arm with one of its link models.

    imu_turn: rotation vector from the flange's axes to the IMU's [rad]; step: of the
    integration [s]. Sensor data (12,): force, torque, accelerometer, gyroscope, each in its own
    axes. Force and torque are those of the flange on the tool, at the sensor's origin.
    """
    spec = mujoco.MjSpec()
    spec.option.gravity = robot.gravity
    spec.option.timestep = step
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    tool = add_arm(spec, robot, model)
    mounting = robot.mounting or AT_ORIGIN
    turn = Rotation.from_rotvec(imu_turn).as_quat(scalar_first=True)
    tool.parent.add_site(name="imu", pos=mounting.imu, quat=turn)
    tool.add_site(name="force_sensor", pos=mounting.force_sensor)
    for name, (kind, site) in SENSORS.items():
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)
    return spec.compile()


def flange(model: mujoco.MjModel) -> int:
    """Return the number of the last link, which carries the tool."""
    return int(model.body(TOOL).parentid[0])
