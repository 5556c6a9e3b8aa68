"""The truth of a simulated recording, read only by the comparison with estimates."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.stand import controller, sensors
from ur5lib.stand import drive as drives
from ur5lib.stand.engine import Experiment, TrueMotion
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import STEP, Rig
from ur5lib.tables import named, write_json, write_table
from ur5lib.timeseries.arrays import Array

Clocks = dict[str, dict[str, float]]


def write_truth(
    arm: Experiment | Rig,
    plan: SimulatedRecording,
    motion: TrueMotion,
    cycle: float,
    devices: Mapping[str, Any],
    truth: Path,
) -> None:
    """Write truth.parquet, at the controller's frames, and truth.json, the true parameters.

    arm: simulated arm; cycle: of the controller [s]; devices: `clocks`, and `frames`, the numbers
    of faulty frames; truth: path of both files without their suffixes.
    """
    table, units = truth_table(motion, cycle)
    write_table(table, f"{truth}.parquet", units)
    summary = {
        "robot": arm.robot.name,
        "gravity": arm.robot.gravity,
        "model": arm.model,
        "cycle_s": cycle,
        "plan": plan.model_dump(),
        "drive": asdict(arm.drive),
        "friction": asdict(arm.friction),
        "noise": _noise() if plan.noise else None,
        "contacts": _intervals(motion),
        **devices,
    }
    write_json(summary, f"{truth}.json")


def planned_clocks(plan: SimulatedRecording) -> Clocks:
    """Return each device's clock, counted from its first sample: offset + (1 + drift) t_device."""
    devices = {"force": plan.force_sensor, "imu": plan.imu}
    return {
        name: {"offset_s": device.clock.offset_s, "drift_ppm": device.clock.drift_ppm}
        for name, device in devices.items()
        if device is not None
    }


def truth_table(motion: TrueMotion, cycle: float) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return the true time series at the controller's frames, and the unit of each column.

    Columns: `time`; q, qd, qdd; tau_motor, tau_friction, tau_contact [Nm]; wrench of the
    environment on link 6 and beyond [N, Nm], base axes, at the origin of frame 6; o6, R6: pose of
    frame 6.
    """
    every = slice(None, None, round(cycle / STEP))
    parts = {
        "q": (motion.q, "rad"),
        "qd": (motion.qd, "rad/s"),
        "qdd": (motion.qdd, "rad/s2"),
        "tau_motor": (motion.motor_torque, "Nm"),
        "tau_friction": (motion.friction_torque, "Nm"),
        "tau_contact": (motion.contact_torque, "Nm"),
        "wrench": (motion.wrench, "N, Nm"),
        "o6": (motion.origin, "m"),
        "R6": (motion.rotation, "1"),
    }
    columns, units = {"time": motion.time[every]}, {"time": "s"}
    for name, (values, unit) in parts.items():
        columns |= named(values[every], name)
        units |= dict.fromkeys(named(values[every], name), unit)
    return pd.DataFrame(columns), units


def _noise() -> dict[str, Any]:
    return {
        "current_ripple_a": drives.RIPPLE,
        "current_a": drives.NOISE,
        "current_at_rest_a": drives.NOISE_AT_REST,
        "position_rad": controller.POSITION_NOISE,
        "velocity_rad_s": controller.VELOCITY_NOISE,
        "force_sensor_n_nm": sensors.FORCE_NOISE,
        "gyroscope_rad_s_sqrt_hz": sensors.GYROSCOPE_NOISE,
        "accelerometer_m_s2_sqrt_hz": sensors.ACCELEROMETER_NOISE,
    }


def _intervals(motion: TrueMotion) -> list[list[float]]:
    """Return the starts and ends of all contacts [s]."""
    touched = (motion.contact_torque != 0).any(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], touched, [0]])))
    times: Array = np.append(motion.time, motion.time[-1])[edges]
    return times.reshape(-1, 2).tolist()
