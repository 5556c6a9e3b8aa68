"""Contact wrench from motor currents, as the thesis printed it, and by its equations put right."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import pandas as pd

from ur5lib.force.current_based import (
    PUBLISHED_JACOBIAN_LAG,
    delay,
    environment_on_arm,
    friction_torque,
    motor_torque,
    motor_torque_as_published,
    wrench_from_torque,
)
from ur5lib.robots.description import Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import WRENCH, channel, labelled, period, read_table, write_table
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import causal_lowpass, zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment

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


def rebuild_forces(input: Any, output: Any, params: Any) -> None:
    names = ("signals", "torques", "motion", "kinematics")
    tables = {name: read_table(getattr(input, name)) for name in names}
    recording = Recording(load_robot(input.arm), **tables, params=params)
    columns: dict[str, Array] = {}
    for kind, wrenches in (("printed", as_printed(recording)), ("corrected", corrected(recording))):
        for name, wrench in wrenches.items():
            columns |= labelled(environment_on_arm(wrench), f"{kind}_{name}", WRENCH)
    times = recording.signals[["time", "segment"]]
    write_table(times.join(pd.DataFrame(columns)), output.forces)


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


if __name__ == "__main__":
    run_step(rebuild_forces, snakemake)  # type: ignore[name-defined]  # noqa: F821
