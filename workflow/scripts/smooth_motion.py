"""Joint motion by a Kalman smoother: from the encoders, and with an IMU where one is valid."""

from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.robots.description import load_robot
from ur5lib.signals.imu_calibration import calibration_for
from ur5lib.signals.imu_model import LinearImu, linearise_imu
from ur5lib.signals.imu_record import ACCELEROMETER, GYROSCOPE, has_valid_imu
from ur5lib.signals.smoothing import SmoothedMotion, smooth_encoders, smooth_with_imu
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, period, read_json, read_table, write_json, write_table
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.segments import by_segment

STATES = {"q": slice(0, 6), "qd": slice(6, 12), "qdd": slice(12, 18)}
BIASES = {"accelerometer_bias": slice(18, 21), "gyroscope_bias": slice(21, 24)}


def smooth_motion(input: Any, output: Any, params: Any) -> None:
    signals = read_table(input.signals)
    time, segment = signals["time"].to_numpy(), signals["segment"].to_numpy()
    q, qd = measured(signals)
    motion = smooth_encoders(time, segment, q, qd)
    columns, summary = channels(motion, STATES, ""), {"encoders": account(motion)}
    if has_valid_imu(read_json(input.clocks)):
        imu = imu_model(input, params, motion.qd)
        readings = signals[[*ACCELEROMETER, *GYROSCOPE]].to_numpy()
        fused = smooth_with_imu(time, segment, q, qd, readings, imu, motion)
        columns |= channels(fused, STATES | BIASES, "fused_")
        summary["encoders+imu"] = account(fused)
    write_table(signals[["time", "segment"]].join(pd.DataFrame(columns)), output.motion)
    write_json(summary, output.summary)


def measured(signals: pd.DataFrame) -> tuple[Array, Array]:
    """Positions and velocities (N, 6), NaN where interpolated; without velocities, differences."""
    q = channel(signals, "actual_q")
    if "actual_qd_0" in signals:
        qd = channel(signals, "actual_qd")
    else:
        change = partial(differentiate, period=period(signals))
        qd = by_segment(change, q, signals["segment"].to_numpy())
    q[signals["interpolated"]] = qd[signals["interpolated"]] = np.nan
    return q, qd


def imu_model(input: Any, params: Any, qd: Array) -> LinearImu:
    """The IMU's equation about a motion, as other recordings calibrated it."""
    kinematics, robot = read_table(input.kinematics), load_robot(input.arm).mounted(params.gravity)
    _, calibration = calibration_for(params.recording, read_json(input.calibration))
    return linearise_imu(
        channel(kinematics, "R6", 9).reshape(-1, 3, 3),
        channel(kinematics, "J", 36).reshape(-1, 6, 6),
        qd,
        np.array(robot.mounting.imu),
        calibration.axes(),
        calibration.up(np.array(robot.gravity)),
    )


def channels(motion: SmoothedMotion, parts: dict[str, slice], prefix: str) -> dict[str, Array]:
    """Parts of the state and their standard deviations as named columns."""
    columns: dict[str, Array] = {}
    for name, part in parts.items():
        columns |= named(motion.state[:, part], prefix + name)
        columns |= named(motion.std[:, part], f"{prefix}{name}_std")
    return columns


def account(motion: SmoothedMotion) -> dict[str, Any]:
    """What noise was found, and whether the innovations bear it out."""
    noise = asdict(motion.encoders)
    noise["jerk"] = np.quantile(motion.encoders.jerk, [0.1, 0.5, 0.9], axis=0)
    if motion.imu is not None:
        noise["imu"] = np.nanmedian(motion.imu, axis=0)
    return {"noise": noise, "innovations": asdict(motion.test)}


if __name__ == "__main__":
    run_step(smooth_motion, snakemake)  # type: ignore[name-defined]  # noqa: F821
