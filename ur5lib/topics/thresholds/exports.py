"""Formats of `ur5 export`: torque thresholds at which a controller detects contact."""

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ur5lib.finished import StudyFiles

HELP = (
    "thresholds: torques that a controller takes for a contact, by joint and speed; "
    "thresholds.script: the same as a function of URScript"
)
QUESTIONS = ("force", "constants", "currents")  # bad verdicts on these forbid an export

Format = Callable[["StudyFiles | None", str, str, str], str]
"""Returns the text of an arm; see `ur5lib.commands.exported`."""


def as_json(study: "StudyFiles | None", robot: str, as_in: str, accept: str) -> str:
    """Return the thresholds of an arm as JSON, with the reason if verdicts are overruled."""
    from ur5lib.commands.overruled import overruled  # slow to import
    from ur5lib.tables import json_text
    from ur5lib.topics.thresholds.torque_thresholds import thresholds_of

    study = _study(study, as_in)
    against = overruled(study, robot, QUESTIONS, accept)
    return json_text(thresholds_of(study, robot).in_json() | against.in_json())


def as_script(study: "StudyFiles | None", robot: str, as_in: str, accept: str) -> str:
    """Return the thresholds of an arm as the text of a URScript function. Raises InputError for an
    arm that is no UR.
    """
    from ur5lib.commands.overruled import overruled
    from ur5lib.errors import InputError
    from ur5lib.topics.thresholds.torque_thresholds import thresholds_of
    from ur5lib.topics.thresholds.urscript import in_urscript

    study = _study(study, as_in)
    against = overruled(study, robot, QUESTIONS, accept)
    if not study.arm(robot).is_ur():
        raise InputError(f"URScript is of URs, {robot} is none; take --format thresholds")
    return against.as_comment(in_xml=False) + in_urscript(thresholds_of(study, robot))


def _study(study: "StudyFiles | None", as_in: str) -> "StudyFiles":
    from ur5lib.errors import InputError

    if study is None:
        raise InputError("--format thresholds is what a study fitted; name it by --results")
    if as_in:
        raise InputError("thresholds are of all recordings without contact; leave out --as-in")
    return study


FORMATS: dict[str, Format] = {"thresholds": as_json, "thresholds.script": as_script}
