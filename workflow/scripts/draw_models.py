"""Where each link model of an arm places mass, after Figures 5.7 and 5.8."""

from typing import Any

import numpy as np

from ur5lib.dynamics.flange import link_frames
from ur5lib.report.charts import MassModel, mass_panels
from ur5lib.report.house_style import save
from ur5lib.robots.description import Robot, load_robot
from ur5lib.robots.inertia import rigid_bodies

BENT = [0.0, -1.3, 1.1, -1.3, -1.5, 0.0]  # rad: no link hides another


def draw_models(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    rotation, origin = (part[0] for part in link_frames(robot, np.array([BENT])))
    models = {}
    for names in alike(robot):
        bodies = rigid_bodies(robot, names[0])
        centers = origin[1:] + np.einsum("kij,kj->ki", rotation[1:], bodies.center_of_mass)
        inertias = rotation[1:] @ bodies.inertia @ rotation[1:].transpose(0, 2, 1)
        models[", ".join(names)] = MassModel(bodies.mass, centers, inertias)
    save(mass_panels(origin, models), output.models)


def alike(robot: Robot) -> list[list[str]]:
    """Return models by their links: one with rotors has those of the one without."""
    groups: dict[str, list[str]] = {}
    for name, links in robot.models.items():
        rigid = links.model_copy(update={"rotor_inertias": None, "description": ""})
        groups.setdefault(repr(rigid), []).append(name)
    return [*groups.values()]
