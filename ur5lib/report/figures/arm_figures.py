"""Drawings of an arm: its frames, and where its link models place mass."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from scipy.spatial import ConvexHull

from ur5lib.report.figures.house_style import JOINT_COLOURS, PAGE_WIDTH, Drawing, house_style
from ur5lib.robots.description import Cylinder, DenavitHartenberg, Robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.timeseries.arrays import Array

UPRIGHT_POSTURE = [
    0.0,
    -np.pi / 2,
    0.0,
    -np.pi / 2,
    0.0,
    0.0,
]  # rad, position 2 of Figure 4.1 of a UR
DRAWING_MARGIN = 0.03  # m; around the drawing
MAX_DISTANCE_FROM_JOINTS = 0.3  # m; the axes end at most this far from the joints
PANELS_PER_ROW = 4  # panels
CIRCLE_ANGLES = np.linspace(0, 2 * np.pi, 48, endpoint=False)  # rad; points of a drawn circle
SIDE_VIEW = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])  # along x: y to the right, z up
# The same view, with x drawn towards the lower left.
OBLIQUE_VIEW = np.array([[-0.45, 1.0, 0.0], [-0.3, 0.0, 1.0]])
AXIS_COLOURS = {"x": "#D55E00", "y": "#009E73", "z": "#0072B2"}
AXIS_LENGTH = 0.11  # share of the drawing's largest extent
LABEL_DISTANCE = 8  # points from the tip of an axis
PLACE_COLUMNS, PARAMETER_COLUMNS = ["x [m]", "y [m]", "z [m]"], ["a [m]", "d [m]", "alpha [rad]"]


class MassModel(NamedTuple):
    """A link model in base axes, with the outlines of its bodies to draw.

    masses: of the links (6,) [kg]; centers: centres of mass (6, 3) [m]; outlines: by link, the
    outline of each body seen along x, (K, 2) [m] in y and z; bodies: "cylinders" or "ellipses".
    """

    masses: Array
    centers: Array
    outlines: Sequence[Sequence[Array]]
    bodies: str


def placed(robot: Robot, name: str, rotation: Array, origin: Array) -> MassModel:
    """Return a link model in base axes, with its cylinders or, if it has none, ellipsoids.

    rotation: (7, 3, 3), origin: (7, 3) [m], of frames 0 to 6.
    """
    bodies, turns = rigid_bodies(robot, name), rotation[1:]
    centers = origin[1:] + np.einsum("kij,kj->ki", turns, bodies.center_of_mass)
    cylinders = robot.models[name].cylinders
    if cylinders is not None:
        links = zip(cylinders, centers, turns, strict=True)
        outlines = [[cylinder_outline(part, at, turn) for part in link] for link, at, turn in links]
    else:
        inertias = turns @ bodies.inertia @ turns.transpose(0, 2, 1)
        tensors = zip(bodies.mass, inertias, centers, strict=True)
        outlines = [[ellipsoid_outline(*link)] for link in tensors]
    drawn = "ellipses" if cylinders is None else "cylinders"
    return MassModel(bodies.mass, centers, outlines, drawn)


def cylinder_outline(part: Cylinder, center: Array, rotation: Array) -> Array:
    """Return the outline (K, 2) [m] of a cylinder seen along x.

    center: (3,) [m], the link's centre of mass; rotation: (3, 3), of the link's frame; base axes.
    """
    along = np.roll([1.0, 0.0, 0.0], "xyz".index(part.axis))
    circle = np.outer(np.cos(CIRCLE_ANGLES), np.roll(along, 1)) + np.outer(
        np.sin(CIRCLE_ANGLES), np.roll(along, 2)
    )
    ends = [part.radius * circle + sign * part.height / 2 * along for sign in (-1, 1)]
    projected = (center + (np.concatenate(ends) + part.offset) @ rotation.T) @ SIDE_VIEW.T
    corners: Array = projected[ConvexHull(projected).vertices]
    return corners


def ellipsoid_outline(mass: float, inertia: Array, center: Array) -> Array:
    """Return the outline (K, 2) [m], seen along x, of a homogeneous ellipsoid of a mass [kg] and an
    inertia about its centre (3, 3) [kg m²], base axes.

    The covariance of its mass, (tr(I)/2 1 − I) / m, is a fifth of the squared half-axes.
    """
    spread = (np.trace(inertia) / 2 * np.eye(3) - inertia) / mass
    squares, axes = np.linalg.eigh(5 * SIDE_VIEW @ spread @ SIDE_VIEW.T)
    circle = np.column_stack([np.cos(CIRCLE_ANGLES), np.sin(CIRCLE_ANGLES)])
    outline: Array = SIDE_VIEW @ center + circle * np.sqrt(np.maximum(squares, 0)) @ axes.T
    return outline


def mass_panels(joints: Array, models: Mapping[str, MassModel]) -> Drawing:
    """Draw the links' masses of each model, seen along x, one panel per model.

    joints: (n + 1, 3) [m], origins of the frames.
    """
    line = joints @ SIDE_VIEW.T
    bodies = [body for model in models.values() for link in model.outlines for body in link]
    low, high = _limits(line, bodies)
    panels = min(PANELS_PER_ROW, len(models))
    rows = -(-len(models) // panels)
    height = min(4.6, PAGE_WIDTH / panels * (high - low)[1] / (high - low)[0])
    tall = rows * (height + 0.3) + 0.3
    with house_style(tall, rows, panels, sharex=True, sharey=True) as (figure, axes):
        for axis in axes.flat[len(models) :]:
            axis.set_visible(False)
        for axis, (name, model) in zip(axes.flat, models.items(), strict=False):
            axis.plot(*line.T, "o-", color="#999999", markersize=3)
            _draw_masses(axis, model)
            axis.set(title=name, aspect="equal", xlabel="y [m]")
            axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        for axis in axes[:, 0]:
            axis.set_ylabel("z [m]")
        links = [
            Patch(color=colour, label=f"link {k}")
            for k, colour in enumerate(JOINT_COLOURS[: len(joints) - 1], 1)
        ]
        figure.legend(handles=links, loc="outside lower center", frameon=False, ncols=6)
    return Drawing(figure, pd.concat([_masses(name, model) for name, model in models.items()]))


def _limits(line: Array, outlines: Sequence[Array]) -> tuple[Array, Array]:
    """Return lower and upper limits (2,) [m] of the axes, around joints and outlines (K, 2)."""
    drawn = np.concatenate([line, *outlines])
    # undetermined parameters can have any value, so the arm limits the axes
    low = np.maximum(drawn.min(axis=0), line.min(axis=0) - MAX_DISTANCE_FROM_JOINTS)
    high = np.minimum(drawn.max(axis=0), line.max(axis=0) + MAX_DISTANCE_FROM_JOINTS)
    return low - DRAWING_MARGIN, high + DRAWING_MARGIN


def _draw_masses(axis: Axes, model: MassModel) -> None:
    colours = JOINT_COLOURS[: len(model.masses)]
    for bodies, colour in zip(model.outlines, colours, strict=True):
        for body in bodies:
            axis.fill(*body.T, facecolor=f"{colour}40", edgecolor=colour, linewidth=0.8)
    y, z = SIDE_VIEW @ model.centers.T
    axis.scatter(y, z, 12 * model.masses, colours, zorder=3)


def _masses(name: str, model: MassModel) -> pd.DataFrame:
    numbers = np.column_stack([model.masses, model.centers.round(9)])
    values = pd.DataFrame(numbers, columns=["mass [kg]", *PLACE_COLUMNS])
    counts = {model.bodies: [*map(len, model.outlines)]}
    return values.assign(model=name, link=range(1, len(model.masses) + 1), **counts)


def frame_panels(
    rotation: Array, origin: Array, parameters: Sequence[DenavitHartenberg]
) -> Drawing:
    """Draw the frames of an arm and the Denavit-Hartenberg parameters between them: the whole arm,
    and its wrist enlarged.

    rotation: (n + 1, 3, 3), origin: (n + 1, 3) [m], of frames 0 to n in the base frame;
    parameters: empty for an arm without Denavit-Hartenberg parameters.
    """
    with house_style(4.4, 1, 2, width_ratios=[1, 1.6]) as (figure, ((whole, wrist),)):
        last = len(origin) - 1
        half = last // 2
        parts = (
            (whole, f"frames 0 to {half}", range(half + 1)),
            (wrist, f"frames {half} to {last}", range(half, last + 1)),
        )
        for axis, title, frames in parts:
            _draw_links(axis, origin, parameters, frames)
            _draw_frames(axis, rotation, origin, frames)
            axis.set(title=title, aspect="equal", xticks=[], yticks=[])
            axis.spines[:].set_visible(False)
    axes = [f"{axis} axis, {part}" for axis in "xyz" for part in "xyz"]
    turned = rotation.transpose(0, 2, 1).reshape(-1, 9)
    values = pd.DataFrame(
        np.column_stack([origin, turned]).round(9), columns=[*PLACE_COLUMNS, *axes]
    )
    links = pd.DataFrame(
        [[p.a, p.d, p.alpha] for p in parameters], range(1, len(parameters) + 1), PARAMETER_COLUMNS
    )
    return Drawing(figure, values.rename_axis("frame").join(links).reset_index())


def _draw_frames(axis: Axes, rotation: Array, origin: Array, frames: Sequence[int]) -> None:
    """Draw the axes of some frames, labelled to the left of their tips."""
    projected = origin[[*frames]] @ OBLIQUE_VIEW.T
    length = AXIS_LENGTH * np.ptp(projected, axis=0).max()
    low, high = projected.min(axis=0) - 1.5 * length, projected.max(axis=0) + 1.5 * length
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    for k in frames:
        for part, (name, colour) in enumerate(AXIS_COLOURS.items()):
            start, way = OBLIQUE_VIEW @ origin[k], OBLIQUE_VIEW @ rotation[k, :, part] * length
            arrow = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0}
            axis.annotate("", start + way, start, arrowprops=arrow)
            aside = LABEL_DISTANCE * np.array([-way[1], way[0]]) / np.hypot(*way)
            label = axis.annotate(f"${name}_{k}$", start + way, aside, textcoords="offset points")
            label.set(color=colour, ha="center", va="center")


def _draw_links(
    axis: Axes, origin: Array, parameters: Sequence[DenavitHartenberg], frames: Sequence[int]
) -> None:
    """Draw the links between some frames, each labelled with its nonzero parameters."""
    axis.plot(
        *(OBLIQUE_VIEW @ origin[[*frames]].T), "o-", color="#999999", markersize=4, linewidth=3
    )
    for k in frames[1:] if parameters else ():
        link = parameters[k - 1]
        lengths = {f"d_{k}": link.d, f"a_{k}": link.a}
        parts = [f"${name}$ = {1000 * value:g} mm" for name, value in lengths.items() if value]
        parts += [rf"$\alpha_{k}$ = {np.degrees(link.alpha):.4g}°"] if link.alpha else []
        start, end = OBLIQUE_VIEW @ origin[k - 1], OBLIQUE_VIEW @ origin[k]
        level = abs(end - start)[0] > abs(end - start)[1]
        aside, side = ((0, 24), "center") if level else ((20, 3), "left")
        middle = (start + end) / 2
        text = ", ".join(parts).replace("-", "−")
        label = axis.annotate(text, middle, aside, textcoords="offset points")
        label.set(ha=side, va="bottom")
