"""The arm of a recording: its description, with individual numbers, mounting and tool."""

import math
import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from ur5lib.robots.description import (
    DESCRIPTION_FOLDER,
    PROJECT_FOLDER,
    Gravity,
    Payload,
    Robot,
    Six,
    Vector3,
    load_robot,
    no_description,
    robot_names,
    robot_path,
)
from ur5lib.robots.individual import individual_robot
from ur5lib.strict import Strict, existing_file

TILT_ANGLES = {"floor": 0.0, "wall": 90.0, "ceiling": 180.0}  # degrees

NAME_PATTERN = r"^[A-Za-z0-9_-][A-Za-z0-9_.-]{0,199}$"  # a file's name, with an ending
NAME_CHARACTERS = "at most 200 letters, digits, `_`, `-`; dots too, except as the first character"
PERIODIC_NAME = re.compile(r"(.+)\1{19}$")  # Snakemake mistakes such a name for a circle of rules


def _aperiodic(name: str) -> str:
    if PERIODIC_NAME.search(name):
        raise ValueError("a name that does not end in 20 times the same")
    return name


Name = Annotated[  # becomes the name of a folder
    str,
    Field(
        pattern=NAME_PATTERN,
        description="name, also of its folder in results",
        json_schema_extra={"characters": NAME_CHARACTERS},
    ),
    AfterValidator(_aperiodic),
]


def _described(name: str) -> str:
    if name not in robot_names():
        raise PydanticCustomError("no_description", "{message}", {"message": no_description(name)})
    if (DESCRIPTION_FOLDER / f"{name}.yaml").is_file() and (
        PROJECT_FOLDER / f"{name}.yaml"
    ).is_file():
        file = PROJECT_FOLDER / f"{name}.yaml"
        raise ValueError(f"another name to {file}: ur5lib describes a {name} too")
    if not re.match(NAME_PATTERN, name):
        raise ValueError(f"a name of {NAME_CHARACTERS}; rename {PROJECT_FOLDER / name}.yaml")
    return name


DescribedArm = Annotated[str, AfterValidator(_described)]


class Tilt(Strict):
    """The angles by which the base of a mounted arm is tilted."""

    tilt_deg: float = Field(
        ge=-180,
        le=180,
        description="turn about the base's x axis: 0 on the floor, 90 on a wall, 180 on a ceiling",
    )
    rotation_deg: float = Field(
        0.0, ge=-360, le=360, description="turn about the base's z axis before it is tilted"
    )


def _type_of(value: Any) -> str:
    """Return the JSON type of a value, so that errors mention only that type."""
    if isinstance(value, str):
        return "string"
    return "array" if isinstance(value, list | tuple) else "object"


MountingSetting = Annotated[
    Annotated[Literal["floor", "wall", "ceiling"], Tag("string")]
    | Annotated[Gravity, Tag("array")]
    | Annotated[Tilt, Tag("object")],
    Discriminator(_type_of),
]


def base_gravity(mounting: Any, size: float) -> Vector3:
    """Return gravity in the base frame [m/s²] of a mounted arm; size: its magnitude.

    A tilt θ about the base's x axis turns the base's acceleration against gravity to g [0, sin θ,
    cos θ], as in URScript's `set_gravity`; a turn φ about z before it rotates that vector by −φ.
    """
    if isinstance(mounting, tuple):
        return mounting
    tilt = mounting if isinstance(mounting, Tilt) else Tilt(tilt_deg=TILT_ANGLES[mounting])
    theta, phi = math.radians(tilt.tilt_deg), math.radians(tilt.rotation_deg)
    up = math.sin(theta) * math.sin(phi), math.sin(theta) * math.cos(phi), math.cos(theta)
    x, y, z = (round(-size * part, 12) + 0.0 for part in up)
    return x, y, z


class Tool(Payload):
    """The permanent tool on the flange, as configured at the controller [kg, m, kg m²]; frame 6.

    inertia: xx yy zz xy xz yz, about its centre of mass; tcp: pose of its tool centre point,
    position [m] and rotation vector [rad].
    """

    tcp: Six | None = Field(
        None, description="pose of the tool centre point: position [m], rotation vector [rad]"
    )

    def payload(self) -> Payload:
        """Return the tool as a load on the flange."""
        return Payload(mass=self.mass, center_of_mass=self.center_of_mass, inertia=self.inertia)


class ArmSettings(Strict):
    """One individual arm: the described arm that it is, and what differs from that description."""

    arm: DescribedArm = Field(description="the arm as described in ur5lib/robots/ or robots/")
    name: Name | None = Field(
        None, description="its name in results; default: that of the description"
    )
    override: dict[str, Any] | None = Field(
        None,
        description="numbers of the description that are different, by its keys; the entry of a "
        "list by its number, from 1",
    )
    calibration: Annotated[str, AfterValidator(existing_file)] | None = Field(
        None,
        description="its kinematic calibration: calibration.conf of the controller, or the YAML "
        "file that the ROS driver extracts",
    )
    mounting: MountingSetting | None = Field(
        None,
        description="how it stands: floor, wall, ceiling, angles, or gravity in the base frame "
        "[m/s²]; default: as described",
    )
    tool: Tool | None = Field(None, description="what is mounted on its flange")

    @property
    def known_as(self) -> str:
        """Return the arm's name in results."""
        return self.name or self.arm

    def itself(self) -> "ArmSettings":
        """Return the arm's settings without mounting and tool, which may differ between its
        recordings.
        """
        return self.model_copy(update={"mounting": None, "tool": None})

    def description(self) -> Robot:
        """Return the arm's description. Raises InputError where it is invalid."""
        path, override = robot_path(self.arm), self.override or {}
        return individual_robot(path, self.known_as, override, self.calibration)

    def gravity(self, mounting: Any) -> Vector3 | None:
        """Return gravity in the base frame [m/s²] under a mounting; None: as described."""
        if mounting is None:
            return None
        return base_gravity(mounting, math.hypot(*load_robot(robot_path(self.arm)).gravity))


NamedArm = Annotated[
    Annotated[DescribedArm, Tag("string")] | Annotated[ArmSettings, Tag("object")],
    Discriminator(_type_of),
]
