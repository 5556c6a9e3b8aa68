"""The figure of a designed trajectory: its path, spectra, margins, predicted errors and sweep."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ur5lab.excitation.design import Design
from ur5lab.excitation.objective import Worth
from ur5lab.excitation.trajectory import Margins, Path
from ur5lib.report.figures.house_style import HOUSE_STYLE, JOINT_COLOURS, PAGE_WIDTH, Drawing
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

DRAWN_RATE = 20.0  # Hz; of drawn states
DRAWN_POSTURES = 25  # in each view of the arm's sweep
SWEEP_VIEWS = {
    "from above": (0, 1),
    "from the side": (0, 2),
    "from the front": (1, 2),
}  # axes of each
PANEL_LAYOUT: Any = [
    ["path"] * 3,
    ["spectrum"] * 3,
    ["margins"] * 3,
    ["errors"] * 3,
    [*SWEEP_VIEWS],
]
PANEL_HEIGHTS = (1.2, 0.8, 0.8, 1.2, 1.6)


def excitation_figure(design: Design) -> Drawing:
    """Return the figure; its data are the drawn angles."""
    time, states = design.path.sampled(DRAWN_RATE)
    with plt.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(PAGE_WIDTH, 1.5 * PAGE_WIDTH), layout="constrained")
        panels = figure.subplot_mosaic(PANEL_LAYOUT, height_ratios=PANEL_HEIGHTS)
        _draw_path(panels["path"], time, states.q)
        _draw_spectrum(panels["spectrum"], design.path)
        _draw_margins(panels["margins"], design.margins)
        _draw_errors(panels["errors"], design.worth, design.task.problem.count)
        _, origins = link_frames(design.task.cell.robot, states.q)
        for view, axes in SWEEP_VIEWS.items():
            _draw_sweep(panels[view], view, origins[..., list(axes)], ["xyz"[k] for k in axes])
    columns = {f"q_{joint + 1}": states.q[:, joint] for joint in range(states.q.shape[1])}
    return Drawing(figure, pd.DataFrame({"time": time} | columns))


def _draw_path(panel: Axes, time: Array, q: Array) -> None:
    for joint, (angle, color) in enumerate(zip(q.T, JOINT_COLOURS, strict=False), 1):
        panel.plot(time, angle, color=color, label=f"joint {joint}")
    panel.set(xlabel="time [s]", ylabel="angle [rad]")
    panel.legend(
        ncols=q.shape[1],
        columnspacing=0.8,
        handlelength=1,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
    )


def _draw_spectrum(panel: Axes, path: Path) -> None:
    """Draw the amplitude of each harmonic of each joint."""
    sines, cosines = np.split(path.coefficients, 2)
    frequency = np.arange(1, len(sines) + 1) / path.seconds
    for amplitude, color in zip(np.hypot(sines, cosines).T, JOINT_COLOURS, strict=False):
        panel.plot(frequency, amplitude, ".-", color=color, linewidth=0.8, markersize=3)
    panel.set(xlabel="frequency [Hz]", ylabel="amplitude [rad]")


def _draw_margins(panel: Axes, margins: Margins) -> None:
    """Draw the largest share of each limit that the trajectory uses, a bar for each joint."""
    percents = 100 * np.array([*margins.used.values()])
    count, width = percents.shape[1], 1 / (percents.shape[1] + 2)
    for joint, (shares, color) in enumerate(zip(percents.T, JOINT_COLOURS, strict=False)):
        place = np.arange(len(shares)) + (joint - (count - 1) / 2) * width
        panel.bar(place, shares, width, color=color)
    panel.axhline(100, color="black", linewidth=0.8)
    panel.set_xticks(range(len(margins.used)), list(margins.used))
    panel.set_ylabel("share of the limit [%]")


def _draw_errors(panel: Axes, worth: Worth, links: int) -> None:
    """Draw the ratio of standard errors after and before the recording, for each parameter; links:
    number of base parameters.
    """
    place = np.arange(len(worth.before))
    panel.semilogy(place, worth.after / worth.before, "o", color=JOINT_COLOURS[0], markersize=2.5)
    panel.axvspan(-0.5, links - 0.5, color="black", alpha=0.06, linewidth=0)
    panel.axhline(1, color="black", linewidth=0.8)
    panel.set(
        xlabel="parameter, as in excitation.json (shaded: base parameters)",
        ylabel="std. error after / before",
    )


def _draw_sweep(panel: Axes, title: str, origins: Array, axes: list[str]) -> None:
    """Draw the arm at some times, and the flange's path; origins: (N, n + 1, 2) [m]."""
    for arm in origins[:: max(1, len(origins) // DRAWN_POSTURES)]:
        panel.plot(*arm.T, color="black", linewidth=0.6, alpha=0.35)
    panel.plot(*origins[:, -1].T, color=JOINT_COLOURS[1], linewidth=0.8)
    panel.set(title=title, xlabel=f"{axes[0]} [m]", ylabel=f"{axes[1]} [m]", aspect="equal")
