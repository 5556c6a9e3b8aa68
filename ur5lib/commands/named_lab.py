"""Devices, arm and names from a study that may not have recordings yet, for `ur5 record`."""

from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from ur5lib.errors import InputError
from ur5lib.recorder.lab import Lab
from ur5lib.study.arms import Arm, Name, NamedArm
from ur5lib.study.schema import explain

EXAMPLE = "devices: {robot: {address: 192.168.1.10}}"


def lab_of(plain: dict[str, Any], path: Path) -> Lab:
    """Return the devices that a study names. Raises InputError with all mistakes."""
    if "devices" not in plain:
        raise InputError(f"{path} has no `devices`; add, for example, {EXAMPLE}")
    try:
        return Lab.model_validate(plain["devices"])
    except ValidationError as error:
        mistakes = [explain(detail, Lab.model_json_schema()) for detail in error.errors()]
        raise InputError("\n".join(f"{path}: devices: {text}" for text in mistakes)) from error


def arm_of(plain: dict[str, Any], path: Path) -> Arm:
    """Return the arm of a study. Raises InputError where it names no described arm."""
    try:
        robot = TypeAdapter[Any](NamedArm).validate_python(plain.get("robot"))
    except ValidationError as error:
        raise InputError(
            f"{path}: `robot` names no described arm; give one, e.g. `robot: ur5e`"
        ) from error
    return Arm(arm=robot) if isinstance(robot, str) else robot


def checked_name(name: str) -> str:
    """Return the name of a recording. Raises InputError where it is not allowed."""
    try:
        return str(TypeAdapter[str](Name).validate_python(name))
    except ValidationError as error:
        raise InputError(
            f"{name!r} cannot name a recording; use letters, digits, `_`, `-` and dots"
        ) from error
