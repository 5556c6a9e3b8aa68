"""Figures of one recording, after the thesis's 5.9 to 5.12, 5.14, 5.15 and 6.4 to 6.9."""

from typing import Any

import numpy as np
import pandas as pd

from ur5lib.report.estimates import NEW
from ur5lib.report.house_style import save
from ur5lib.report.traces import (
    ACCELERATION,
    CURRENT,
    TORQUE,
    WRENCH,
    Series,
    Traces,
    draw_traces,
    joint_quantity,
)
from ur5lib.robots.description import Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import WRENCH as COMPONENTS
from ur5lib.tables import channel, labelled_channel, read_table

BAND = 1.96  # standard deviations that hold 95 %
DRAWN = ("third", "first", "second", "fourth")  # styles of estimates; the first has the band's
PUBLISHED = {
    "Fu": ("controller's estimate", "first"),
    "F": ("without friction", "second"),
    "F*": ("with friction", "third"),
}


def draw_figures(input: Any, output: Any, params: Any) -> None:
    signals, robot = read_table(input.signals), load_robot(input.arm)
    draw_closed_loop(signals, read_table(input.closed_loop), robot, output)
    draw_torques(signals, read_table(input.torques), robot.chosen_model, output)
    draw_accelerations(read_table(input.accelerations), output)
    sensor, kinematics = read_table(input.sensor), read_table(input.kinematics)
    draw_published(read_table(input.published), sensor, output)
    hidden = kinematics["sigma_min"].to_numpy() < params.min_singular_value
    draw_estimates(read_table(input.forces), sensor, hidden, output)
    draw_currents(signals, read_table(input.currents), output)


def draw_closed_loop(
    signals: pd.DataFrame, closed_loop: pd.DataFrame, robot: Robot, output: Any
) -> None:
    """Figures 5.9 and 5.10: what the loop misses, and what the targets themselves miss."""
    time = unbroken(signals, signals["time"].to_numpy())
    gains = robot.chosen_model if robot.chosen_model in robot.closed_loop_gains else "estimated"
    for state, symbol, unit, path in (
        ("q", r"\Delta q", "rad", output.positions),
        ("qd", r"\Delta \dot{q}", "rad/s", output.velocities),
    ):
        series = {}
        if f"{state}_{gains}_0" in closed_loop:
            measured = channel(signals, f"actual_{state}")
            looped = measured - channel(closed_loop, f"{state}_{gains}")
            told = measured - channel(signals, f"target_{state}")
            series = {
                "measured − target": (unbroken(signals, told), "measured"),
                f"measured − closed loop, gains {gains}": (unbroken(signals, looped), "joint"),
            }
        save(draw_traces(Traces(time, series), joint_quantity(symbol, unit)), path)


def draw_torques(signals: pd.DataFrame, torques: pd.DataFrame, model: str, output: Any) -> None:
    """Figures 5.11 and 5.12: the chosen model against the controller's."""
    time = unbroken(signals, signals["time"].to_numpy())
    motion = "target" if f"tau_target_{model}_0" in torques else "measured"
    modelled = unbroken(signals, channel(torques, f"tau_{motion}_{model}"))
    name = f"Model {model}, {motion} motion"
    series, reference = {name: (modelled, "joint")}, None
    if "target_moment_0" in signals:
        reference = unbroken(signals, channel(signals, "target_moment"))
        series = {"controller's target_moment": (reference, "measured")} | series
    save(draw_traces(Traces(time, series, errors(series, reference)), TORQUE), output.torques)


def draw_currents(signals: pd.DataFrame, currents: pd.DataFrame, output: Any) -> None:
    """Measured current and the current that motion without contact needs."""
    time = unbroken(signals, signals["time"].to_numpy())
    series, measured = {}, None
    if "actual_current_0" in signals:
        measured = unbroken(signals, channel(signals, "actual_current"))
        series = {"actual_current": (measured, "measured")}
    if "predicted_current_0" in currents:
        predicted = unbroken(currents, channel(currents, "predicted_current"))
        series["predicted without contact"] = (predicted, "joint")
    save(draw_traces(Traces(time, series, errors(series, measured)), CURRENT), output.currents)


def draw_accelerations(accelerations: pd.DataFrame, output: Any) -> None:
    """Figures 5.14 and 5.15: ours and as published."""
    time = unbroken(accelerations, accelerations["time"].to_numpy())
    ours = {"felt": ("IMU", "measured"), "acceleration_encoders": ("from the joints", "first")}
    published = {
        "published_felt": ("IMU", "measured"),
        "published_euler": ("Euler angles, Equation 2.33 as printed", "second"),
    }
    for names, path in ((ours, output.accelerations), (published, output.accelerations_published)):
        series = {
            label: (unbroken(accelerations, channel(accelerations, name)), style)
            for name, (label, style) in names.items()
            if f"{name}_0" in accelerations
        }
        felt = series["IMU"][0] if series else None
        save(draw_traces(Traces(time, series, errors(series, felt)), ACCELERATION), path)


def draw_published(published: pd.DataFrame, sensor: pd.DataFrame, output: Any) -> None:
    """Figures 6.4 to 6.9, as printed and corrected: values, and errors under them."""
    time = unbroken(sensor, sensor["time"].to_numpy())
    for kind in ("printed", "corrected"):
        measured = wrench(sensor, kind)
        for estimates, name in ((("F", "Fu"), "forces"), (("F*",), "forces_friction")):
            series = {} if measured is None else {"force sensor": (measured, "measured")}
            for estimate in estimates:
                values = wrench(published, f"{kind}_{estimate}")
                if values is not None:
                    label, style = PUBLISHED[estimate]
                    series[label] = values, style
            traces = Traces(time, series, errors(series, measured))
            save(draw_traces(traces, WRENCH), output[f"{name}_{kind}"])


def draw_estimates(forces: pd.DataFrame, sensor: pd.DataFrame, hidden: Any, output: Any) -> None:
    """The new estimates, the band of F̂ᵐᵃᵖ, the sensor, and where a force hides."""
    measured = wrench(sensor, "compensated")
    series = {} if measured is None else {"force sensor": (measured, "measured")}
    band = None
    for (name, label), style in zip(NEW.items(), DRAWN, strict=True):
        values = wrench(forces, name)
        if values is not None:
            series[label] = values, style
            if name == "Fmap":
                half = BAND * wrench(forces, f"{name}_std")
                band = values - half, values + half
    time = unbroken(forces, forces["time"].to_numpy())
    traces = Traces(time, series, errors(series, measured), band, unbroken(forces, hidden))
    save(draw_traces(traces, WRENCH), output.forces_estimated)


def wrench(table: pd.DataFrame, name: str) -> Any:
    """A wrench of a table, (N, 6); None where the table has none of this name."""
    if f"{name}_Fx" not in table:
        return None
    return unbroken(table, labelled_channel(table, name, COMPONENTS))


def errors(series: Series, reference: Any) -> Series | None:
    """What every other series misses of the one that is the reference."""
    if reference is None or len(series) < 2:
        return None
    return {
        label: (reference - values, style)
        for label, (values, style) in series.items()
        if values is not reference
    }


def unbroken(table: pd.DataFrame, values: Any) -> Any:
    """Values with NaN between segments, so that no line is drawn across a gap."""
    breaks = np.flatnonzero(np.diff(table["segment"])) + 1
    return np.insert(np.asarray(values, dtype=float), breaks, np.nan, axis=0)


if __name__ == "__main__":
    run_step(draw_figures, snakemake)  # type: ignore[name-defined]  # noqa: F821
