"""Formats of `ur5 export`: an arm's file for the live estimator, and the estimator itself."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ur5lib.finished import StudyFiles

HELP = (
    "live: what the estimator of the force needs while the arm runs; live.py, live.hpp, "
    "live.schema.json: this estimator in Python and C++, and what describes that file; ros2: a "
    "folder with a node, its launch file and all it needs"
)
FILES = ("live.py", "live.hpp", "live.schema.json")
NODE = {
    "ur5_force.py": "ros2_node.py",
    "ur5_force.launch.py": "ros2_launch.py",
    "live.py": "live.py",
}
QUESTIONS = ("force", "constants", "currents")  # bad verdicts on these forbid an export

Format = Callable[["StudyFiles | None", str, str, str], str]
"""Returns the text of an arm; see `ur5lib.commands.exported`."""


def arm_file(study: "StudyFiles | None", robot: str, as_in: str, accept: str) -> str:
    """Return an arm's file for the live estimator, with the user's reason if verdicts are
    overruled.
    """
    from ur5lib.commands.overruled import overruled  # slow to import
    from ur5lib.errors import InputError
    from ur5lib.tables import json_text
    from ur5lib.topics.live.arm_file import known_of_arm
    from ur5lib.topics.live.live import read_arm

    if study is None:
        raise InputError("--format live is what a study fitted; name its folder by --results")
    known = known_of_arm(study, robot, as_in)
    text = json_text(known | overruled(study, robot, QUESTIONS, accept).in_json())
    try:
        read_arm(text)
    except ValueError as error:
        raise InputError(
            f"{study.folder} has no live estimate of this version; `ur5 run` it again ({error})"
        ) from error
    return text


def _text(name: str, *_: object) -> str:
    """Return the text of a file of the live estimator, by its name."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def ros2_folder(study: "StudyFiles | None", robot: str, as_in: str, accept: str) -> dict[str, str]:
    """Return the files of a ROS 2 node for an arm, by name."""
    texts = {name: _text(own) for name, own in NODE.items()}
    return texts | {"arm.json": arm_file(study, robot, as_in, accept) + "\n"}


FORMATS: dict[str, Format] = {"live": arm_file, **{name: partial(_text, name) for name in FILES}}
FOLDERS = {"ros2": ros2_folder}
