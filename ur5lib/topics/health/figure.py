"""The figure of an arm's health by date."""

from collections.abc import Iterable
from datetime import date
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num
from matplotlib.ticker import MaxNLocator

from ur5lib.channels import CURRENT, Effort
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
FIGURE_HEIGHT = 7.4  # inches; it fits six rows of panels
MOST_TICKS = 3  # steps between the values of a panel
ROUND_STEPS = (1, 2, 5, 10)  # which need few digits
DRIFT_STYLE: Any = SHADE_STYLE | {"alpha": 0.06}  # a drift, which lasts all the time


def health_figure(dates: pd.DataFrame, changes: pd.DataFrame, effort: Effort = CURRENT) -> Drawing:
    """Draw the health of an arm by date: a row of panels per quantity, a column per joint.

    dates, changes: health.csv, health_changes.csv; effort: the measured one.
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
    drawn = changes[changes["quantity"].isin(quantities)]
    marked = drawn[["last", "joint", "quantity", "size"]].set_axis(
        ["date", "joint", "quantity", "change"], axis="columns"
    )
    return Drawing(figure, pd.concat([rows, marked], ignore_index=True) if len(drawn) else rows)


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
    axis.yaxis.set_major_locator(MaxNLocator(MOST_TICKS, steps=ROUND_STEPS))


def _place(day: str) -> float:
    """Return the position of a date on the axis of time."""
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
        axis.set_title(f"joint {joint}", loc="left", fontsize="medium")
    for axis in bottom:
        locator = AutoDateLocator(minticks=2, maxticks=3)
        axis.xaxis.set_major_locator(locator)
        axis.xaxis.set_major_formatter(ConciseDateFormatter(locator))
        axis.tick_params(axis="x", rotation=90)
