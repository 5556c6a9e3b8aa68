"""The frames of an arm and where each link model places mass, after Figures 5.6, 5.7 and 5.8."""

import numpy as np

from ur5lib.records.step import step
from ur5lib.report.figures.arm_figures import UPRIGHT_POSTURE, frame_panels, mass_panels, placed
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames


@step("arm", "frames.svg models.svg")
def draw_models(arm: Robot) -> dict[str, Drawing]:
    """Return the figures of an arm's link models and frames."""
    # upright in the thesis's frames, which only arms of six joints have
    is_ur_like = arm.denavit_hartenberg and len(arm.joints) == len(UPRIGHT_POSTURE)
    posture = UPRIGHT_POSTURE if is_ur_like else [0.0] * len(arm.joints)
    rotation, origin = (part[0] for part in link_frames(arm, np.array([posture])))
    models = {", ".join(names): placed(arm, names[0], rotation, origin) for names in alike(arm)}
    return {
        "models": mass_panels(origin, models),
        "frames": frame_panels(rotation, origin, arm.denavit_hartenberg),
    }


def alike(robot: Robot) -> list[list[str]]:
    """Return the names of an arm's link models, in groups that have the same links; rotors do not
    count.
    """
    groups: dict[str, list[str]] = {}
    for name, links in robot.models.items():
        rigid = links.model_copy(update={"rotor_inertias": None, "description": ""})
        groups.setdefault(repr(rigid), []).append(name)
    return [*groups.values()]
