"""Figures that are not over time: scatter plots, filters, coverage of bands."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import cycle

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ur5lib.report.figures.house_style import (
    DOT_STYLE,
    JOINT_COLOURS,
    Drawing,
    house_style,
    nothing_to_draw,
)
from ur5lib.timeseries.arrays import Array

LINE_DASHES = ("-", "--")


@contextmanager
def joint_panels(joints: int, axes: tuple[str, str]) -> Iterator[tuple[Figure, list[Axes]]]:
    """Provide a figure and a panel for each joint; axes: labels of x and y with units, with {} for
    the joint.
    """
    rows = -(-joints // 3)
    with house_style(2.2 * rows, rows, 3) as (figure, panels):
        for empty in panels.flat[joints:]:
            empty.set_visible(False)
        for joint, axis in enumerate(panels.flat[:joints], start=1):
            xlabel, ylabel = (re.sub(r"(\w)_(\d)", r"$\1_\2$", text.format(joint)) for text in axes)
            axis.set(ylabel=ylabel)
            axis.set_xlabel(xlabel, loc="left")  # the power of ten is on the right
            axis.locator_params(axis="x", nbins=4)
        yield figure, [*panels.flat[:joints]]


def scatter_panels(
    x: Array, y: Array, axes: tuple[str, str], lines: Sequence[tuple[Array, Array]] = ()
) -> Drawing:
    """Draw a panel for each joint of samples (N, n) over (N, n).

    axes: labels of `joint_panels`; lines: (M, 6) over (M, 6), the first solid, the second dashed.
    """
    if np.isnan(x).all():
        return nothing_to_draw()
    with joint_panels(x.shape[1], axes) as (figure, panels):
        for joint, axis in enumerate(panels):
            axis.plot(x[:, joint], y[:, joint], ".", color=JOINT_COLOURS[joint], **DOT_STYLE)
            if np.isnan(x[:, joint]).all():
                axis.set(xticks=[], yticks=[])
                axis.text(0.5, 0.5, "does not move", ha="center", transform=axis.transAxes)
            for (along, values), dashes in zip(lines, LINE_DASHES, strict=False):
                axis.plot(along[:, joint], values[:, joint], dashes, color="black", linewidth=0.9)
    return Drawing(figure, by_joint(dict(zip(axes, (x, y), strict=True))))


def by_joint(columns: Mapping[str, Array]) -> pd.DataFrame:
    """Return the numbers of panels as a table, joint after joint.

    columns: (N, n), or fewer rows, by name with {} for the joint.
    """
    joints = range(next(iter(columns.values())).shape[1])
    named = {name.format(j + 1): own[:, j] for j in joints for name, own in columns.items()}
    return pd.DataFrame({name: pd.Series(own) for name, own in named.items()})


def residual_panels(residual: Array, against: Mapping[str, Array], unit: str) -> Drawing:
    """Draw residuals (N, n), a row of panels per joint, a column per explanatory variable."""
    if np.isnan(residual).all():
        return nothing_to_draw()
    joints = residual.shape[1]
    size = 7.0 * joints / 6, joints, len(against)
    with house_style(*size, sharey="row") as (figure, rows):
        for joint, row in enumerate(rows):
            for axis, (name, values) in zip(row, against.items(), strict=True):
                axis.plot(
                    values[:, joint],
                    residual[:, joint],
                    ".",
                    color=JOINT_COLOURS[joint],
                    **DOT_STYLE,
                )
                if joint == joints - 1:
                    axis.set_xlabel(name)
            row[0].set_ylabel(f"joint {joint + 1} [{unit}]")
    columns = {f"residual [{unit}]": residual, **against}
    data = {f"joint {j + 1}, {n}": columns[n][:, j] for j in range(joints) for n in columns}
    return Drawing(figure, pd.DataFrame(data))


def response_panel(frequency: Array, gains: Mapping[str, Array], unit: str = "Hz") -> Drawing:
    """Draw the gain of filters over frequency, both logarithmic. gains: six at most, (K,)."""
    with house_style(3.2) as (figure, ((axis,),)):
        dashes = cycle(["-", "--", ":"])
        for (label, gain), colour in zip(gains.items(), JOINT_COLOURS[: len(gains)], strict=True):
            axis.loglog(frequency, gain, next(dashes), label=label, color=colour)
        axis.set(xlabel=f"frequency [{unit}]", ylabel="gain", ylim=(1e-4, 2))
        axis.legend(loc="lower left", frameon=False)
    return Drawing(figure, pd.DataFrame({f"frequency [{unit}]": frequency, **gains}))


def calibration_panels(
    stated: Sequence[float],
    held: Mapping[str, Mapping[str, Array]],
    components: Sequence[str],
) -> Drawing:
    """Draw actual over nominal coverage: a panel per estimate, a line per component.

    stated: (K,) [%]; held: by estimate and by period (the first drawn solid, the second dotted),
    (K, M) [%], a column for each of the M components.
    """
    if not held:
        return nothing_to_draw()
    with house_style(2.8, 1, len(held), sharey=True) as (figure, (axes,)):
        for axis, (estimate, during) in zip(axes, held.items(), strict=True):
            axis.plot([0, 100], [0, 100], color="black", linewidth=0.8)
            for (name, shares), line in zip(during.items(), ("o-", "o:"), strict=False):
                for values, part, colour in zip(shares.T, components, JOINT_COLOURS, strict=False):
                    label = f"{part} {name}"
                    axis.plot(stated, values, line, color=colour, markersize=3, label=label)
            axis.set(title=estimate, xlabel="stated [%]", xlim=(40, 100), ylim=(0, 101))
        axes[0].set_ylabel("held [%]")
        lines, labels = axes[0].get_legend_handles_labels()
        figure.legend(lines, labels, loc="outside lower center", frameon=False, ncols=6)
    columns = {
        f"{estimate}, {part} {name} [%]": shares[:, i]
        for estimate, during in held.items()
        for name, shares in during.items()
        for i, part in enumerate(components)
    }
    return Drawing(figure, pd.DataFrame({"stated [%]": [*stated], **columns}))
