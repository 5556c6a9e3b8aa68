"""Acceleration of the end effector: from joints, through Euler angles, and as an IMU felt it."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.robots.description import Robot, load_robot
from ur5lib.signals.clocks import clock_from_stamps
from ur5lib.signals.end_effector import felt_acceleration, point_acceleration
from ur5lib.signals.euler_route import euler_acceleration
from ur5lib.signals.imu_calibration import (
    AS_DRAWN,
    ImuCalibration,
    ImuRecord,
    accelerometer_bias,
    calibrate,
)
from ur5lib.signals.imu_record import ACCELEROMETER, GYROSCOPE, has_valid_imu, imu_record
from ur5lib.signals.resampling import resample
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, period, read_json, read_table, write_json, write_table
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.lowpass import (
    THESIS_ACCELERATION,
    Butterworth,
    causal_lowpass,
    inner_lowpass,
)
from ur5lib.timeseries.metrics import mean_absolute_error
from ur5lib.timeseries.segments import by_segment

COMPONENTS = ["x", "y", "z", "rx", "ry", "rz"]
ESTIMATES = {"encoders": "", "encoders+imu": "fused_"}  # prefixes of their channels in motion


@dataclass(frozen=True)
class Recording:
    """What the comparison needs of a recording; robot: under its gravity."""

    signals: pd.DataFrame
    kinematics: pd.DataFrame
    motion: pd.DataFrame
    robot: Robot

    def point(self) -> Array:
        """The IMU's place in frame 6 (3,) [m]."""
        return np.array(self.robot.mounting.imu)

    def gravity(self) -> Array:
        """Gravity in the base frame (3,) [m/s²]."""
        return np.array(self.robot.gravity)

    def rotation(self) -> Array:
        """R_6 (N, 3, 3)."""
        return channel(self.kinematics, "R6", 9).reshape(-1, 3, 3)

    def jacobian(self) -> Array:
        """J_g (N, 6, 6)."""
        return channel(self.kinematics, "J", 36).reshape(-1, 6, 6)

    def by_segment(self, function: Any, values: Array, **settings: float) -> Array:
        """A function of uniform samples, on each unbroken stretch."""
        segment = self.signals["segment"].to_numpy()
        return by_segment(partial(function, **settings), values, segment)

    def lowpass(
        self, function: Any, design: Butterworth, columns: dict[str, Array]
    ) -> dict[str, Array]:
        """Columns, low-passed alike."""
        rate = 1 / period(self.signals)
        return {
            name: self.by_segment(function, values, rate=rate, **design._asdict())
            for name, values in columns.items()
        }

    def derivative(self, values: Array) -> Array:
        """Time derivative of values (N, M)."""
        return self.by_segment(differentiate, values, period=period(self.signals))


def compare_accelerations(input: Any, output: Any, params: Any) -> None:
    signals, kinematics, motion = map(read_table, (input.signals, input.kinematics, input.motion))
    robot = load_robot(input.arm)
    recording = Recording(signals, kinematics, motion, robot.mounted(params.gravity))
    columns: dict[str, Array] = {}
    summary: dict[str, Any] = {"errors": {}}
    if has_valid_imu(read_json(input.clocks)):
        others = other_records(input, robot, params)
        calibration = calibrate([*others.values()]) if others else AS_DRAWN
        ours, bias = as_calibrated(recording, calibration, params)
        stamps = read_json(input.quality)["starts"]["imu"]
        theirs = as_published(recording, read_table(input.imu), stamps)
        errors = error_figures(theirs, "published_felt") | error_figures(ours, "felt")
        columns = ours | theirs
        summary = {"calibrated_on": [*others], "accelerometer_bias": bias, "errors": errors}
    flat: dict[str, Array] = {}
    for name, values in columns.items():
        flat |= named(values, name)
    write_table(signals[["time", "segment"]].join(pd.DataFrame(flat)), output.accelerations)
    write_json(summary, output.summary)


def other_records(input: Any, robot: Robot, params: Any) -> dict[str, ImuRecord]:
    """All other contact-free recordings of the arm with a valid IMU."""
    tables = zip(
        params.others,
        params.other_gravities,
        input.other_signals,
        input.other_kinematics,
        input.other_clocks,
        strict=True,
    )
    return {
        name: record_of(robot.mounted(gravity), read_table(signals), read_table(kinematics), params)
        for name, gravity, signals, kinematics, clocks in tables
        if has_valid_imu(read_json(clocks))
    }


def record_of(
    robot: Robot, signals: pd.DataFrame, kinematics: pd.DataFrame, params: Any
) -> ImuRecord:
    """What the IMU of an arm and its joints tell, low-passed alike."""
    place = np.array(robot.mounting.imu), np.array(robot.gravity)
    return imu_record(signals, kinematics, *place, params.order, params.cutoff_hz)


def as_calibrated(
    recording: Recording, calibration: ImuCalibration, params: Any
) -> tuple[dict[str, Array], Array]:
    """What the calibrated IMU felt, and J_g q̈ + J̇_g q̇ at its place: low-passed without delay.

    Also the accelerometer's bias (3,) [m/s²], which is the recording's own.
    """
    signals, rotation = recording.signals, recording.rotation()
    design = params.order, params.cutoff_hz
    record = record_of(recording.robot, signals, recording.kinematics, params)
    bias = accelerometer_bias(record, calibration)
    accelerometer = signals[ACCELEROMETER].to_numpy() - bias
    turning = recording.derivative(signals[GYROSCOPE].to_numpy())
    axes = rotation @ calibration.axes()
    up = calibration.up(recording.gravity())
    columns = {"felt": felt_acceleration(axes, accelerometer, turning, up)}
    for estimate, prefix in ESTIMATES.items():
        qd, qdd = (channel(recording.motion, f"{prefix}{name}") for name in ("qd", "qdd"))
        columns[f"acceleration_{estimate}"] = point_acceleration(
            rotation, recording.jacobian(), qd, qdd, recording.point()
        )
    return recording.lowpass(inner_lowpass, Butterworth(*design), columns), bias


def as_published(recording: Recording, imu: pd.DataFrame, stamps: Any) -> dict[str, Array]:
    """Section 5.5 as published: clocks by their stamps, an IMU without calibration at the origin
    of frame 6, a causal filter, Euler angles by the printed Equation 2.33 and by the right one.
    """
    signals, rotation = recording.signals, recording.rotation()
    clock = clock_from_stamps(stamps["seconds"], stamps["std"])
    read = resample(imu, clock, signals["time"].to_numpy())
    turning = recording.derivative(read[GYROSCOPE].to_numpy())
    up = AS_DRAWN.up(recording.gravity())
    felt = felt_acceleration(rotation, read[ACCELEROMETER].to_numpy(), turning, up)
    columns = {"published_felt": felt}
    qd = channel(signals, "actual_qd")
    for name, printed in (("euler", True), ("euler, B corrected", False)):
        columns[f"published_{name}"] = euler_acceleration(
            rotation,
            recording.jacobian(),
            qd,
            recording.derivative(qd),
            signals["segment"].to_numpy(),
            period(signals),
            printed,
        )
    return recording.lowpass(causal_lowpass, THESIS_ACCELERATION, columns)


def error_figures(columns: dict[str, Array], felt: str) -> dict[str, dict[str, dict[str, float]]]:
    """MAE by estimate and component against what was felt, and that of an acceleration of zero."""
    zero = mean_absolute_error(np.zeros_like(columns[felt]), columns[felt])
    return {
        name.partition("_")[2]: {
            "mae": dict(zip(COMPONENTS, mean_absolute_error(values, columns[felt]), strict=True)),
            "zero_mae": dict(zip(COMPONENTS, zero, strict=True)),
        }
        for name, values in columns.items()
        if name != felt
    }


if __name__ == "__main__":
    run_step(compare_accelerations, snakemake)  # type: ignore[name-defined]  # noqa: F821
