"""Figures after the thesis's 5.1 to 5.4, 5.9, 5.10, 6.1, 6.2 and 6.4 to 6.9."""

from collections.abc import Mapping, Sequence

import numpy as np

from ur5lib.channels import CURRENT
from ur5lib.records.accelerations import Accelerations
from ur5lib.records.forces import FurtherForces, SensorWrenches
from ur5lib.records.signals import Signals
from ur5lib.report.figures.charts import scatter_panels
from ur5lib.report.figures.friction_figures import SYMBOLS
from ur5lib.report.figures.house_style import Drawing, nothing_to_draw
from ur5lib.report.figures.panels import joint_quantity
from ur5lib.report.figures.recording_figures import (
    ESTIMATE_STYLES,
    OptionalLines,
    draw_lines,
)
from ur5lib.report.figures.traces import ACCELERATION_PANELS, TORQUE_PANELS, WRENCH_PANELS
from ur5lib.robots.description import CurrentToTorque, Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.thesis.records import ClosedLoop
from ur5lib.topics.thesis.torque_lines import CurrentTorque

EULER_LABEL = "Euler angles, Equation 2.33 as printed"
PUBLISHED_STYLES = {
    "Fu": ("controller's estimate", "first"),
    "F": ("without friction", "second"),
    "F*": ("with friction", "third"),
}
STATE_AXES = {"q": ("q", "rad"), "qd": (r"\dot{q}", "rad/s")}  # symbol, unit


def chosen_gains(robot: Robot) -> str:
    """Return the name of the gains published for the chosen model, or "estimated" without any."""
    return robot.chosen_model if robot.chosen_model in robot.closed_loop_gains else "estimated"


def tracking_figure(signals: Signals, closed_loop: ClosedLoop, gains: str, state: str) -> Drawing:
    """Return Figures 5.1 and 5.9 (state q) or 5.2 and 5.10 (qd): the closed loop under some gains.

    The measured motion, its target and the closed loop, and the errors of the latter two.
    """
    simulated = getattr(closed_loop, state).get(gains)
    if simulated is None:
        return nothing_to_draw()
    lines: OptionalLines = {
        "measured": (getattr(signals, f"actual_{state}"), "measured"),
        "target": (getattr(signals, f"target_{state}"), "first"),
        f"closed loop, gains {gains}": (simulated, "second"),
    }
    return draw_lines(signals, lines, joint_quantity(*STATE_AXES[state]))


def older_torque_figure(
    signals: Signals, modelled: Mapping[str, Array], printed: Sequence[float]
) -> Drawing:
    """Return Figures 5.3 and 5.4 without the older model's torque: its equations are not printed.

    modelled: torques (N, 6) [Nm] by label; printed: the older model's mean absolute error (6,).
    """
    if signals.target_moment is None or not modelled:
        return nothing_to_draw()
    lines = {"controller's target_moment": (signals.target_moment, "measured")}
    lines |= {
        label: (modelled[label], style)
        for label, style in zip(modelled, ESTIMATE_STYLES, strict=False)
    }
    mean = np.ones_like(signals.target_moment) * printed
    return draw_lines(signals, lines, TORQUE_PANELS, {"[21], printed mean": (mean, "second")})


def published_force_figure(
    published: FurtherForces, sensor: SensorWrenches, kind: str, estimates: tuple[str, ...]
) -> Drawing:
    """Return Figures 6.4 to 6.9 of some estimates, as printed or corrected: values and errors."""
    lines: dict[str, tuple[Array | None, str]] = {
        "force sensor": (sensor.wrench.get(kind), "measured")
    }
    for estimate in estimates:
        label, style = PUBLISHED_STYLES[estimate]
        lines[label] = getattr(published, kind).get(estimate), style
    return draw_lines(sensor, lines, WRENCH_PANELS)


def printed_friction(
    samples: CurrentTorque | None, constants: CurrentToTorque | None
) -> tuple[Drawing, Drawing]:
    """Draw Figure 6.1, over the torque of rigid links, and Figure 6.2, over the torque including
    the printed friction, with the line of Equation 6.5.
    """
    if samples is None:
        return nothing_to_draw(), nothing_to_draw()
    labels = "τ_{} of rigid links [Nm]", f"{SYMBOLS[CURRENT]} [A]"
    rigid = scatter_panels(samples.rigid, samples.current, labels)
    if constants is None:
        return rigid, nothing_to_draw()
    torque = samples.total
    ends = np.stack([torque.min(axis=0), torque.max(axis=0)])
    lines = [(ends, (ends - constants.offset) / constants.torque_constant)]
    labels = "τ_{} with friction [Nm]", f"{SYMBOLS[CURRENT]} [A]"
    return rigid, scatter_panels(torque, samples.current, labels, lines)


def euler_figure(
    table: Signals | Accelerations, felt: Array | None, modelled: Array | None
) -> Drawing:
    """Return Figures 5.14 and 5.15 as published: acceleration through Euler angles.

    felt, modelled: of the IMU and through the angles, (N, 6) [m/s², rad/s²].
    """
    lines: OptionalLines = {"IMU": (felt, "measured"), EULER_LABEL: (modelled, "second")}
    return draw_lines(table, lines, ACCELERATION_PANELS)
