"""Export of an arm's joints as actuators of Isaac Lab."""

import math
from collections.abc import Mapping, Sequence

import yaml

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.joint_friction import JointFriction
from ur5lib.timeseries.arrays import Array

HEAD = """\
# Fields of ImplicitActuatorCfg in Isaac Lab 2, for the joints of `ur5 export --to urdf`.
# Units: Nm, rad/s, kg m2, Nm s/rad; friction is in Nm since Isaac Sim 5.
# The joints are driven by torque: for control of position, set stiffness and damping.
"""


def isaac(robot: Robot, model: str, friction: JointFriction | None) -> str:
    """Return the joints of an arm as YAML: `arm` holds the fields of Isaac Lab's actuators.

    The rotors of a link model are `armature`; Coulomb friction is `friction` (at rest) and
    `dynamic_friction`. Friction is left out where none was identified.
    """
    motors = [robot.motor(k) for k in robot.joint_numbers]
    names = [f"joint_{k}" for k in robot.joint_numbers]
    fields: dict[str, Sequence[float] | Array] = {
        "effort_limit_sim": [motor.torque_max for motor in motors],
        "velocity_limit_sim": [motor.velocity_max for motor in motors],
        "stiffness": [0.0 for _ in motors],
        "damping": [0.0 for _ in motors],
        "armature": rigid_bodies(robot, model).rotor_inertia,
    }
    if friction is not None:
        coulomb, viscous = friction.coulomb, friction.viscous
        fields |= {"friction": coulomb, "dynamic_friction": coulomb, "viscous_friction": viscous}
    arm = {"joint_names_expr": names, **_by_joint(fields, names)}
    return HEAD + yaml.safe_dump({"arm": arm}, sort_keys=False)


def _by_joint(
    fields: Mapping[str, Sequence[float] | Array], names: Sequence[str]
) -> dict[str, dict[str, float]]:
    """Return the values of each field by joint, without those that are unknown."""
    return {
        name: {
            joint: float(value)
            for joint, value in zip(names, values, strict=True)
            if not math.isnan(value)
        }
        for name, values in fields.items()
    }
