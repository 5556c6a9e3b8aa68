"""Figures of one recording, after the thesis's 4.4, 5.1 to 5.4, 5.9 to 5.15 and 6.4 to 6.9."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from ur5lib.channels import CURRENT, Effort
from ur5lib.force.estimators import ESTIMATES, UNGATED
from ur5lib.records.accelerations import Accelerations
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.signals import ACCELERATION_CUTOFF, Signals, slowly
from ur5lib.report.figures.house_style import JOINT_COLOURS, Drawing, house_style, nothing_to_draw
from ur5lib.report.figures.panels import Panel
from ur5lib.report.figures.traces import (
    ACCELERATION_PANELS,
    CURRENT_PANELS,
    FORCE_PANELS,
    MOMENT_PANELS,
    TORQUE_PANELS,
    UNFILTERED,
    Traces,
    draw_traces,
)
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import starts, without_ends

OptionalLines = Mapping[
    str, tuple[Array | None, str]
]  # values (N, 6), None without any, and style, by label
StyledLines = dict[str, tuple[Array, str]]
TimedTable = Signals | Accelerations | Forces | SensorWrenches
MAY_HIDE = "a contact that may be hidden"
ESTIMATE_STYLES = (
    "leading",
    "first",
    "second",
    "fourth",
    "fifth",
)  # estimates; the band is that of the first
LATE_STEP_PERIODS = 1.5  # periods; in a longer step, frames were lost
ENLARGED_SPAN = (-0.15, 0.35)  # s; about the first late frame
RECEIVED_COLOUR, LOST_COLOUR, SPEED_COLOUR = JOINT_COLOURS[0], JOINT_COLOURS[1], "#666666"


def torque_figure(signals: Signals, torques: Torques, robot: Robot) -> Drawing:
    """Draw Figures 5.11 and 5.12: the torques of the arm's chosen link model, of this model with
    rotors, and of the most complete one (`fullest_model`) against the controller's torque,
    low-passed as in the table of errors.
    """
    if signals.target_moment is None:
        return nothing_to_draw()
    moment = slowly(signals.target_moment, signals)
    lines: dict[str, tuple[Array | None, str]] = {
        f"target_moment below {ACCELERATION_CUTOFF:g} Hz": (moment, "measured")
    }
    chosen = robot.chosen_model
    models = dict.fromkeys((chosen, f"{chosen}+rotors", robot.fullest_model()))
    known = [model for model in models if model in torques.measured]
    for model, style in zip(known, ("first", "second", "third"), strict=False):
        motion = "target" if model in torques.target else "measured"
        torque = slowly(getattr(torques, motion)[model], signals)
        lines[f"Model {model} at the {motion} motion"] = torque, style
    return draw_lines(signals, lines, TORQUE_PANELS, unfiltered=signals.target_moment)


def effort_figure(
    signals: Signals, currents: Currents, effort: Effort, lowpass: tuple[int, float]
) -> Drawing:
    """Draw the measured effort, and the one predicted for motion without contact with its band,
    low-passed as in the table of errors.
    """
    name, panels = effort.channel, CURRENT_PANELS if effort == CURRENT else TORQUE_PANELS
    measured, predicted = signals.effort, currents.predicted
    lines: OptionalLines = {f"{name}, unfiltered": (measured, "pale")}
    if measured is None or predicted is None:
        return draw_lines(signals, lines, panels)
    known = np.isfinite(measured + predicted).all(axis=1, keepdims=True)

    def smooth(values: Array) -> Array:
        slow = slowly(np.where(known, values, np.nan), signals, lowpass)
        return without_ends(slow, signals.segment, signals.period, lowpass[1])

    slow, half = smooth(predicted), currents.band
    lines = {
        f"{name} below {lowpass[1]:g} Hz": (smooth(measured), "measured"),
        "prediction without contact": (slow, "joint"),
    }
    band = None if half is None else (slow - half, slow + half)
    return draw_lines(signals, lines, panels, band=band, unfiltered=measured)


def acceleration_figure(accelerations: Accelerations) -> Drawing:
    """Draw Figures 5.14 and 5.15: accelerations by the calibrated IMU and by the joints."""
    lines: OptionalLines = {
        "IMU": (accelerations.felt, "measured"),
        "from the joints": (accelerations.acceleration.get("encoders"), "first"),
    }
    return draw_lines(accelerations, lines, ACCELERATION_PANELS)


def estimate_figure(
    forces: Forces,
    sensor: SensorWrenches,
    hidden: Mask,
    moments: bool = False,
) -> Drawing:
    """Draw the new estimates of a contact wrench, the band of the first, and the sensor; hidden:
    see Traces.

    Where no contact is found, the band is that if nothing has touched since the arm came to rest,
    and a thin line shows up to which force a contact could be hidden.
    moments: draw moments in place of forces and their magnitude. With a sensor, plain least squares
    in place of the gated estimate, for comparison with the others.
    """
    part, panels = (_moments, MOMENT_PANELS) if moments else (_forces, FORCE_PANELS)
    wrenches = dict(forces.wrench)
    if sensor.plain is not None and wrenches.pop("least_squares", None) is not None:
        wrenches[UNGATED] = sensor.plain
    labels = {name: label for name, label in ESTIMATES.items() if name in wrenches}
    lines: dict[str, tuple[Array | None, str]] = {
        "force sensor": (sensor.wrench.get("compensated"), "measured")
    }
    for (name, label), style in zip(labels.items(), ESTIMATE_STYLES, strict=False):
        lines[label] = wrenches[name], style
    band = None
    if (lead := next(iter(labels), None)) in forces.std:
        whole, half = forces.wrench[lead], NORMAL95 * forces.std[lead]
        if forces.untouched is not None:
            half = np.hstack([forces.untouched, half[:, 3:]])
        band = part(whole - half), part(whole + half)
        for edge in band:
            edge[:, 3:] = np.nan  # the magnitude has no such band
    shown = {
        label: (part(own) if own is not None else None, how) for label, (own, how) in lines.items()
    }
    if forces.hidden is not None and not moments:
        most = np.where(forces.hidden > 0, forces.hidden, np.nan)
        shown[MAY_HIDE] = np.column_stack([most, np.full(len(most), np.nan)]), "pale"
    return draw_lines(forces, shown, panels, band=band, hidden=hidden, errors=False)


def _forces(wrench: Array) -> Array:
    """Return the force and its magnitude (N, 4) of a wrench (N, 6)."""
    return np.column_stack([wrench[:, :3], np.linalg.norm(wrench[:, :3], axis=1)])


def _moments(wrench: Array) -> Array:
    """Return the moment (N, 3) of a wrench (N, 6)."""
    return wrench[:, 3:]


def draw_lines(
    table: TimedTable,
    lines: OptionalLines,
    panels: Sequence[Panel],
    further: OptionalLines | None = None,
    band: tuple[Array, Array] | None = None,
    hidden: Mask | None = None,
    unfiltered: Array | None = None,
    errors: bool = True,
) -> Drawing:
    """Draw lines over a table's time, without those that have no values, and the errors of the
    others against the first.

    Without values of the first line, no errors are drawn. further: lines of which only the errors
    are drawn; band, hidden: see Traces; unfiltered: the first line as recorded (N, n), drawn pale
    behind all; errors: whether to draw errors.
    """
    first = next(iter(lines))
    series = _broken(lines, table.segment)
    against: StyledLines = {}
    if errors and first in series:
        measured, _ = series[first]
        others = ((label, line) for label, line in series.items() if label != first)
        against = {label: (measured - values, style) for label, (values, style) in others}
    behind = _broken({UNFILTERED: (unfiltered, "pale")}, table.segment)
    traces = Traces(
        time=with_breaks(table.time, table.segment),
        series=behind | series,
        errors=against | _broken(further or {}, table.segment),
        band=band and (with_breaks(band[0], table.segment), with_breaks(band[1], table.segment)),
        hidden=None if hidden is None else with_breaks(hidden, table.segment) > 0,
    )
    return draw_traces(traces, panels)


def _broken(lines: OptionalLines, segment: Labels) -> StyledLines:
    return {
        label: (with_breaks(values, segment), style)
        for label, (values, style) in lines.items()
        if values is not None
    }


def with_breaks(values: Array | Mask, segment: Labels) -> Array:
    """Return values with NaN between segments, so that no line is drawn across a gap."""
    breaks = np.flatnonzero(starts(segment)[1:]) + 1
    if not len(breaks):
        return np.asarray(values, dtype=float)
    return np.insert(np.asarray(values, dtype=float), breaks, np.nan, axis=0)


def packet_figure(signals: Signals) -> Drawing:
    """Draw Figure 4.4: steps between received frames, the arm's speed, the first late frames.

    Empty for a recording without lost frames.
    """
    received = ~signals.interpolated
    time, steps = signals.time[received][1:], 1000 * np.diff(signals.time[received])
    late = np.flatnonzero(steps > LATE_STEP_PERIODS * 1000 * signals.period)
    if not len(late):
        return nothing_to_draw()
    lost = signals.time[signals.interpolated]
    with house_style(4.2, 3, height_ratios=[2, 1, 2]) as (figure, panels):
        above, middle, below = panels[:, 0]
        above.sharex(middle)
        above.plot(time, steps, ".", color=RECEIVED_COLOUR, markersize=2.5, rasterized=True)
        velocity = signals.actual_qd
        if velocity is None:
            velocity = np.gradient(signals.actual_q, signals.time, axis=0)
        fastest = np.abs(velocity).max(axis=1)
        middle.plot(signals.time, fastest, color=SPEED_COLOUR, linewidth=0.8)
        middle.set_ylabel("speed [rad/s]")
        _enlarge(below, time, steps, lost, time[late[0]])
        for axis in (above, below):
            axis.set(ylabel="step [ms]", ylim=(-0.05 * steps.max(), 1.1 * steps.max()))
        for axis in (middle, below):
            axis.set_xlabel("time [s]")
        below.legend(loc="upper left", frameon=False, ncols=2)
    return Drawing(figure, pd.DataFrame({"time [s]": time, "step to this frame [ms]": steps}))


def _enlarge(axis: Axes, time: Array, steps: Array, lost: Array, at: float) -> None:
    """Draw received and lost frames one by one, around a time."""
    axis.plot(
        time, steps, "o-", color=RECEIVED_COLOUR, markersize=3, linewidth=0.6, label="received"
    )
    axis.plot(lost, np.zeros_like(lost), "x", color=LOST_COLOUR, markersize=4, label="lost")
    axis.set_xlim(*(at + np.array(ENLARGED_SPAN)))
