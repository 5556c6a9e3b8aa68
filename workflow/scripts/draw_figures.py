"""Figures of one recording, after the thesis's 5.9 to 5.12, 5.14, 5.15 and 6.4 to 6.9."""

from typing import Any

import numpy as np
import pandas as pd

from ur5lib.report.figures import ACCELERATION, cartesian_panels, joint_panels, save
from ur5lib.robots.description import Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import WRENCH, channel, labelled_channel, read_table

BAND = 1.96  # standard deviations that hold 95 %
LABELS = {
    "sensor": "force sensor",
    "Fu": "controller's estimate",
    "F": "without friction",
    "F*": "with friction",
    "Fmap": "F^map",
    "observer": "momentum observer",
    "repeat": "repeat-aware",
}
STYLES = {"sensor": "measured", "Fu": "first", "F": "second", "F*": "third"}
STYLES |= {"Fmap": "first", "observer": "second", "repeat": "third"}


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
        ("q", "q", "rad", output.positions),
        ("qd", r"\dot{q}", "rad/s", output.velocities),
    ):
        series = {}
        if f"{state}_{gains}_0" in closed_loop:
            measured = channel(signals, f"actual_{state}")
            looped = measured - channel(closed_loop, f"{state}_{gains}")
            told = measured - channel(signals, f"target_{state}")
            series = {
                "measured − target": (unbroken(signals, told), "measured"),
                f"measured − closed loop, gains {gains}": (unbroken(signals, looped), "first"),
            }
        save(joint_panels(time, series, rf"\Delta {symbol}", unit), path)


def draw_torques(signals: pd.DataFrame, torques: pd.DataFrame, model: str, output: Any) -> None:
    """Figures 5.11 and 5.12: the chosen model against the controller's."""
    time = unbroken(signals, signals["time"].to_numpy())
    motion = "target" if f"tau_target_{model}_0" in torques else "measured"
    modelled = unbroken(signals, channel(torques, f"tau_{motion}_{model}"))
    values = {f"Model {model}, {motion} motion": (modelled, "first")}
    error = {}
    if "target_moment_0" in signals:
        moment = unbroken(signals, channel(signals, "target_moment"))
        values = {"controller's target_moment": (moment, "measured")} | values
        error = {f"target_moment − Model {model}": (moment - modelled, "measured")}
    save(joint_panels(time, values, r"\tau"), output.torques)
    save(joint_panels(time, error, r"\Delta\tau"), output.torque_errors)


def draw_currents(signals: pd.DataFrame, currents: pd.DataFrame, output: Any) -> None:
    """Measured current and the current that motion without contact needs."""
    time = unbroken(signals, signals["time"].to_numpy())
    series = {}
    if "actual_current_0" in signals:
        measured = unbroken(signals, channel(signals, "actual_current"))
        series = {"actual_current": (measured, "measured")}
    if "predicted_current_0" in currents:
        predicted = unbroken(currents, channel(currents, "predicted_current"))
        series["predicted without contact"] = (predicted, "first")
    save(joint_panels(time, series, "i", "A"), output.currents)


def draw_accelerations(accelerations: pd.DataFrame, output: Any) -> None:
    """Figures 5.14 and 5.15: ours and its error, and as published."""
    time = unbroken(accelerations, accelerations["time"].to_numpy())

    def series(**labels: tuple[str, str]) -> dict[str, Any]:
        return {
            label: (unbroken(accelerations, channel(accelerations, name)), style)
            for name, (label, style) in labels.items()
            if f"{name}_0" in accelerations
        }

    ours = series(felt=("IMU", "measured"), acceleration_encoders=("from the joints", "first"))
    published = series(
        published_felt=("IMU", "measured"),
        published_euler=("Euler angles, Equation 2.33 as printed", "second"),
    )
    errors = {}
    if ours:
        (felt, _), (modelled, _) = ours.values()
        errors = {"IMU − from the joints": (felt - modelled, "measured")}
    save(cartesian_panels(time, ours, ACCELERATION), output.accelerations)
    save(cartesian_panels(time, errors, ACCELERATION, r"\Delta "), output.acceleration_errors)
    save(cartesian_panels(time, published, ACCELERATION), output.accelerations_published)


def draw_published(published: pd.DataFrame, sensor: pd.DataFrame, output: Any) -> None:
    """Figures 6.4 and 6.5, 6.6 and 6.7, 6.8 and 6.9, as printed and corrected."""
    time = unbroken(sensor, sensor["time"].to_numpy())
    for kind in ("printed", "corrected"):
        sources = {"sensor": (sensor, kind)}
        sources |= {name: (published, f"{kind}_{name}") for name in ("Fu", "F", "F*")}
        wrenches = {
            name: (unbroken(table, labelled_channel(table, column, WRENCH)), STYLES[name])
            for name, (table, column) in sources.items()
            if f"{column}_Fx" in table
        }

        def chosen(*names: str, known: dict[str, Any] = wrenches) -> dict[str, Any]:
            return {LABELS[name]: known[name] for name in names if name in known}

        errors = {}
        if "sensor" in wrenches:
            measured = wrenches["sensor"][0]
            errors = {
                label: (measured - values, style)
                for label, (values, style) in chosen("Fu", "F", "F*").items()
            }
        save(cartesian_panels(time, chosen("sensor", "F", "Fu")), output[f"forces_{kind}"])
        save(cartesian_panels(time, chosen("sensor", "F*")), output[f"forces_friction_{kind}"])
        save(cartesian_panels(time, errors, prefix=r"\Delta "), output[f"force_errors_{kind}"])


def draw_estimates(forces: pd.DataFrame, sensor: pd.DataFrame, hidden: Any, output: Any) -> None:
    """The new estimates with the band of the first, the sensor, and where a force hides."""
    time = unbroken(forces, forces["time"].to_numpy())
    known = [name for name in ("Fmap", "observer", "repeat") if f"{name}_Fx" in forces]
    series = {}
    if "compensated_Fx" in sensor:
        measured = labelled_channel(sensor, "compensated", WRENCH)
        series["force sensor"] = (unbroken(sensor, measured), "measured")
    for name in known:
        wrench = labelled_channel(forces, name, WRENCH)
        series[LABELS[name]] = (unbroken(forces, wrench), STYLES[name])
    band = None
    if known:
        std = labelled_channel(forces, f"{known[-1]}_std", WRENCH)
        band = LABELS[known[-1]], unbroken(forces, BAND * std)
    figure = cartesian_panels(time, series, band=band, shaded=unbroken(forces, hidden))
    save(figure, output.forces_estimated)


def unbroken(table: pd.DataFrame, values: Any) -> Any:
    """Values with NaN between segments, so that no line is drawn across a gap."""
    breaks = np.flatnonzero(np.diff(table["segment"])) + 1
    return np.insert(values, breaks, np.nan, axis=0)


if __name__ == "__main__":
    run_step(draw_figures, snakemake)  # type: ignore[name-defined]  # noqa: F821
