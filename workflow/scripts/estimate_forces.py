"""Contact wrench from motor currents, as the thesis printed it and corrected, and its errors."""

from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.force.current_based import (
    PUBLISHED_JACOBIAN_LAG,
    delay,
    friction_torque,
    motor_torque,
    motor_torque_as_published,
    wrench_from_torque,
)
from ur5lib.force.sensor import bias, move_to_frame_6, wrench_on_arm
from ur5lib.metrics import Array, correlation, largest_error, mean_absolute_error
from ur5lib.robots.description import Robot, load_robot
from ur5lib.signals.lowpass import by_segment, causal_lowpass, zero_phase_lowpass
from ur5lib.steps import run_step
from ur5lib.tables import channel, period, read_table, write_json, write_table

MODEL = "C"  # the thesis's choice for its force estimates
COMPONENTS = ["Fx", "Fy", "Fz", "nx", "ny", "nz"]
SENSOR = [f"ft_{quantity}{axis}" for quantity in "ft" for axis in "xyz"]

Wrenches = dict[str, Array]


def estimate_forces(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    signals, torques = read_table(input.signals), read_table(input.torques)
    motion, kinematics = read_table(input.motion), read_table(input.kinematics)

    estimates = {
        "printed": as_printed(robot, signals, torques, kinematics, params),
        "corrected": corrected(robot, signals, torques, motion, kinematics, params),
    }
    references, offset = sensor_wrenches(robot, signals, kinematics, params.bias_window_s)

    columns = {
        f"{kind}_{name}_{component}": wrench[:, i]
        for kind, wrenches in estimates.items()
        for name, wrench in (wrenches | {"sensor": references[kind]}).items()
        for i, component in enumerate(COMPONENTS)
    }
    write_table(signals[["time", "segment"]].join(pd.DataFrame(columns)), output.forces)
    hidden = float((kinematics["sigma_min"] < params.min_singular_value).mean())
    summary = {
        "force_sensor": offset is not None,
        "sensor_bias": offset,
        "share_near_singularity": hidden,
        "errors": {} if offset is None else all_error_figures(estimates, references),
    }
    write_json(summary, output.summary)


def as_printed(
    robot: Robot,
    signals: pd.DataFrame,
    torques: pd.DataFrame,
    kinematics: pd.DataFrame,
    params: Any,
) -> Wrenches:
    """F^u, F and F* the way the published script makes them (errata 5, 6 and 13)."""
    torque = motor_torque_as_published(channel(signals, "actual_current"), robot.current_to_torque)
    external = torque - channel(torques, f"tau_target_{MODEL}")
    friction = friction_torque(channel(signals, "target_qd"), robot.friction)
    lag = round(PUBLISHED_JACOBIAN_LAG / period(signals))
    jacobian = delay(channel(kinematics, "J", 36).reshape(-1, 6, 6), lag)
    return _wrenches(signals, external, friction, jacobian, causal_lowpass, params)


def corrected(
    robot: Robot,
    signals: pd.DataFrame,
    torques: pd.DataFrame,
    motion: pd.DataFrame,
    kinematics: pd.DataFrame,
    params: Any,
) -> Wrenches:
    """F^u, F and F* by the printed equations, at the measured motion, without delay."""
    torque = motor_torque(channel(signals, "actual_current"), robot.current_to_torque)
    external = torque - channel(torques, f"tau_measured_{MODEL}")
    friction = friction_torque(channel(motion, "qd"), robot.friction)
    jacobian = channel(kinematics, "J", 36).reshape(-1, 6, 6)
    return _wrenches(signals, external, friction, jacobian, zero_phase_lowpass, params)


def _wrenches(
    signals: pd.DataFrame,
    external: Array,
    friction: Array,
    jacobian: Array,
    lowpass: Any,
    params: Any,
) -> Wrenches:
    """Equations 6.8 (F) and 6.9 (F*), low-passed torques, beside the controller's own F^u."""
    run = partial(lowpass, rate=1 / period(signals), order=params.order, cutoff=params.cutoff_hz)
    segment = signals["segment"].to_numpy()
    estimates = {"Fu": channel(signals, "actual_TCP_force")}
    for name, torque in {"F": external, "F*": external - friction}.items():
        smooth = by_segment(run, torque, segment)
        estimates[name] = wrench_from_torque(jacobian, smooth, params.min_singular_value)
    return estimates


def sensor_wrenches(
    robot: Robot, signals: pd.DataFrame, kinematics: pd.DataFrame, window: float
) -> tuple[Wrenches, Array | None]:
    """The reference of each kind, and the sensor's bias; all NaN and None without a sensor."""
    if "ft_fx" not in signals:
        nothing = np.full((len(signals), 6), np.nan)
        return {"printed": nothing, "corrected": nothing}, None
    reading = signals[SENSOR].to_numpy()
    rotation = channel(kinematics, "R6", 9).reshape(-1, 3, 3)
    offset = bias(reading, signals["time"].to_numpy(), window)
    position = np.array(robot.mounting.force_sensor)
    unbiased = wrench_on_arm(reading - offset, rotation)
    references = {
        "printed": wrench_on_arm(reading, rotation),
        "corrected": move_to_frame_6(unbiased, rotation, position),
    }
    return references, offset


def all_error_figures(estimates: dict[str, Wrenches], references: Wrenches) -> dict[str, Any]:
    """Errors by kind, estimate, figure and component."""
    return {
        kind: {name: error_figures(wrench, references[kind]) for name, wrench in wrenches.items()}
        for kind, wrenches in estimates.items()
    }


def error_figures(estimate: Array, reference: Array) -> dict[str, dict[str, Array]]:
    """Errors by component, beside those of an estimate that always says "no force"."""
    zero = np.zeros_like(reference)
    figures = {
        "mae": mean_absolute_error(estimate, reference),
        "max": largest_error(estimate, reference),
        "zero_mae": mean_absolute_error(zero, reference),
        "zero_max": largest_error(zero, reference),
        "correlation": correlation(estimate, reference),
    }
    return {name: dict(zip(COMPONENTS, values, strict=True)) for name, values in figures.items()}


if __name__ == "__main__":
    run_step(estimate_forces, snakemake)  # type: ignore[name-defined]  # noqa: F821
