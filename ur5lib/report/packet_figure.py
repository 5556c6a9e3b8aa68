"""When the frames of a recording arrived, after Figure 4.4 of the thesis."""

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ur5lib.pipeline.records.signals import Signals
from ur5lib.report.house_style import HOUSE_STYLE, JOINTS, WIDTH, Drawing, nothing_to_draw
from ur5lib.timeseries.arrays import Array

LATE = 1.5  # periods: a longer step lacks frames
ENLARGED = (-0.15, 0.35)  # s, around the first late frame
RECEIVED, LOST, SPEED = JOINTS[0], JOINTS[1], "#666666"


def packet_figure(signals: Signals) -> Drawing:
    """Return the steps between received frames, the arm's speed, and where steps become longer.

    Empty for a recording that lacks no frame.
    """
    received = ~signals.interpolated
    time, steps = signals.time[received][1:], 1000 * np.diff(signals.time[received])
    late = np.flatnonzero(steps > LATE * 1000 * signals.period)
    if not len(late):
        return nothing_to_draw()
    lost = signals.time[signals.interpolated]
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = Figure(figsize=(WIDTH, 4.2), layout="constrained")
        above, middle, below = figure.subplots(3, 1, height_ratios=[2, 1, 2])
        above.sharex(middle)
        above.plot(time, steps, ".", color=RECEIVED, markersize=2.5, rasterized=True)
        _draw_speed(middle, signals)
        _enlarge(below, time, steps, lost, time[late[0]])
        for axis in (above, below):
            axis.set(ylabel="step [ms]", ylim=(-0.05 * steps.max(), 1.1 * steps.max()))
        for axis in (middle, below):
            axis.set_xlabel("time [s]")
        below.legend(loc="upper left", frameon=False, ncols=2)
    return Drawing(figure, pd.DataFrame({"time [s]": time, "step to this frame [ms]": steps}))


def _draw_speed(axis: Axes, signals: Signals) -> None:
    """Draw the speed of the fastest joint, where velocities were recorded."""
    if signals.actual_qd is not None:
        axis.plot(signals.time, np.abs(signals.actual_qd).max(axis=1), color=SPEED, linewidth=0.8)
    axis.set_ylabel("speed [rad/s]")


def _enlarge(axis: Axes, time: Array, steps: Array, lost: Array, at: float) -> None:
    """Draw received and lost frames one by one, around a time."""
    axis.plot(time, steps, "o-", color=RECEIVED, markersize=3, linewidth=0.6, label="received")
    axis.plot(lost, np.zeros_like(lost), "x", color=LOST, markersize=4, label="lost")
    axis.set_xlim(*(at + np.array(ENLARGED)))
