"""Writes the truth of a simulated recording, which only comparisons with estimates read."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from ur5lib.channels import CURRENT
from ur5lib.stand import controller_channels, sensors
from ur5lib.stand import drive as drives
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import STEP, Rig, States, step_times
from ur5lib.stand.torque_sensors import FRICTION_SHARE_BEHIND_SENSOR, TorqueSensors
from ur5lib.tables import named, write_json, write_table
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import runs

STATE_COLUMNS = {  # quantities of `rig.state_type`: names and units in the table
    "q": ("q", "rad"),
    "qd": ("qd", "rad/s"),
    "qdd": ("qdd", "rad/s2"),
    "motor_torque": ("tau_motor", "Nm"),
    "friction_torque": ("tau_friction", "Nm"),
    "contact_torque": ("tau_contact", "Nm"),
    "wrench": ("wrench", "N, Nm"),
    "origin": ("o6", "m"),
    "rotation": ("R6", "1"),
}

Clocks = dict[str, dict[str, float]]


def write_truth(
    rig: Rig,
    plan: SimulatedRecording,
    motion: States,
    cycle: float,
    clocks: Clocks,
    truth: Path,
    frames: Mapping[str, Labels] | None = None,
) -> None:
    """Write truth.parquet, at the controller's frames, and truth.json, the true parameters.

    The table has the columns `time` and those of STATE_COLUMNS. rig: simulated arm; motion: its
    states; cycle: of the controller [s]; clocks: of the devices, counted from their first samples,
    t_robot = offset + (1 + drift) t_device; truth: path of both files without their suffixes;
    frames: indices of the faulty frames, by fault.
    """
    every = slice(None, None, round(cycle / STEP))
    columns, units = {"time": step_times(len(motion))[every]}, {"time": "s"}
    for quantity, (name, unit) in STATE_COLUMNS.items():
        channels = named(motion[quantity][every], name)
        columns |= channels
        units |= dict.fromkeys(channels, unit)
    write_table(pd.DataFrame(columns), f"{truth}.parquet", units)
    touched = runs((motion["contact_torque"] != 0).any(axis=1))  # starts and ends, by steps
    summary = {
        "robot": rig.robot.name,
        "gravity": rig.robot.gravity,
        "model": rig.model,
        "cycle_s": cycle,
        "plan": plan.model_dump(),
        "drive": asdict(rig.drive),
        "friction": asdict(rig.friction),
        "noise": _noise_sizes() if plan.noise else None,
        **_torque_sensor_parameters(rig),
        "contacts": step_times(len(motion))[touched.clip(max=len(motion) - 1)],
        "clocks": clocks,
    } | ({} if frames is None else {"frames": frames})
    write_json(summary, f"{truth}.json")


def _torque_sensor_parameters(rig: Rig) -> dict[str, object]:
    """Return the parameters that replace those of motors and gears where the joints sense torque.

    With the reading y = gain τ + bias, K y = τ − offset; K is the `torque_constant` [1].
    """
    if rig.robot.measured == CURRENT:
        return {}
    sensor, friction = TorqueSensors.of(rig.robot), rig.friction
    behind = {
        name: FRICTION_SHARE_BEHIND_SENSOR * getattr(friction, name)
        for name in ("coulomb", "viscous", "load", "periodic")
    }
    calibration = {"torque_constant": 1 / sensor.gain, "offset": -sensor.bias / sensor.gain}
    return {
        "drive": asdict(rig.drive) | calibration,
        "friction": asdict(friction) | behind,
        "torque_sensors": asdict(sensor),
    }


def _noise_sizes() -> dict[str, float | Array]:
    """Return the standard deviation or amplitude of each simulated noise, by names of quantity and
    unit.
    """
    return {
        "current_ripple_a": drives.CURRENT_RIPPLE,
        "current_a": drives.CURRENT_NOISE,
        "current_at_rest_a": drives.CURRENT_NOISE_AT_REST,
        "position_rad": controller_channels.POSITION_NOISE,
        "velocity_rad_s": controller_channels.VELOCITY_NOISE,
        "force_sensor_n_nm": sensors.FORCE_NOISE,
        "gyroscope_rad_s_sqrt_hz": sensors.GYROSCOPE_NOISE,
        "accelerometer_m_s2_sqrt_hz": sensors.ACCELEROMETER_NOISE,
    }
