"""The figure of what can be observed on an arm, by speed."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from ur5lib.records.contacts import SPEEDS
from ur5lib.report.figures.house_style import (
    JOINT_COLOURS,
    Drawing,
    house_style,
    nothing_to_draw,
)
from ur5lib.timeseries.metrics import NORMAL95

AXIS_COLOUR = "#222222"  # of x, y and z, which are no joints
JOINT_MARKERS = ("o", "s", "^", "v", "D", "P", "X", "*")
AXIS_STEP = 0.22  # of the step between speeds, from axis to axis
MIN_DRAWN_SPEED = 0.003  # rad/s, where the axis of speeds begins


def observability_figure(rows: pd.DataFrame, wanted: float, pushes: pd.DataFrame) -> Drawing:
    """Draw smallest pushes with their 95 % intervals, and shares within the band.

    rows: observability.csv; wanted: share that suffices; pushes: pushes.csv, of which those are
    drawn that are determined or beyond the trials.
    """
    pushes = pushes[pushes["value"].notna() | (pushes["bound"] == ">")]
    shares = rows[rows["quantity"] == "friction_in_band"]
    if pushes.empty and shares.empty:
        return nothing_to_draw()
    with house_style(2.9, 1, 1 + (len(pushes) > 0)) as (figure, ((*left, right),)):
        for axis in left:
            _pushes(axis, pushes)
        _shares(right, shares, wanted)
    if not (pushes["bound"] == ">").any():
        pushes = pushes.drop(columns="bound")  # the caption names the columns' marks
    drawn = [part for part in (pushes, shares) if len(part)]
    return Drawing(figure, pd.concat(drawn, ignore_index=True))


def _pushes(axis: Axes, rows: pd.DataFrame) -> None:
    """Draw the push along x, y and z in each motion; an arrow where it is beyond the trials."""
    speeds = {motion: speed for speed, motion in SPEEDS.items()}
    motions, most = [*rows["motion"].unique()], rows["largest_tried"].max()
    for row in rows.itertuples():
        along = "xyz".index(row.axis)
        place = motions.index(row.motion) + AXIS_STEP * (along - 1)
        if row.bound == ">":
            arrow = {"arrowstyle": "->", "color": AXIS_COLOUR}
            axis.annotate("", (place, 1.1 * most), (place, 0.95 * most), arrowprops=arrow)
        else:
            half, mark = NORMAL95 * row.std_error, JOINT_MARKERS[along]
            axis.errorbar(place, row.value, half, fmt=mark, markersize=4, color=AXIS_COLOUR)
        axis.text(place, 0.02 * most, row.axis, ha="center")
    words = [f"{motion}\n≥ {speeds[motion]:g}" for motion in motions]
    axis.set_xticks(range(len(motions)), words)
    axis.set(xlabel="speed of the flange [m/s]", ylabel="minimum detectable force [N]")
    axis.set(xlim=(-0.5, len(motions) - 0.5), ylim=(0, 1.12 * most))


def _shares(axis: Axes, rows: pd.DataFrame, wanted: float) -> None:
    """Draw each joint's share within the band over its speed, and the share that suffices."""
    axis.axhline(100 * wanted, color="black", linewidth=0.8)
    for joint, part in rows.groupby("joint"):
        estimated = part.dropna(subset="value")
        low, high = estimated["speed_low"], estimated["speed_high"].astype(float)
        high = high.fillna(2 * low)  # an open range is drawn up to twice its lower end
        middle = (low.clip(lower=MIN_DRAWN_SPEED) * high) ** 0.5
        colour, mark = JOINT_COLOURS[int(joint) - 1], JOINT_MARKERS[int(joint) - 1]
        style: Any = {"color": colour, "marker": mark, "markersize": 3, "linewidth": 0.9}
        axis.plot(middle, 100 * estimated["value"], label=f"joint {joint:.0f}", **style)
    axis.set(xscale="log", xlabel="speed of the joint [rad/s]", ylim=(0, 102))
    axis.set_ylabel("within the 95 % band [%]")
    axis.xaxis.set_major_formatter(FuncFormatter(lambda speed, _: f"{speed:g}"))
    axis.figure.legend(loc="outside upper right", frameon=False, ncols=8)
