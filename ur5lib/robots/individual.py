"""One individual arm: a described one with numbers of its own and its calibration."""

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
    """Return the arm described in a file, under a name and with numbers of its own.

    override: as in the file, what differs; an entry of a list is named by its number, counted
    from 1. calibration: see `calibrated`. Raises InputError where one of them is invalid.
    """
    given = overridden(read_description(path), {**override, "name": name})
    try:
        robot = robot_of(given)
    except ValidationError as error:
        raise InputError(
            f"`override` of {name} does not give a valid description of an arm "
            f"(docs/robots.md): {error}"
        ) from error
    return robot if calibration is None else calibrated(robot, calibration)


def overridden(given: Any, changes: Any) -> Any:
    """Return plain data with changes: mappings key by key, lists entry by entry or as a whole."""
    if not isinstance(changes, Mapping):
        return changes
    if isinstance(given, list) and all(str(key).isdecimal() for key in changes):
        place = {int(key): change for key, change in changes.items()}
        kept = [overridden(e, place.pop(k, e)) for k, e in enumerate(given, start=1)]
        return kept + list(place.values())
    known = given if isinstance(given, Mapping) else {}
    return {**known, **{key: overridden(known.get(key), part) for key, part in changes.items()}}
