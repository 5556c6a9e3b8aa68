"""Descriptions of arms: reading and validation of the YAML files in this folder."""

import math
from collections.abc import Sequence
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar, get_args

import numpy as np
import yaml
from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.errors import InputError, with_controls
from ur5lib.strict import Strict, explain, plain_yaml, read_text, read_yaml
from ur5lib.timeseries.arrays import Array, Six

DESCRIPTION_FOLDER = Path(__file__).parent
JOINT_SIZES_FILE = DESCRIPTION_FOLDER / "joint_sizes.yaml"
DROPPED_KEYS = ("friction_terms", "presliding")  # keys of older descriptions, without effect
PROJECT_FOLDER = Path("robots")  # the user's project has further arms there
INVALID_DESCRIPTION = "is not a valid description of an arm (docs/robots.md)"
# A suggested load is the first share of the rated payload, or the second of the links' mass.
LOAD_SHARE, LINKS_SHARE = 0.4, 0.1
LOAD_PLACE = (0.06, 0.0, 0.05)  # m; centre of mass of the suggested load
UNNAMED_ARM = "my_arm"  # in an entry for an arm that has no description yet
# The first have the kinematics, masses and inertias of the second.
SAME_LINKS = {"ur7e": "ur5e", "ur12e": "ur10e"}
GRAVITY_RANGE = (9.0, 10.5)  # m/s², on earth
USUAL_ACCELERATION = 15.0  # rad/s²
# A coupling's matrix has at least this determinant; a single coupled motor has 1.
SMALLEST_DETERMINANT = 1e-3

Vector3 = tuple[float, float, float]
T = TypeVar("T")
PerLink = tuple[T, ...]
PerJoint = PerLink[float]
Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]


def _on_earth(gravity: Vector3) -> Vector3:
    if not GRAVITY_RANGE[0] <= math.hypot(*gravity) <= GRAVITY_RANGE[1]:
        raise ValueError("three numbers [m/s²] with a magnitude of 9 to 10.5")
    return gravity


def _no_truth_value(direction: Any) -> Any:
    if isinstance(direction, bool):
        raise ValueError("1 or -1")
    return direction


Direction = Annotated[Literal[1, -1], BeforeValidator(_no_truth_value)]
Gravity = Annotated[Vector3, AfterValidator(_on_earth)]


class Described(Strict):
    """A part of an arm's description, of which all numbers must be finite."""

    model_config = ConfigDict(allow_inf_nan=False)


class DenavitHartenberg(Described):
    """The Denavit-Hartenberg parameters of a link: length a [m], offset d [m] and twist alpha [rad]
    (Equation 2.19).
    """

    a: float
    d: float
    alpha: float

    def pose(self) -> "Pose":
        """Return Trans_z(d) Trans_x(a) Rot_x(alpha), which follows the joint's rotation."""
        return Pose(position=(self.a, 0.0, self.d), rpy=(self.alpha, 0.0, 0.0))


class Pose(Described):
    """The pose of a frame in another: position [m]; roll, pitch, yaw [rad] of R = R_z(yaw) R_y
    R_x(roll).
    """

    position: Vector3
    rpy: Vector3


class Motor(Described):
    """Manufacturer's data of a joint (Table 4.1): limits in rad, rad/s, rad/s², Nm.

    position_min: if it is not -position_max; torque_constant [Nm/A], rotor_inertia [kg m²]: of the
    motor, before the gear; family_torque_constant: of the e-Series motor of that size, if it
    differs from torque_constant.
    """

    position_min: float | None = None
    position_max: float
    velocity_max: Positive
    torque_max: Positive
    acceleration_max: Positive | None = None
    static_friction: float | None = None
    dynamic_friction: float | None = None
    viscous_friction: float | None = None
    dynamic_friction_backdrive: float | None = None
    viscous_friction_backdrive: float | None = None
    torque_constant: Positive | None = None
    family_torque_constant: Positive | None = None
    gear_ratio: Positive | None = None
    rotor_inertia: NotNegative | None = None

    @model_validator(mode="after")
    def _can_turn(self) -> Self:
        low, high = self.positions()
        if not low < high:
            raise ValueError("`position_max` must be above `position_min`, and without it above 0")
        return self

    def positions(self) -> tuple[float, float]:
        """Return the lowest and the highest angle [rad]."""
        low = -self.position_max if self.position_min is None else self.position_min
        return low, self.position_max

    def reflected_rotor(self) -> float | None:
        """Return the rotor's inertia seen through the gear [kg m²], None where unknown."""
        if self.rotor_inertia is None or self.gear_ratio is None:
            return None
        return self.rotor_inertia * self.gear_ratio**2


class Cylinder(Described):
    """A homogeneous cylinder [kg, m]; `offset`: from the link's centre of mass to its centroid."""

    axis: Literal["x", "y", "z"]
    mass: Positive
    height: Positive
    radius: Positive
    offset: Vector3 = (0.0, 0.0, 0.0)


class Payload(Described):
    """A load mounted on the flange [kg, m, kg m²]; centre of mass in frame 6.

    inertia: xx yy zz xy xz yz, about the payload's centre of mass, axes of frame 6.
    """

    mass: Positive
    center_of_mass: Vector3 = (0.0, 0.0, 0.0)
    inertia: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    def joined(self, other: "Payload | None") -> "Payload":
        """Return this payload and another as one rigid body (Equations 2.45, 2.46)."""
        if other is None:
            return self
        mass = self.mass + other.mass
        x, y, z = (
            (self.mass * first + other.mass * second) / mass
            for first, second in zip(self.center_of_mass, other.center_of_mass, strict=True)
        )
        inertias = (part.inertia_about((x, y, z)) for part in (self, other))
        xx, yy, zz, xy, xz, yz = (first + second for first, second in zip(*inertias, strict=True))
        return Payload(mass=mass, center_of_mass=(x, y, z), inertia=(xx, yy, zz, xy, xz, yz))

    def inertia_about(self, point: Vector3) -> list[float]:
        """Return xx yy zz xy xz yz [kg m²] about a point of frame 6 [m] (parallel-axis theorem)."""
        x, y, z = (c - p for c, p in zip(self.center_of_mass, point, strict=True))
        shift = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z]
        return [
            entry + self.mass * steiner for entry, steiner in zip(self.inertia, shift, strict=True)
        ]


class Model(Described):
    """A link model: the mass distribution of n links; centres of mass [m] in the link's frame.

    Each link is given either as cylinders or by its inertia tensor: xx yy zz xy xz yz [kg m²],
    about the centre of mass, axes of the link's frame. rotor_inertias: of each joint's motor,
    reflected through its gear [kg m²]; none where they are neglected. masses [kg]: where they
    differ from the robot's.
    """

    description: str
    masses: PerLink[Positive] | None = None
    centers_of_mass: PerLink[Vector3]
    cylinders: PerLink[list[Cylinder]] | None = None
    inertias: PerLink[Six] | None = None
    rotor_inertias: PerLink[NotNegative] = ()
    payload: Payload | None = None

    @model_validator(mode="after")
    def _one_kind_of_inertia(self) -> Self:
        if (self.cylinders is None) == (self.inertias is None):
            raise ValueError("a model needs either `cylinders` or `inertias`, not both")
        return self


class FullScale(Described):
    """Largest values that an IMU measures: acceleration [m/s²] and angular rate [°/s]."""

    acceleration: Positive
    angular_rate_deg: Positive


class Mounting(Described):
    """Origins of the devices' frames in frame 6 [m].

    Their axes are parallel to frame 6, except those of a turned force sensor: force_sensor_turn_deg
    is the rotation vector from frame 6 to its axes. imu_full_scale: of the IMU, None if unknown.
    """

    imu: Vector3 = (0.0, 0.0, 0.0)
    imu_full_scale: FullScale | None = None
    force_sensor: Vector3 = (0.0, 0.0, 0.0)
    force_sensor_turn_deg: Vector3 = (0.0, 0.0, 0.0)


class CurrentToTorque(Described):
    """A published map from motor current to joint torque, tau = torque_constant i + offset [Nm/A,
    Nm] (Equation 6.6).

    preliminary_torque_constant: that of Equation 6.3, without friction.
    """

    torque_constant: PerJoint
    offset: PerJoint
    preliminary_torque_constant: PerJoint


class DeadZoneFriction(Described):
    """A published friction with a dead zone (Equations 6.2 and 6.4): Coulomb [Nm], viscous [Nm
    s/rad], dead zone [rad/s].
    """

    coulomb: PerJoint
    viscous: PerJoint
    dead_zone: float


class Gains(Described):
    """The published gains of the joints' control loops: the diagonals of K0 [1/s²] and K1 [1/s] in
    Equation 2.73.
    """

    position: PerJoint
    velocity: PerJoint


class CoupledMotor(Described):
    """A motor with a shaft that turns not only with its own joint but also with another, `ratio`
    times as far.
    """

    motor: Annotated[int, Field(ge=1)]
    joint: Annotated[int, Field(ge=1)]
    ratio: float = 1.0

    @model_validator(mode="after")
    def _of_two_joints(self) -> Self:
        if self.motor == self.joint:
            raise ValueError("`motor` and `joint` of a coupling are two different joints")
        return self


class Drives(Described):
    """The relation of a controller's counts to the joints of the description.

    positions: whether positions are logged on the side of the joints or of the motors, which
    `gear_ratio` relates, or of joints of which some are counted with others by `coupling`, as a
    Fanuc's J3 from the horizontal; directions: -1 for a joint that is counted against its axis;
    home_deg: the joint's angle where the controller's is zero [°]; coupling: motors, or such
    counts, that turn with two joints.
    """

    positions: Literal["joint", "motor", "coupled"] = "joint"
    directions: PerLink[Direction] = ()
    home_deg: PerJoint = ()
    coupling: list[CoupledMotor] = Field(default_factory=list)


class Robot(Described):
    """An arm of n revolute joints: geometry, masses, link models and published constants.

    joints: the size of each joint, a key of `motors`; endless_joints: those that turn without
    limit, 1 to n; effort: measured quantity: current, joint torque, motor torque, or, as torque, a
    side that nobody stated, which counts as the joints'; drives: counts of its controller; links:
    `unknown` if masses, centres and inertias are placeholders, which the recordings replace,
    `fitted` if they have; weight: of all links together, at most [kg]; rated_payload: by the maker
    [kg]; balanced_joints: on which a spring or a counterbalance acts, 1 to n; wrist_sensor: whether
    a force sensor is built into its flange; calibration: of one individual arm, frame k as the
    turned joint k carries it, replaces `denavit_hartenberg`, which an arm described from its URDF
    lacks.
    """

    name: str
    gravity: Gravity
    denavit_hartenberg: PerLink[DenavitHartenberg] = ()
    calibration: PerLink[Pose] | None = None
    joints: PerLink[str]
    motors: dict[str, Motor]
    endless_joints: list[int] | None = None
    effort: Literal["current", "torque", "joint_torque", "motor_torque"] = "current"
    drives: Drives = Drives()
    links: Literal["known", "unknown", "fitted"] = "known"
    weight: Positive | None = None
    rated_payload: Positive | None = None
    balanced_joints: list[int] = Field(default_factory=list)
    masses: PerLink[Positive]
    models: dict[str, Model]
    chosen_model: str
    mounting: Mounting = Mounting()
    wrist_sensor: bool = False
    current_to_torque: CurrentToTorque | None = None
    friction: DeadZoneFriction | None = None
    closed_loop_gains: dict[str, Gains] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _effort_by_older_keys(cls, described: Any) -> Any:
        return described if not isinstance(described, dict) else _without_older_keys(described)

    @model_validator(mode="after")
    def _names_are_described(self) -> Self:
        unknown = sorted(set(self.joints) - set(self.motors))
        if unknown:
            raise ValueError(f"`joints` names motors missing from `motors`: {', '.join(unknown)}")
        if controls := with_controls([self.name, *self.joints, *self.models]):
            raise ValueError(f"the name {controls!r} has a control character; give another")
        if self.chosen_model not in self.models:
            raise ValueError(f"`chosen_model` must be one of {', '.join(self.models)}")
        if not (self.denavit_hartenberg or self.calibration):
            raise ValueError("an arm needs `denavit_hartenberg`")
        return self

    @model_validator(mode="after")
    def _each_joint_is_described(self) -> Self:
        constants = [
            published
            for published in (self.current_to_torque, self.friction)
            if published is not None
        ]
        gains = self.closed_loop_gains.values()
        for part in (self, self.drives, *self.models.values(), *constants, *gains):
            for name, field in type(part).model_fields.items():
                values = getattr(part, name)
                if _is_by_joint(field.annotation) and values and len(values) != len(self.joints):
                    raise ValueError(
                        f"`{name}` has {len(values)} entries; give {len(self.joints)}, one for "
                        "each of `joints`"
                    )
        return self

    @model_validator(mode="after")
    def _motors_turn_its_joints(self) -> Self:
        pairs = [(coupled.motor, coupled.joint) for coupled in self.drives.coupling]
        if any(max(pair) > len(self.joints) for pair in pairs):
            raise ValueError(f"`coupling` names a joint that is none of {len(self.joints)}")
        if repeated := {pair for pair in pairs if pairs.count(pair) > 1}:
            motor, joint = min(repeated)
            raise ValueError(f"`coupling` has motor {motor} with joint {joint} twice; remove one")
        if abs(np.linalg.det(self.coupling_matrix())) < SMALLEST_DETERMINANT:
            raise ValueError("`coupling` turns joints so that no motors move them independently")
        return self

    @model_validator(mode="after")
    def _counted_motors_have_gears(self) -> Self:
        without = [name for name in self.joints if self.motors[name].gear_ratio is None]
        if without and (self.drives.positions == "motor" or self.effort == "motor_torque"):
            raise ValueError(
                f"`drives` or `effort` counts motors, without a `gear_ratio` of "
                f"{', '.join(without)}; give it in `motors`, 1 where there is no gear"
            )
        return self

    def coupling_matrix(self) -> Array:
        """Return C (n, n): shafts turn by C q̇, in the joints' scale and the controller's signs."""
        matrix = np.eye(len(self.joints))
        for coupled in self.drives.coupling:
            matrix[coupled.motor - 1, coupled.joint - 1] = coupled.ratio
        return matrix

    @property
    def joint_numbers(self) -> range:
        """Return the numbers of the joints, from 1."""
        return range(1, len(self.joints) + 1)

    def motor(self, joint: int) -> Motor:
        """Return the motor of a joint by its number."""
        return self.motors[self.joints[joint - 1]]

    def link_poses(self) -> list[Pose]:
        """Return the constant transforms from the turned joint k to frame k, in order."""
        return list(self.calibration or (link.pose() for link in self.denavit_hartenberg))

    def gear_ratios(self) -> list[float]:
        """Return the turns of each motor per turn of its joint, 1 where they are not described."""
        return [self.motor(joint).gear_ratio or 1.0 for joint in self.joint_numbers]

    def maker_torque_constants(self) -> list[float]:
        """Return the manufacturer's torque constant of each joint [Nm/A], after the gears; NaN
        where unknown.

        For an arm that measures torques, gains of 1 Nm/Nm.
        """
        if self.measured == TORQUE:
            return [1.0 for _ in self.joints]
        motors = map(self.motor, self.joint_numbers)
        return [(m.torque_constant or math.nan) * (m.gear_ratio or math.nan) for m in motors]

    def is_counted(self) -> bool:
        """Return whether the controller's values must be converted to the joints' angles or
        torques.
        """
        return self.drives != Drives() or self.effort == "motor_torque"

    def __repr__(self) -> str:
        """Return name, joints, links and models; the whole description takes some hundred lines."""
        models = ", ".join(self.models)
        return f"Robot({self.name}: {len(self.joints)} joints, links {self.links}, models {models})"

    @property
    def measured(self) -> Effort:
        """Return the joints' measured effort: its channel, unit and words."""
        return CURRENT if self.effort == "current" else TORQUE

    def knows_rotors(self) -> bool:
        """Return whether the rotors' inertias need no fit: the fullest model has them, or the arm
        measures currents.
        """
        return bool(self.models[self.fullest_model()].rotor_inertias) or self.measured == CURRENT

    def family_torque_constants(self) -> list[float]:
        """Return the torque constants [Nm/A], after the gears, of the e-Series motors of these
        sizes; where there is none, the manufacturer's.
        """
        motors = map(self.motor, self.joint_numbers)
        return [
            m.family_torque_constant * (m.gear_ratio or math.nan)
            if m.family_torque_constant and self.measured == CURRENT
            else maker
            for m, maker in zip(motors, self.maker_torque_constants(), strict=True)
        ]

    def tells_gravity(self) -> bool:
        """Return whether the description determines the joints' torques at rest.

        Its links are described, not fitted to recordings, and no counterbalance carries a part.
        """
        return self.links == "known" and not self.balanced_joints

    def has_ur_motors(self) -> bool:
        """Return whether its joints are of the manufacturer's sizes."""
        return {*self.joints} <= {*joint_sizes()}

    def is_ur(self) -> bool:
        """Return whether its axes are a UR's: six, by their Denavit-Hartenberg parameters."""
        return len(self.joints) == 6 and bool(self.denavit_hartenberg)

    def position_limits(self) -> list[tuple[float, float]]:
        """Return each joint's lowest and highest angle [rad], infinite if it is endless."""
        endless, without = self.endless_joints or [], (-math.inf, math.inf)
        return [without if k in endless else self.motor(k).positions() for k in self.joint_numbers]

    def torque_limits(self) -> list[float]:
        """Return the largest torque of each joint's motor [Nm]."""
        return [self.motor(joint).torque_max for joint in self.joint_numbers]

    def velocity_limits(self) -> list[float]:
        """Return the largest speed of each joint [rad/s]."""
        return [self.motor(joint).velocity_max for joint in self.joint_numbers]

    def acceleration_limits(self) -> list[float]:
        """Return each joint's largest acceleration [rad/s²], the usual one if none is published."""
        motors = map(self.motor, self.joint_numbers)
        return [motor.acceleration_max or USUAL_ACCELERATION for motor in motors]

    def with_rotors(self) -> Self:
        """Return the arm with the model `<chosen>+rotors`, if its joints' rotors are described."""
        name = f"{self.chosen_model}+rotors"
        rotors = [self.motor(joint).reflected_rotor() for joint in self.joint_numbers]
        if name in self.models or None in rotors:
            return self
        bare = self.models[self.chosen_model]
        text = f"{bare.description}, and the motors' rotors reflected through their gears"
        return self.with_model(
            name,
            bare.model_copy(update={"description": text, "rotor_inertias": tuple(rotors)}),
        )

    def fullest_model(self) -> str:
        """Return the most complete model: identified, else with rotors, else the chosen one."""
        names = ("identified", f"{self.chosen_model}+rotors")
        return next((name for name in names if name in self.models), self.chosen_model)

    def with_model(self, name: str, model: Model) -> Self:
        """Return the arm with a model added, or replaced if the name exists."""
        return self.model_copy(update={"models": self.models | {name: model}})

    def known_load(self) -> Payload | None:
        """Return a suggested load, which the arm carries well and which shows the wrist's torque
        constants.

        Its mass is a share of the rated payload or, without one, of the links' mass; None for
        unknown links.
        """
        mass = LOAD_SHARE * (self.rated_payload or 0.0)
        if not mass and self.links != "unknown":
            mass = LINKS_SHARE * sum(self.masses)
        if not mass:
            return None
        return Payload(mass=float(f"{mass:.1g}"), center_of_mass=LOAD_PLACE)

    def carrying(self, payload: Payload | None) -> Self:
        """Return the arm with a further payload on its flange, in each of its models."""
        if payload is None:
            return self
        models = {
            name: model.model_copy(update={"payload": payload.joined(model.payload)})
            for name, model in self.models.items()
        }
        return self.model_copy(update={"models": models})

    def with_force_sensor(self, position: Vector3 | None, turn_deg: Vector3 | None) -> Self:
        """Return the arm with its force sensor at another position [m] and turn [°]; None: as
        described.
        """
        place = {"force_sensor": position, "force_sensor_turn_deg": turn_deg}
        changes = {name: value for name, value in place.items() if value is not None}
        return self.model_copy(update={"mounting": self.mounting.model_copy(update=changes)})

    def mounted(self, gravity: Sequence[float] | None) -> Self:
        """Return the arm under another gravity (3,) [m/s²], base frame; None: as described."""
        if gravity is None:
            return self
        x, y, z = map(float, gravity)
        return self.model_copy(update={"gravity": (x, y, z)})


def _without_older_keys(described: dict[str, Any]) -> dict[str, Any]:
    """Return a description with `effort` in place of older keys.

    They are `torques` of drives, or a torque constant of 1 for all motors. Terms of friction, which
    recordings select, are dropped.
    """
    described = {key: value for key, value in described.items() if key not in DROPPED_KEYS}
    drives, motors = described.get("drives"), described.get("motors")
    if isinstance(drives, dict) and "torques" in drives:
        rest = {key: value for key, value in drives.items() if key != "torques"}
        side = {"effort": f"{drives['torques']}_torque"} if drives["torques"] else {}
        if side and described.get("effort") not in (None, "torque", side["effort"]):
            raise ValueError("`effort` and `torques` of `drives` differ; remove the latter")
        described = described | {"drives": rest} | side
    if "effort" in described or not isinstance(motors, dict):
        return described
    named = [motors.get(str(name)) for name in described.get("joints") or ()]
    ones = [isinstance(motor, dict) and motor.get("torque_constant") == 1 for motor in named]
    return described | {"effort": "torque"} if ones and all(ones) else described


def _is_by_joint(kind: Any) -> bool:
    """Return whether the type of a field is a tuple with a number for each joint (`PerLink`), or
    such a tuple or None.
    """
    return any(Ellipsis in get_args(alternative) for alternative in (kind, *get_args(kind)))


def robot_names() -> list[str]:
    """Return the names of the arms described here, and in the folder `robots` of the project."""
    described = [path for path in DESCRIPTION_FOLDER.glob("*.yaml") if path != JOINT_SIZES_FILE]
    return sorted({path.stem for path in [*described, *PROJECT_FOLDER.glob("*.yaml")]})


def no_description(name: str) -> str:
    """Return the message for an arm without description, with the most similar known name."""
    if name == UNNAMED_ARM:
        return (
            f"`{name}` stands for an arm that no file names: write its own name here, one of "
            f"{', '.join(robot_names())}, or import again with --robot; `ur5 describe` describes "
            "another arm"
        )
    names_by_letters = {
        _letters(described_name): described_name for described_name in robot_names()
    } | SAME_LINKS
    [nearest_name] = get_close_matches(_letters(name), names_by_letters, n=1, cutoff=0.8) or [""]
    meant = f" (did you mean `{names_by_letters[nearest_name]}`?)" if nearest_name else ""
    known = ", ".join(robot_names())
    if name.lower().endswith((".urdf", ".xacro")):
        return f"{name} is no name of an arm; describe it first, by a name: ur5 describe {name}"
    return f"no description of `{name}`{meant}; docs/robots.md shows how to add one to {known}"


def described(robot: str) -> Robot:
    """Return the description of an arm by its name. Raises InputError where the arm has none."""
    if robot not in robot_names():
        raise InputError(no_description(robot))
    return load_robot(robot_path(robot))


def _letters(name: str) -> str:
    """Return the lower-case letters and digits of a name, so that `UR-5e` is found as `ur5e`."""
    return "".join(filter(str.isalnum, name.lower()))


def robot_path(name: str) -> Path:
    """Return the YAML file that describes an arm: that of the project, else the one here."""
    project = PROJECT_FOLDER / f"{name}.yaml"
    return project if project.is_file() else DESCRIPTION_FOLDER / f"{name}.yaml"


def load_robot(path: str | Path) -> Robot:
    """Read one arm's description, e.g. from `robot_path("ur5")`.

    Raises InputError when the file is invalid.
    """
    try:
        return _described(read_text(Path(path)), str(path))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"{path} {INVALID_DESCRIPTION}: {error}") from error


@cache
def _described(text: str, source: str) -> Robot:
    """Return the arm of a description's text; cached, as each job of a process reads it again."""
    try:
        return robot_of(plain_yaml(text, source))
    except ValidationError as error:
        raise InputError(f"{source} {INVALID_DESCRIPTION}: {mistakes_in(error)}") from error


def mistakes_in(error: ValidationError) -> str:
    """Return what is wrong with a description, in words."""
    schema = Robot.model_json_schema()
    return "; ".join(explain(detail, schema) for detail in error.errors())


def read_description(path: str | Path) -> Any:
    """Return the content of an arm's description, with the motors of its joints' sizes.

    Raises InputError when the file cannot be read as YAML.
    """
    try:
        return with_motors(read_yaml(Path(path)))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"{path} {INVALID_DESCRIPTION}: {error}") from error


def robot_of(description: Any) -> Robot:
    """Return the arm of a description. Raises pydantic's ValidationError when it is invalid."""
    return Robot.model_validate(with_motors(description)).with_rotors()


def robot_yaml(robot: Robot) -> str:
    """Return an arm as YAML, which `load_robot` reads."""
    return yaml.safe_dump(robot.model_dump(mode="json", exclude_none=True), sort_keys=False)


def with_motors(description: Any) -> Any:
    """Return an arm's description with the motors of its joints' sizes added."""
    if not isinstance(description, dict) or not isinstance(description.get("joints"), list):
        return description
    described = description.get("motors", {})
    if not isinstance(described, dict):
        return description
    missing = [size for size in map(str, description["joints"]) if size not in described]
    shared = {size: joint_sizes()[size] for size in missing if size in joint_sizes()}
    return description | {"motors": shared | described} if shared else description


@cache
def joint_sizes() -> dict[str, dict[str, float]]:
    """Return the motors of the manufacturer's joints, as plain data, by their size."""
    return dict(read_yaml(JOINT_SIZES_FILE))
