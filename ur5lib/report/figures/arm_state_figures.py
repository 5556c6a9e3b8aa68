"""Figures of an arm's state: its health by date, and what can be observed on it by speed."""

from collections.abc import Iterable
from datetime import date
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num
from matplotlib.ticker import FuncFormatter, MaxNLocator

from ur5lib.channels import CURRENT, Effort
from ur5lib.records.contacts import SPEEDS
from ur5lib.report.figures.house_style import (
    JOINT_COLOURS,
    SHADE_STYLE,
    Drawing,
    house_style,
    nothing_to_draw,
)
from ur5lib.timeseries.metrics import NORMAL95

PANEL_LABELS = {
    "coulomb": "Coulomb friction [Nm]",
    "viscous": "viscous friction [Nm s/rad]",
    "torque_constant": "torque constant [Nm/A]",
    "gain": "gain [Nm/Nm]",
    "offset": "offset [Nm]",
    "noise": "noise",
    "temperature": "temperature [°C]",
}
FIGURE_HEIGHT = 7.4  # inches, of six rows of panels
JOINT_MARKERS = ("o", "s", "^", "v", "D", "P", "X", "*")
MOST_TICKS = 4  # of the values of a panel
AXIS_STEP = 0.22  # of the step between speeds, from axis to axis
MIN_DRAWN_SPEED = 0.003  # rad/s, where the axis of speeds begins
DRIFT_STYLE: Any = SHADE_STYLE | {"alpha": 0.06}  # a drift, which lasts all the time


def health_figure(dates: pd.DataFrame, changes: pd.DataFrame, effort: Effort = CURRENT) -> Drawing:
    """Draw a row of panels per quantity, a column per joint.

    dates, changes: health.csv, health_changes.csv; effort: that is measured.
    """
    labels = PANEL_LABELS | {"noise": f"noise [{effort.unit}]"}
    rows = _with_temperatures(dates)
    if rows.empty:
        return nothing_to_draw()
    quantities = [name for name in PANEL_LABELS if name in {*rows["quantity"]}]
    size = FIGURE_HEIGHT / 6 * len(quantities), len(quantities), int(rows["joint"].max())
    with house_style(*size, sharex=True) as (figure, panels):
        for row, quantity in zip(panels, quantities, strict=True):
            for joint, axis in enumerate(row, start=1):
                _panel(axis, rows[(rows["quantity"] == quantity) & (rows["joint"] == joint)])
                of_panel = (changes["quantity"] == quantity) & (changes["joint"] == joint)
                for change in changes[of_panel].itertuples():
                    _mark(axis, change)
            row[0].set_ylabel(labels[quantity].replace(" [", "\n["))
        _label(panels[0], panels[-1])
    return Drawing(figure, rows)


def _with_temperatures(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of joints, with those of their temperatures, where recorded."""
    joints = rows.dropna(subset="joint").astype({"joint": int})
    if joints.empty:
        return joints
    warmth = joints.drop_duplicates(["date", "joint"]).dropna(subset="temperature_c")
    warmth = warmth.assign(value=warmth["temperature_c"], std_error=np.nan, quantity="temperature")
    columns = ["date", "joint", "quantity", "value", "std_error"]
    return pd.concat([part[columns] for part in (joints, warmth) if len(part)], ignore_index=True)


def _panel(axis: Axes, rows: pd.DataFrame) -> None:
    """Draw the values of a joint with their 95 % intervals."""
    days = [_place(day) for day in rows["date"]]
    colour = JOINT_COLOURS[int(rows["joint"].iloc[0]) - 1] if len(rows) else "none"
    half = NORMAL95 * rows["std_error"].fillna(0.0)
    axis.errorbar(
        days, rows["value"], half, fmt="o", markersize=2, linewidth=0.7, color=colour, zorder=3
    )
    axis.yaxis.set_major_locator(MaxNLocator(MOST_TICKS))


def _place(day: str) -> float:
    """Return the place of a date on an axis."""
    return float(date2num(date.fromisoformat(day)))


def _mark(axis: Axes, change: Any) -> None:
    """Draw a change: the time of a jump shaded, its size in words."""
    style = SHADE_STYLE if change.kind == "jump" else DRIFT_STYLE
    axis.axvspan(_place(change.first), _place(change.last), **style)
    size = change.size / change.before
    text = f"{100 * size:+.0f} %" if change.quantity != "offset" else f"{change.size:+.2g}"
    rises = change.size > 0  # then the corner above the first dates is free
    place: Any = {"x": 0.05 if rises else 0.95, "ha": "left" if rises else "right"}
    axis.text(y=0.97, s=text.replace("-", "−"), va="top", transform=axis.transAxes, **place)


def _label(top: Iterable[Axes], bottom: Iterable[Axes]) -> None:
    """Name the joints above, and the dates below."""
    for joint, axis in enumerate(top, start=1):
        axis.set_title(f"joint {joint}", loc="left", pad=2)
    for axis in bottom:
        locator = AutoDateLocator(minticks=2, maxticks=3)
        axis.xaxis.set_major_locator(locator)
        axis.xaxis.set_major_formatter(ConciseDateFormatter(locator))
        axis.tick_params(axis="x", rotation=90)


def observability_figure(rows: pd.DataFrame, wanted: float, most: float) -> Drawing:
    """Draw smallest pushes with their 95 % intervals, and shares within the band.

    rows: observability.csv; wanted: share that suffices; most: largest push that was tried [N].
    """
    pushes = rows[rows["quantity"].str.startswith("smallest_push_95_")]
    shares = rows[rows["quantity"] == "friction_in_band"]
    if pushes.empty and shares.empty:
        return nothing_to_draw()
    with house_style(2.9, 1, 2) as (figure, ((left, right),)):
        _pushes(left, pushes, most)
        _shares(right, shares, wanted)
    return Drawing(figure, pd.concat([pushes, shares], ignore_index=True))


def _pushes(axis: Axes, rows: pd.DataFrame, most: float) -> None:
    """Draw the push along x, y and z in each range of speeds; an arrow where it is beyond."""
    speeds = [*rows["speed_low"].unique()]
    for row in rows.itertuples():
        along = "xyz".index(row.quantity[-1])
        place, style = speeds.index(row.speed_low) + AXIS_STEP * (along - 1), JOINT_COLOURS[along]
        if row.bound == ">":
            arrow = {"arrowstyle": "->", "color": style}
            axis.annotate("", (place, 1.1 * most), (place, 0.95 * most), arrowprops=arrow)
        else:
            half, mark = NORMAL95 * row.std_error, JOINT_MARKERS[along]
            axis.errorbar(place, row.value, half, fmt=mark, markersize=4, color=style)
        axis.text(place, 0.02 * most, row.quantity[-1], ha="center", color=style)
    words = [f"{SPEEDS[low]}\n≥ {low:g}" for low in speeds]
    axis.set_xticks(range(len(speeds)), words)
    axis.set(xlabel="speed of the flange [m/s]", ylabel="minimum detectable force [N]")
    axis.set(xlim=(-0.5, len(speeds) - 0.5), ylim=(0, 1.12 * most))


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
    axis.set_ylabel("within the band of motion [%]")
    axis.xaxis.set_major_formatter(FuncFormatter(lambda speed, _: f"{speed:g}"))
    axis.figure.legend(loc="outside upper center", frameon=False, ncols=8)
