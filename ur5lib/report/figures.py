"""Figures of a recording, in one house style."""

from collections.abc import Mapping
from io import BytesIO
from itertools import cycle
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ur5lib.tables import write_bytes

Array = NDArray[np.float64]

# Okabe and Ito's palette: told apart by colour-blind readers; dashes tell them apart in print.
STYLES: dict[str, Any] = {
    "measured": {"color": "#000000", "linewidth": 1.1},
    "first": {"color": "#0072B2", "linewidth": 1.0, "linestyle": (0, (5, 1.2))},
    "second": {"color": "#D55E00", "linewidth": 1.0, "linestyle": (0, (1.2, 1))},
    "third": {"color": "#009E73", "linewidth": 1.0, "linestyle": (0, (4, 1, 1, 1))},
    "fourth": {"color": "#CC79A7", "linewidth": 1.0},
}
HOUSE_STYLE: Any = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.constrained_layout.use": True,
    "font.size": 8,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "path.simplify_threshold": 0.5,
    "svg.hashsalt": "ur5lib",  # the same figure gives the same file
}

DOTS: Any = {"color": "#0072B2", "markersize": 1.5, "alpha": 0.4, "rasterized": True}
BAND: Any = {"color": "#009E73", "alpha": 0.25, "linewidth": 0}
SHADE: Any = {"color": "#000000", "alpha": 0.12, "linewidth": 0}
SMALLEST_SPAN = 1e-3  # of a panel

WRENCH = (("F", "N"), ("n", "Nm"))
ACCELERATION = ((r"\ddot{p}", "m/s²"), (r"\dot{\omega}", "rad/s²"))

Series = Mapping[str, tuple[Array, str]]
Symbols = tuple[tuple[str, str], tuple[str, str]]


def joint_panels(time: Array, series: Series, symbol: str, unit: str = "Nm") -> Figure:
    """Six panels, joints 1 to 6. series: by label, values (N, 6) and a style."""
    return _panels(time, series, [f"${symbol}_{joint}$ [{unit}]" for joint in range(1, 7)])


def cartesian_panels(
    time: Array,
    series: Series,
    symbols: Symbols = WRENCH,
    prefix: str = "",
    band: tuple[str, Array] | None = None,
    shaded: Array | None = None,
) -> Figure:
    """Six panels, x to z: linear left, angular right. series: by label, values (N, 6), a style.

    band: the label of a series, and the half width (N, 6) of its 95 % band; shaded: (N,), where
    the background is grey.
    """
    order = [0, 3, 1, 4, 2, 5]
    reordered = {label: (values[:, order], style) for label, (values, style) in series.items()}
    names = [f"${prefix}{symbol}_{axis}$ [{unit}]" for axis in "xyz" for symbol, unit in symbols]
    return _panels(time, reordered, names)


def scatter_panels(
    x: Array, y: Array, axes: tuple[str, str], line: tuple[Array, Array] | None = None
) -> Figure:
    """Six panels, joints 1 to 6, of samples (N, 6) over (N, 6), and a line (M, 6) over (M, 6).

    axes: what is along x and y, with units; a {} in them is the joint.
    """
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(7.2, 4.4))
        for joint, axis in enumerate(figure.subplots(2, 3).flat):
            axis.plot(x[:, joint], y[:, joint], ".", **DOTS)
            if line is not None:
                axis.plot(line[0][:, joint], line[1][:, joint], **STYLES["second"])
            axis.set(xlabel=axes[0].format(joint + 1), ylabel=axes[1].format(joint + 1))
    return figure


def residual_panels(residual: Array, against: Mapping[str, Array], unit: str) -> Figure:
    """Residuals (N, 6), a row of panels a joint, a column each over what they may depend on."""
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(7.2, 8.0))
        rows = figure.subplots(6, len(against), sharey="row")
        for joint, row in enumerate(rows):
            for axis, (name, values) in zip(row, against.items(), strict=True):
                axis.plot(values[:, joint], residual[:, joint], ".", **DOTS)
                if joint == 5:
                    axis.set_xlabel(name)
            row[0].set_ylabel(f"joint {joint + 1} [{unit}]")
    return figure


def response_panel(frequency: Array, gains: Mapping[str, Array], unit: str = "Hz") -> Figure:
    """Gain of filters over frequency, both logarithmic. gains: by label, (K,)."""
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(7.2, 3.2))
        axis = figure.subplots()
        for (label, gain), style in zip(gains.items(), cycle(STYLES.values()), strict=False):
            axis.loglog(frequency, gain, label=label, **style)
        axis.set(xlabel=f"frequency [{unit}]", ylabel="gain", ylim=(1e-4, 2))
        axis.legend(loc="lower left", frameon=False)
    return figure


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure as SVG, byte for byte the same for the same data."""
    buffer = BytesIO()
    with matplotlib.rc_context(HOUSE_STYLE):
        figure.savefig(buffer, format="svg", dpi=200, metadata={"Date": None})
    write_bytes(buffer.getvalue(), path)


def _panels(time: Array, series: Series, labels: list[str]) -> Figure:
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(7.2, 4.4))
        axes = figure.subplots(3, 2, sharex=True)
        for i, (axis, name) in enumerate(zip(axes.flat, labels, strict=True)):
            for label, (values, style) in series.items():
                axis.plot(time, values[:, i], label=label, **STYLES[style])
            axis.set_ylabel(name)
            _widen(axis)
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        handles, names = axes[0, 0].get_legend_handles_labels()
        if names:
            figure.legend(handles, names, loc="outside upper center", ncols=4, frameon=False)
    return figure


def _across(axis: Axes) -> Any:
    """Coordinates of data along x, of the panel's height along y."""
    return axis.get_xaxis_transform()


def _widen(axis: Axes) -> None:
    """Keep rounding noise from filling a panel whose values hardly change."""
    low, high = axis.get_ylim()
    missing = SMALLEST_SPAN - (high - low)
    if missing > 0:
        axis.set_ylim(low - missing / 2, high + missing / 2)
