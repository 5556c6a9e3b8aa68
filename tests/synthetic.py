"""Made-up recordings, written as the thesis's devices write theirs."""

from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.statics import gravity_torque, link_frames
from ur5lib.tables import named

PERIOD = 0.008
START = 1386689097.80


def write_recording(
    folder: Path, seconds: float, seed: int, force_sensor: bool = False, imu: bool = False
) -> Path:
    """A swinging UR5; with a force sensor, it is pushed in the middle. Returns its CSV folder."""
    csv = folder / "csv_files"
    csv.mkdir(parents=True)
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds / PERIOD)) * PERIOD
    phase, pace = random.uniform(0, 2 * np.pi, 6), random.uniform(1, 3, 6)
    home = np.array([0.3, -1.2, 1.1, -0.9, 1.4, 0.2])
    angle = np.outer(time, pace) + phase
    q, qd, qdd = 0.3 * np.sin(angle) + home, 0.3 * pace * np.cos(angle), 0.0 * angle
    qdd -= 0.3 * pace**2 * np.sin(angle)
    ur5 = load_robot(robot_path("ur5"))
    torque = gravity_torque(ur5, "C", q) + qdd
    channels = {
        "q_actual": q + 1e-5 * np.random.default_rng(seed + 1).normal(size=q.shape),
        "q_target": q,
        "qd_actual": qd,
        "qd_target": qd,
        "qdd_target": qdd,
        "i_actual": (torque + np.sign(qd)) / 10 + 0.1 * random.normal(size=angle.shape),
        "i_target": torque / 10,
        "m_target": torque,
        "tcp_force": np.cos(angle),
        "tcp_speed": 0.1 * np.cos(angle),
        "tool_vector": np.hstack([link_frames(ur5, q)[1][:, 6], np.zeros_like(q[:, :3])]),
    }
    for name, values in channels.items():
        write_channel(csv / f"log_{name}.csv", time, values)
    (csv / "start_time.csv").write_text(f"{START:.12g}\n" * len(time))
    if force_sensor:
        write_force_sensor(csv, seconds, random)
    else:
        write_channel(csv / "log_force_sensor.csv", time, np.full_like(q, -1e-6))
    (csv / "log_force_sensor_start_time.csv").write_text(f"{START + 0.005:.6f}\n")
    if imu:
        ticks = np.arange(0, 1000 * seconds, 4)
        write_channel(csv / "acc_data.csv", ticks, random.normal(size=(len(ticks), 9)), "%d")
        (csv / "acc_start_time.csv").write_text(f"{START % 86400 * 1000:.6g}")
    return csv


def poor_log(arm: Robot, seconds: float, seed: int, speed: float = 0.8) -> pd.DataFrame:
    """Positions, velocities and currents alone, of an arm that moves all joints, at 125 Hz.

    speed: of each joint, at most [rad/s]; it rests in the last 5 s.
    """
    random, joints = np.random.default_rng(seed), len(arm.joints)
    time = np.arange(round(seconds / PERIOD)) * PERIOD
    pace = random.uniform(0.3, 1.2, (joints, 3))
    angle = time[:, None, None] * pace + random.uniform(0, 2 * np.pi, (joints, 3))
    going = np.clip((seconds - 5 - time) / 2, 0, 1)[:, None]
    qd = speed / 3 * np.cos(angle).sum(axis=2) * going
    home = np.array([0.3, -1.2, 1.1, -0.9, 1.4, 0.2])
    q = home + np.cumsum(qd, axis=0) * PERIOD
    torque = gravity_torque(arm, arm.chosen_model, q)
    sizes, constants = np.array(arm.torque_limits()), np.array(arm.maker_torque_constants())
    friction = sizes * (0.04 * np.tanh(qd / 0.01) + 0.03 * qd)
    inertia = 0.01 * sizes * np.gradient(qd, PERIOD, axis=0)
    noise = 0.01 * sizes * random.normal(size=q.shape)
    current = (1.1 * torque + friction + inertia + noise) / constants
    channels = {"actual_q": q, "actual_qd": qd, "actual_current": current}
    columns = [named(values, name) for name, values in channels.items()]
    return pd.DataFrame(
        {"time": time} | {key: own for each in columns for key, own in each.items()}
    )


def write_force_sensor(csv: Path, seconds: float, random: np.random.Generator) -> None:
    time = np.arange(0, seconds, 1 / 207)
    push = np.where(np.abs(time - 0.7 * seconds) < 0.5, 20.0, 0.0)
    reading = np.outer(push, [1, 0, 0, 0, 0.1, 0]) + np.array([-5, 2, -1, 0.1, 0.4, -0.1])
    write_channel(
        csv / "log_force_sensor.csv", time, reading + 0.01 * random.normal(size=(len(time), 6))
    )


def write_channel(path: Path, time: np.ndarray, values: np.ndarray, stamp: str = "%.6f") -> None:
    """One row per sample, comma and blank between numbers, as the thesis's recorder wrote."""
    table = np.column_stack([time, values])
    np.savetxt(path, table, delimiter=", ", fmt=[stamp, *["%.6f"] * values.shape[1]])
