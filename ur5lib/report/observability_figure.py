"""The figure of an arm's observability: pushes by speed of the flange, friction by joint speed."""

from collections.abc import Sequence
from typing import Any

import matplotlib
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from ur5lib.report.cells import flange_speeds
from ur5lib.report.house_style import HOUSE_STYLE, JOINTS, WIDTH, Drawing, nothing_to_draw
from ur5lib.timeseries.metrics import NORMAL95

MARKS = ("o", "s", "^", "v", "D", "P")
SLOWEST = 0.003  # rad/s, where the axis begins


def observability_figure(
    pushes: Sequence[Any], shares: Sequence[Any], wanted: float, most: float
) -> Drawing:
    """Draw smallest pushes with their 95 % intervals, and shares within the band; rows of
    observability.json. wanted: share that suffices; most: largest push that was tried [N].
    """
    felt, held = pd.DataFrame(pushes), pd.DataFrame(shares)
    if felt.empty and held.empty:
        return nothing_to_draw()
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
        left, right = figure.subplots(1, 2)
        _pushes(left, felt, most)
        _shares(right, held, wanted)
    parts = [felt.assign(quantity="smallest_push_95"), held.assign(quantity="friction_in_band")]
    return Drawing(figure, pd.concat([part for part in parts if len(part)], ignore_index=True))


def _pushes(axis: Axes, rows: pd.DataFrame, most: float) -> None:
    """Draw the push that is detected in each range of speeds; an arrow where it is beyond."""
    for place, row in enumerate(rows.itertuples()):
        if row.force > most:
            axis.annotate(
                "", (place, 1.1 * most), (place, 0.95 * most), arrowprops={"arrowstyle": "->"}
            )
            axis.text(place, 0.94 * most, f"> {most:.0f}", ha="center", va="top")
        else:
            half = NORMAL95 * row.std
            axis.errorbar(place, row.force, half, fmt="o", markersize=4, color=JOINTS[0])
    speeds = [flange_speeds(row.speed_low, row.speed_high) for row in rows.itertuples()]
    axis.set_xticks(range(len(rows)), speeds)
    axis.set(xlabel="speed of the flange [m/s]", ylabel="smallest push [N]")
    axis.set(xlim=(-0.5, len(rows) - 0.5), ylim=(0, 1.12 * most))


def _shares(axis: Axes, rows: pd.DataFrame, wanted: float) -> None:
    """Draw each joint's share within the band over its speed, and the share that suffices."""
    axis.axhline(100 * wanted, color="black", linewidth=0.8)
    for joint, part in rows.groupby("joint"):
        estimated = part.dropna(subset="share")
        middle = (estimated["speed_low"].clip(lower=SLOWEST) * _end(estimated)) ** 0.5
        colour, mark = JOINTS[int(joint) - 1], MARKS[int(joint) - 1]
        style: Any = {"color": colour, "marker": mark, "markersize": 3, "linewidth": 0.9}
        axis.plot(middle, 100 * estimated["share"], label=f"joint {joint}", **style)
    axis.set(xscale="log", xlabel="speed of the joint [rad/s]", ylim=(0, 102))
    axis.set_ylabel("within the 95 % band [%]")
    axis.xaxis.set_major_formatter(FuncFormatter(lambda speed, _: f"{speed:g}"))
    axis.legend(loc="lower right", frameon=False, fontsize=6.5)


def _end(rows: pd.DataFrame) -> pd.Series:
    """Return the upper end of each range; an open one is drawn up to twice its lower end."""
    return rows["speed_high"].astype(float).fillna(2 * rows["speed_low"])
