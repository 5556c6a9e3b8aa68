"""Figures 6.1 and 6.2 of the thesis: raw currents over modelled torques, and the printed line."""

import numpy as np

from ur5lib.pipeline.published_constants import CurrentTorque
from ur5lib.report.charts import scatter_panels
from ur5lib.report.house_style import Drawing, nothing_to_draw
from ur5lib.robots.description import CurrentToTorque

CURRENT = "i_{} [A]"


def without_friction(samples: CurrentTorque | None) -> Drawing:
    """Draw Figure 6.1: torque of rigid links."""
    if samples is None:
        return nothing_to_draw()
    return scatter_panels(samples.rigid, samples.current, ("τ_{} of rigid links [Nm]", CURRENT))


def with_friction(samples: CurrentTorque | None, constants: CurrentToTorque | None) -> Drawing:
    """Draw Figure 6.2: torque including the printed friction, and the line of Equation 6.5."""
    if samples is None or constants is None:
        return nothing_to_draw()
    torque = samples.total
    ends = np.stack([torque.min(axis=0), torque.max(axis=0)])
    lines = [(ends, (ends - constants.offset) / constants.torque_constant)]
    return scatter_panels(torque, samples.current, ("τ_{} with friction [Nm]", CURRENT), lines)
