"""Figures that are not over time: scatter plots, filters, coverage of bands, masses of links."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import NamedTuple

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from ur5lib.report.house_style import (
    DOTS,
    FITTED_DOTS,
    HOUSE_STYLE,
    JOINTS,
    WIDTH,
    Drawing,
    nothing_to_draw,
)
from ur5lib.timeseries.arrays import Array

MARGIN = 0.2  # m, around an arm


class MassModel(NamedTuple):
    """masses (6,) [kg], centres of mass (6, 3) [m], inertias about them (6, 3, 3), base axes."""

    masses: Array
    centers: Array
    inertias: Array


def scatter_panels(
    x: Array,
    y: Array,
    axes: tuple[str, str],
    line: tuple[Array, Array] | None = None,
    fitted: Array | None = None,
) -> Drawing:
    """Draw six panels, joints 1 to 6, of samples (N, 6) over (N, 6).

    axes: labels of x and y with units; {} stands for the joint.
    line: a line (M, 6) over (M, 6); fitted: (N, 6) over the same x, in black.
    """
    if np.isnan(x).all():
        return nothing_to_draw()
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
        for joint, axis in enumerate(figure.subplots(2, 3).flat):
            axis.plot(x[:, joint], y[:, joint], ".", color=JOINTS[joint], **DOTS)
            if line is not None:
                axis.plot(line[0][:, joint], line[1][:, joint], color="black", linewidth=0.9)
            if fitted is not None:
                axis.plot(x[:, joint], fitted[:, joint], ".", color="black", **FITTED_DOTS)
            axis.set(xlabel=axes[0].format(joint + 1), ylabel=axes[1].format(joint + 1))
    columns = {axes[0]: x, axes[1]: y} | ({} if fitted is None else {f"fitted {axes[1]}": fitted})
    data = {name.format(j + 1): column[:, j] for j in range(6) for name, column in columns.items()}
    return Drawing(figure, pd.DataFrame(data))


def residual_panels(residual: Array, against: Mapping[str, Array], unit: str) -> Drawing:
    """Draw residuals (N, 6), a row of panels per joint, a column per explanatory variable."""
    if np.isnan(residual).all():
        return nothing_to_draw()
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(WIDTH, 7.0), layout="constrained")
        rows = figure.subplots(6, len(against), sharey="row")
        for joint, row in enumerate(rows):
            for axis, (name, values) in zip(row, against.items(), strict=True):
                axis.plot(values[:, joint], residual[:, joint], ".", color=JOINTS[joint], **DOTS)
                if joint == 5:
                    axis.set_xlabel(name)
            row[0].set_ylabel(f"joint {joint + 1} [{unit}]")
    columns = {f"residual [{unit}]": residual, **against}
    data = {f"joint {j + 1}, {name}": columns[name][:, j] for j in range(6) for name in columns}
    return Drawing(figure, pd.DataFrame(data))


def response_panel(frequency: Array, gains: Mapping[str, Array], unit: str = "Hz") -> Drawing:
    """Draw the gain of filters over frequency, both logarithmic. gains: six at most, (K,)."""
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(WIDTH, 3.2), layout="constrained")
        axis = figure.subplots()
        dashes = cycle(["-", "--", ":"])
        for (label, gain), colour in zip(gains.items(), JOINTS[: len(gains)], strict=True):
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
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
        axes = figure.subplots(1, len(held), sharey=True, squeeze=False)[0]
        for axis, (estimate, during) in zip(axes, held.items(), strict=True):
            axis.plot([0, 100], [0, 100], color="black", linewidth=0.8)
            for (name, shares), line in zip(during.items(), ("o-", "o:"), strict=False):
                for values, part, colour in zip(shares.T, components, JOINTS, strict=False):
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


def mass_panels(joints: Array, bodies: Mapping[str, MassModel]) -> Drawing:
    """Draw the links' masses of each model from the side (x, z), one panel per model.

    joints: (7, 3) [m], origins of the frames.
    """
    # undetermined parameters can have any value, so the arm sets the limits of the axes
    wide, high = ((np.min(x) - MARGIN, np.max(x) + MARGIN) for x in (joints[:, 0], joints[:, 2]))
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(WIDTH, 2.6 * -(-len(bodies) // 3)), layout="constrained")
        axes = figure.subplots(-(-len(bodies) // 3), 3, sharex=True, sharey=True, squeeze=False)
        for axis in axes.flat[len(bodies) :]:
            axis.set_visible(False)
        for axis, (name, body) in zip(axes.flat, bodies.items(), strict=False):
            axis.plot(joints[:, 0], joints[:, 2], "o-", color="#999999", markersize=3)
            for link, colour in enumerate(JOINTS):
                axis.add_patch(_ellipse(body, link, colour))
            size = 12 * body.masses
            axis.scatter(body.centers[:, 0], body.centers[:, 2], size, JOINTS, zorder=3)
            axis.set(title=name, aspect="equal", xlabel="x [m]", xlim=wide, ylim=high)
        for axis in axes[:, 0]:
            axis.set_ylabel("z [m]")
    columns = ["mass [kg]", "x [m]", "y [m]", "z [m]"]
    tables = [
        pd.DataFrame(np.column_stack([body.masses, body.centers]), columns=columns).assign(
            model=name, link=range(1, 7)
        )
        for name, body in bodies.items()
    ]
    return Drawing(figure, pd.concat(tables))


def _ellipse(body: MassModel, link: int, colour: str) -> Ellipse:
    """Return the outline of a homogeneous ellipsoid of the link's mass and inertia, seen along y.

    Its mass is spread with covariance (tr(I)/2 1 − I) / m, a fifth of its squared half-axes.
    """
    inertia = body.inertias[link]
    spread = (np.trace(inertia) / 2 * np.eye(3) - inertia) / body.masses[link]
    squares, axes = np.linalg.eigh(5 * spread[np.ix_([0, 2], [0, 2])])
    width, height = 2 * np.sqrt(np.maximum(squares, 0))
    angle = np.degrees(np.arctan2(axes[1, 0], axes[0, 0]))
    x, _, z = body.centers[link]
    return Ellipse((x, z), width, height, angle=angle, color=colour, alpha=0.25)
