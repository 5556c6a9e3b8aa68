"""Figures of one recording, after the thesis's 5.1 to 5.4, 5.9 to 5.12, 5.14, 5.15, 6.4 to 6.9."""

from collections.abc import Mapping, Sequence

import numpy as np

from ur5lib.pipeline.estimators import NEW
from ur5lib.pipeline.records.accelerations import Accelerations
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import ClosedLoop, Torques
from ur5lib.report.house_style import Drawing, nothing_to_draw
from ur5lib.report.traces import (
    ACCELERATION,
    CURRENT,
    TORQUE,
    WRENCH,
    Traces,
    draw_traces,
    joint_quantity,
)
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import starts

Series = dict[str, tuple[Array, str]]  # values (N, M) and style, by label
DRAWN = ("third", "first", "second", "fourth", "fifth")  # of estimates; the first has the band
PUBLISHED_STYLES = {
    "Fu": ("controller's estimate", "first"),
    "F": ("without friction", "second"),
    "F*": ("with friction", "third"),
}
THROUGH_ANGLES = "Euler angles, Equation 2.33 as printed"
STATES = {  # symbol, unit
    "q": ("q", "rad"),
    "qd": (r"\dot{q}", "rad/s"),
}


def chosen_gains(robot: Robot) -> str:
    """Return the name of the gains that were published for the chosen model, or "estimated"."""
    return robot.chosen_model if robot.chosen_model in robot.closed_loop_gains else "estimated"


def tracking_figure(signals: Signals, closed_loop: ClosedLoop, gains: str, state: str) -> Drawing:
    """Return Figures 5.1 and 5.9 (state q) or 5.2 and 5.10 (qd): the closed loop under some gains.

    The measured motion, its target and the closed loop, and the errors of the latter two.
    """
    simulated = getattr(closed_loop, state).get(gains)
    if simulated is None:
        return nothing_to_draw()
    traces_by_label = {
        "measured": (getattr(signals, f"actual_{state}"), "measured"),
        "target": (getattr(signals, f"target_{state}"), "first"),
        f"closed loop, gains {gains}": (simulated, "second"),
    }
    series = {
        label: (with_breaks(values, signals.segment), style)
        for label, (values, style) in traces_by_label.items()
    }
    traces = Traces(
        with_breaks(signals.time, signals.segment),
        series,
        errors(series, series["measured"][0]),
    )
    return draw_traces(traces, joint_quantity(*STATES[state]))


def torque_figure(signals: Signals, torques: Torques, model: str) -> Drawing:
    """Return Figures 5.11 and 5.12: the chosen model against the controller's torque."""
    motion = "target" if model in torques.target else "measured"
    modelled = with_breaks(getattr(torques, motion)[model], signals.segment)
    series: Series = {f"Model {model}, {motion} motion": (modelled, "joint")}
    reference = None
    if signals.target_moment is not None:
        reference = with_breaks(signals.target_moment, signals.segment)
        series = {"controller's target_moment": (reference, "measured")} | series
    time = with_breaks(signals.time, signals.segment)
    return draw_traces(Traces(time, series, errors(series, reference)), TORQUE)


def older_torque_figure(
    signals: Signals, modelled: Mapping[str, Array], printed: Sequence[float]
) -> Drawing:
    """Return Figures 5.3 and 5.4 without the older model's torque, whose equations are not printed.

    modelled: torques (N, 6) [Nm] by label; printed: the older model's mean absolute error (6,).
    """
    if signals.target_moment is None or not modelled:
        return nothing_to_draw()
    reference = with_breaks(signals.target_moment, signals.segment)
    series: Series = {"controller's target_moment": (reference, "measured")}
    for (label, values), style in zip(modelled.items(), DRAWN, strict=False):
        series[label] = with_breaks(values, signals.segment), style
    time = with_breaks(signals.time, signals.segment)
    level = np.where(np.isnan(time), np.nan, 1.0)[:, None] * np.array(printed)
    mean = {"[21], printed mean": (level, "second")}
    return draw_traces(Traces(time, series, (errors(series, reference) or {}) | mean), TORQUE)


def current_figure(signals: Signals, currents: Currents) -> Drawing:
    """Return the measured current and that predicted for motion without contact."""
    series: Series = {}
    measured = None
    if signals.actual_current is not None:
        measured = with_breaks(signals.actual_current, signals.segment)
        series = {"actual_current": (measured, "measured")}
    if currents.predicted_current is not None:
        predicted = with_breaks(currents.predicted_current, signals.segment)
        series["predicted without contact"] = (predicted, "joint")
    time = with_breaks(signals.time, signals.segment)
    return draw_traces(Traces(time, series, errors(series, measured)), CURRENT)


def acceleration_figure(accelerations: Accelerations) -> Drawing:
    """Return Figures 5.14 and 5.15 by the calibrated IMU and the joints."""
    estimates = {"from the joints": (accelerations.acceleration.get("encoders"), "first")}
    return _imu_figure(accelerations, accelerations.felt, estimates)


def published_acceleration_figure(accelerations: Accelerations) -> Drawing:
    """Return Figures 5.14 and 5.15 as published."""
    estimates = {THROUGH_ANGLES: (accelerations.published.get("euler"), "second")}
    return _imu_figure(accelerations, accelerations.published_felt, estimates)


def filtered_first_figure(signals: Signals, modelled: Array, felt: Array) -> Drawing:
    """Return Figures 5.14 and 5.15 with an IMU that was filtered before it was rotated.

    modelled, felt: acceleration through Euler angles and of the IMU, (N, 6) [m/s², rad/s²].
    """
    table = Accelerations(time=signals.time, segment=signals.segment)
    return _imu_figure(table, felt, {THROUGH_ANGLES: (modelled, "second")})


def _imu_figure(
    table: Accelerations, felt: Array | None, estimates: dict[str, tuple[Array | None, str]]
) -> Drawing:
    traces = {"IMU": (felt, "measured")} | estimates
    series: Series = {
        label: (with_breaks(values, table.segment), style)
        for label, (values, style) in traces.items()
        if values is not None
    }
    reference = series["IMU"][0] if series else None
    time = with_breaks(table.time, table.segment)
    return draw_traces(Traces(time, series, errors(series, reference)), ACCELERATION)


def published_force_figure(
    published: PublishedForces, sensor: SensorWrenches, kind: str, estimates: tuple[str, ...]
) -> Drawing:
    """Return Figures 6.4 to 6.9 of some estimates, as printed or corrected: values and errors."""
    measured = _wrench(sensor, sensor.wrench.get(kind))
    series: Series = {} if measured is None else {"force sensor": (measured, "measured")}
    for estimate in estimates:
        values = getattr(published, kind).get(estimate)
        if values is not None:
            label, style = PUBLISHED_STYLES[estimate]
            series[label] = with_breaks(values, published.segment), style
    time = with_breaks(sensor.time, sensor.segment)
    return draw_traces(Traces(time, series, errors(series, measured)), WRENCH)


def estimate_figure(forces: Forces, sensor: SensorWrenches, hidden: Mask) -> Drawing:
    """Return the new estimates, the band of the first, and the sensor; hidden: see Traces."""
    measured = _wrench(sensor, sensor.wrench.get("compensated"))
    series: Series = {} if measured is None else {"force sensor": (measured, "measured")}
    labels = {name: label for name, label in NEW.items() if name in forces.wrench}
    for (name, label), style in zip(labels.items(), DRAWN, strict=False):
        series[label] = with_breaks(forces.wrench[name], forces.segment), style
    band = None
    if lead := next(iter(labels), None):
        whole, half = forces.wrench[lead], NORMAL95 * forces.std[lead]
        low, high = (with_breaks(whole + sign * half, forces.segment) for sign in (-1, 1))
        band = low, high
    time, dark = (with_breaks(values, forces.segment) for values in (forces.time, hidden))
    traces = Traces(time, series, errors(series, measured), band, dark > 0)
    return draw_traces(traces, WRENCH)


def _wrench(sensor: SensorWrenches, values: Array | None) -> Array | None:
    return None if values is None else with_breaks(values, sensor.segment)


def errors(series: Series, reference: Array | None) -> Series | None:
    """Return the errors of all other series against the reference."""
    if reference is None or len(series) < 2:
        return None
    return {
        label: (reference - values, style)
        for label, (values, style) in series.items()
        if values is not reference
    }


def with_breaks(values: Array | Mask, segment: Labels) -> Array:
    """Return values with NaN between segments, so that no line is drawn across a gap."""
    breaks = np.flatnonzero(starts(segment)[1:]) + 1
    if not len(breaks):
        return np.asarray(values, dtype=float)
    return np.insert(np.asarray(values, dtype=float), breaks, np.nan, axis=0)
