"""Figures of a recording, in one house style."""

from collections.abc import Mapping
from io import BytesIO
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

SMALLEST_SPAN = 0.1  # Nm or N, of a panel

COMPONENTS = [
    (f"{quantity}_{axis}", unit) for quantity, unit in (("F", "N"), ("n", "Nm")) for axis in "xyz"
]

Series = Mapping[str, tuple[Array, str]]


def joint_panels(time: Array, series: Series, symbol: str) -> Figure:
    """Six panels, joints 1 to 6. series: by label, values (N, 6) [Nm] and a style."""
    return _panels(time, series, [f"${symbol}_{joint}$ [Nm]" for joint in range(1, 7)])


def wrench_panels(time: Array, series: Series, prefix: str = "") -> Figure:
    """Six panels, forces left and moments right. series: by label, values (N, 6) and a style."""
    order = [0, 3, 1, 4, 2, 5]
    reordered = {label: (values[:, order], style) for label, (values, style) in series.items()}
    names = [f"${prefix}{COMPONENTS[i][0]}$ [{COMPONENTS[i][1]}]" for i in order]
    return _panels(time, reordered, names)


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure as SVG, byte for byte the same for the same data."""
    buffer = BytesIO()
    with matplotlib.rc_context(HOUSE_STYLE):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
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


def _widen(axis: Axes) -> None:
    """Keep rounding noise from filling a panel whose values hardly change."""
    low, high = axis.get_ylim()
    missing = SMALLEST_SPAN - (high - low)
    if missing > 0:
        axis.set_ylim(low - missing / 2, high + missing / 2)
