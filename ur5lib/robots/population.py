"""What is known of measured arms: torque constants and friction of their joints, as data."""

from pathlib import Path
from typing import Literal

import yaml
from pydantic import ValidationError

from ur5lib.errors import InputError
from ur5lib.robots.description import POPULATION, Positive
from ur5lib.strict import Strict, read_yaml

Trait = Literal["torque_constant", "coulomb", "viscous", "load", "offset"]


class MeasuredJoint(Strict):
    """Fitted values of a joint in SI units, each with its standard error.

    torque_max [Nm], family_constant [Nm/A]: of the motor, by which joints are compared.
    """

    torque_max: Positive
    family_constant: Positive | None = None
    values: dict[Trait, tuple[float, Positive]]


class MeasuredArm(Strict):
    """One arm: its study and source, and the days and minutes that its joints were fitted to."""

    arm: str
    study: str
    source: str
    days: int
    minutes: Positive
    joints: dict[int, MeasuredJoint]


class Measured(Strict):
    """A file of measured arms."""

    arms: list[MeasuredArm]

    def without(self, study: str) -> "Measured":
        """Return the arms of other studies: a study's own arm is known from its recordings."""
        return Measured(arms=[own for own in self.arms if own.study != study])


def population_files(name: str) -> list[str]:
    """Return the file that a study names as population: shipped, none, or a path."""
    return {"shipped": [str(POPULATION)], "none": []}.get(name, [name])


def read_measured(path: Path) -> Measured:
    """Read a file of measured arms. Raises InputError where it is none."""
    try:
        return Measured.model_validate(read_yaml(path))
    except (OSError, UnicodeDecodeError, yaml.YAMLError, ValidationError) as error:
        raise InputError(
            f"{path} is no population of measured arms: {error}; `ur5 population` writes such a "
            "file from built studies"
        ) from error
