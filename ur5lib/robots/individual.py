"""One individual arm: a described arm with other numbers and its calibration."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ur5lib.errors import InputError
from ur5lib.robots.calibration import calibrated
from ur5lib.robots.description import Robot, read_description, robot_of


def individual_robot(
    path: str | Path, name: str, override: Mapping[str, Any], calibration: str | Path | None
) -> Robot:
    """Return the arm described in a file, with a name and overridden numbers.

    override: the differences, with the file's keys; an entry of a list is named by its number,
    counted from 1. calibration: see `calibrated`. Raises InputError where one of them is invalid.
    """
    try:
        robot = robot_of(overridden(read_description(path), {**override, "name": name}))
    except ValidationError as error:
        raise InputError(
            f"`override` of {name} does not give a valid description of an arm "
            f"(docs/robots.md): {error}"
        ) from error
    return robot if calibration is None else calibrated(robot, calibration)


def overridden(base: Any, changes: Any) -> Any:
    """Return plain data with changes: mappings key by key, lists entry by entry or as a whole."""
    if not isinstance(changes, Mapping):
        return changes
    if isinstance(base, list) and all(str(key).isdecimal() for key in changes):
        place = {int(key): change for key, change in changes.items()}
        kept = [overridden(e, place.pop(k, e)) for k, e in enumerate(base, start=1)]
        return kept + list(place.values())
    entries = base if isinstance(base, Mapping) else {}
    return {**entries, **{key: overridden(entries.get(key), part) for key, part in changes.items()}}
