"""The frames of an arm and where each link model places mass, after Figures 5.6, 5.7 and 5.8."""

from typing import Any

import numpy as np

from ur5lib.dynamics.flange import link_frames
from ur5lib.report.figures.arm_figures import UPRIGHT_POSTURE, frame_panels, mass_panels, placed
from ur5lib.report.figures.house_style import save
from ur5lib.robots.description import Robot, load_robot


def draw_models(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    posture = UPRIGHT_POSTURE if robot.denavit_hartenberg else [0.0] * len(robot.joints)
    rotation, origin = (part[0] for part in link_frames(robot, np.array([posture])))
    models = {", ".join(names): placed(robot, names[0], rotation, origin) for names in alike(robot)}
    save(mass_panels(origin, models), output.models)
    save(frame_panels(rotation, origin, robot.denavit_hartenberg), output.frames)


def alike(robot: Robot) -> list[list[str]]:
    """Return models by their links: one with rotors has those of the one without."""
    groups: dict[str, list[str]] = {}
    for name, links in robot.models.items():
        rigid = links.model_copy(update={"rotor_inertias": None, "description": ""})
        groups.setdefault(repr(rigid), []).append(name)
    return [*groups.values()]
