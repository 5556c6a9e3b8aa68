"""Joint motion by the Kalman smoother, as motion.parquet."""

from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.signals.smoothing import SmoothedMotion
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.segments import by_segment

STATES = {"q": slice(0, 6), "qd": slice(6, 12), "qdd": slice(12, 18)}


def measured(signals: Signals) -> tuple[Array, Array]:
    """Return positions and velocities (N, 6), NaN where interpolated.

    Without recorded velocities, differences of the positions.
    """
    q, qd = signals.actual_q.copy(), signals.actual_qd
    if qd is None:
        qd = by_segment(partial(differentiate, period=signals.period), q, signals.segment)
    qd = qd.copy()
    q[signals.interpolated] = qd[signals.interpolated] = np.nan
    return q, qd


def motion_record(signals: Signals, motion: SmoothedMotion) -> Motion:
    """Return positions, velocities and accelerations with their standard deviations."""
    return Motion(time=signals.time, segment=signals.segment, **state_parts(motion, STATES))


def state_parts(motion: SmoothedMotion, parts: dict[str, slice]) -> dict[str, Array]:
    """Return parts of the state, their standard deviations and the motors' velocities by name."""
    values = {name: motion.state[:, part] for name, part in parts.items()}
    values |= {f"{name}_std": motion.std[:, part] for name, part in parts.items()}
    return values | {"motor_qd": motion.motor_qd}


def motion_account(motion: SmoothedMotion) -> dict[str, Any]:
    """Return the estimated noise and the tests of the innovations."""
    noise = asdict(motion.encoders)
    for name in ("jerk", "vibration", "position", "velocity"):
        noise[name] = np.quantile(noise[name], [0.1, 0.5, 0.9], axis=0)
    if motion.imu is not None:
        noise["imu"] = np.nanmedian(motion.imu, axis=0)
    return {"noise": noise, "innovations": asdict(motion.test)}
