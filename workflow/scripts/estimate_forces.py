"""Contact wrench from motor currents, as the thesis printed it and corrected, and its errors."""

from dataclasses import dataclass
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

COMPONENTS = ["Fx", "Fy", "Fz", "nx", "ny", "nz"]
SENSOR = [f"ft_{quantity}{axis}" for quantity in "ft" for axis in "xyz"]

Wrenches = dict[str, Array]


@dataclass(frozen=True)
class Recording:
    """What a force estimate needs of a recording: its tables, its arm, and the settings."""

    robot: Robot
    signals: pd.DataFrame
    torques: pd.DataFrame
    motion: pd.DataFrame
    kinematics: pd.DataFrame
    params: Any

    def jacobian(self) -> Array:
        """J_g (N, 6, 6)."""
        return channel(self.kinematics, "J", 36).reshape(-1, 6, 6)

    def model_torque(self, motion: str) -> Array:
        """Torque of the arm's chosen model (N, 6) [Nm] at the "target" or "measured" motion."""
        return channel(self.torques, f"tau_{motion}_{self.robot.chosen_model}")

    def knows(self, motion: str) -> bool:
        """Whether currents were recorded, and the model's torque at a motion is known."""
        torque = f"tau_{motion}_{self.robot.chosen_model}_0"
        return torque in self.torques and "actual_current_0" in self.signals


def estimate_forces(input: Any, output: Any, params: Any) -> None:
    names = ("signals", "torques", "motion", "kinematics")
    tables = {name: read_table(getattr(input, name)) for name in names}
    recording = Recording(load_robot(input.arm), **tables, params=params)
    estimates = {"printed": as_printed(recording), "corrected": corrected(recording)}
    references, offset = sensor_wrenches(recording)

    columns = {
        f"{kind}_{name}_{component}": wrench[:, i]
        for kind, wrenches in estimates.items()
        for name, wrench in (wrenches | {"sensor": references[kind]}).items()
        for i, component in enumerate(COMPONENTS)
    }
    times = recording.signals[["time", "segment"]]
    write_table(times.join(pd.DataFrame(columns)), output.forces)
    hidden = float((recording.kinematics["sigma_min"] < params.min_singular_value).mean())
    summary = {
        "force_sensor": offset is not None,
        "sensor_bias": offset,
        "share_near_singularity": hidden,
        "errors": {} if offset is None else all_error_figures(estimates, references),
    }
    write_json(summary, output.summary)


def as_printed(recording: Recording) -> Wrenches:
    """F^u, F and F* the way the published script makes them (errata 5, 6 and 13)."""
    constants, friction = recording.robot.current_to_torque, recording.robot.friction
    if constants is None or friction is None or not recording.knows("target"):
        return _controller_estimate(recording)
    torque = motor_torque_as_published(channel(recording.signals, "actual_current"), constants)
    external = torque - recording.model_torque("target")
    resisted = friction_torque(channel(recording.signals, "target_qd"), friction)
    lag = round(PUBLISHED_JACOBIAN_LAG / period(recording.signals))
    return _wrenches(
        recording, external, resisted, delay(recording.jacobian(), lag), causal_lowpass
    )


def corrected(recording: Recording) -> Wrenches:
    """F^u, F and F* by the printed equations, at the measured motion, without delay."""
    constants, friction = recording.robot.current_to_torque, recording.robot.friction
    if constants is None or friction is None or not recording.knows("measured"):
        return _controller_estimate(recording)
    torque = motor_torque(channel(recording.signals, "actual_current"), constants)
    external = torque - recording.model_torque("measured")
    resisted = friction_torque(channel(recording.motion, "qd"), friction)
    return _wrenches(recording, external, resisted, recording.jacobian(), zero_phase_lowpass)


def _controller_estimate(recording: Recording) -> Wrenches:
    if "actual_TCP_force_0" not in recording.signals:
        return {}
    return {"Fu": channel(recording.signals, "actual_TCP_force")}


def _wrenches(
    recording: Recording, external: Array, friction: Array, jacobian: Array, lowpass: Any
) -> Wrenches:
    """Equations 6.8 (F) and 6.9 (F*), low-passed torques, beside the controller's own F^u."""
    params = recording.params
    rate = 1 / period(recording.signals)
    run = partial(lowpass, rate=rate, order=params.order, cutoff=params.cutoff_hz)
    segment = recording.signals["segment"].to_numpy()
    estimates = _controller_estimate(recording)
    for name, torque in {"F": external, "F*": external - friction}.items():
        smooth = by_segment(run, torque, segment)
        estimates[name] = wrench_from_torque(jacobian, smooth, params.min_singular_value)
    return estimates


def sensor_wrenches(recording: Recording) -> tuple[Wrenches, Array | None]:
    """The reference of each kind, and the sensor's bias; all NaN and None without a sensor."""
    signals, mounting = recording.signals, recording.robot.mounting
    if "ft_fx" not in signals:
        nothing = np.full((len(signals), 6), np.nan)
        return {"printed": nothing, "corrected": nothing}, None
    reading = signals[SENSOR].to_numpy()
    rotation = channel(recording.kinematics, "R6", 9).reshape(-1, 3, 3)
    offset = bias(reading, signals["time"].to_numpy(), recording.params.bias_window_s)
    position = np.array(mounting.force_sensor if mounting else (0.0, 0.0, 0.0))
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
