"""Writers of simulated device files."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.channels import THESIS_FILES
from ur5lib.robots.realtime_message import encoded, fields
from ur5lib.stand.faults import is_moving, receipts_with_late_packets, without_last_buffer
from ur5lib.stand.layout import ROBOT_FILES
from ur5lib.stand.plan import Clock, SimulatedRecording
from ur5lib.tables import channel, write_text

EPOCH = 1388577600.0  # s; fictitious date of all recordings, 2014-01-01 12:00 UTC
SECONDS_PER_DAY = 86400.0  # s
STALE_RUN_AGE = 5000.0  # s; the run of a stale file was this much earlier
CONTROLLER_UPTIME = 4096.0  # s; the controller's clock at the start of a recording
MESSAGE_BYTES = 756  # of a message of the realtime port, software 1.5 and 1.6
UNCONNECTED_SENSOR_READING = -1e-6  # as in files without a force sensor

Files = dict[str, str]  # text by name
Sensors = Mapping[str, pd.DataFrame]  # readings, by the plan's name of the sensor


def write_files(files: Mapping[str, str], folder: Path, torn: bool) -> None:
    """Write a recording's files into a folder; torn: without their last, partly filled buffers."""
    for name, text in files.items():
        write_text(without_last_buffer(text) if torn else text, folder / name)


def thesis_csv(frames: pd.DataFrame, sensors: Sensors, plan: SimulatedRecording) -> Files:
    """Return one CSV per channel, and the start stamps of the devices.

    The tool's acceleration is omitted: no reader uses the raw counts of the real file.
    """
    files = {
        f"log_{file}.csv": _rows(frames["time"], channel(frames, name))
        for file, name in THESIS_FILES.items()
    }
    files["start_time.csv"] = f"{EPOCH:.12g}\n" * len(frames)
    nothing = {str(column): UNCONNECTED_SENSOR_READING for column in range(6)}
    force = sensors.get("force_sensor", frames[["time"]].assign(**nothing))
    files["log_force_sensor.csv"] = _rows(force["time"], force.drop(columns="time").to_numpy())
    start = EPOCH + (_stamp(plan.force_sensor.clock) if plan.force_sensor else 0.0)
    files["log_force_sensor_start_time.csv"] = f"{start:.6f}\n"
    if plan.imu is not None:
        counter = np.rint(1000 * sensors["imu"]["time"].to_numpy())  # in milliseconds
        table = np.column_stack([counter, sensors["imu"].drop(columns="time").to_numpy()])
        files["acc_data.csv"] = _formatted(table, ", ".join(["%d"] + ["%.6g"] * 9))
        day = _stamp(plan.imu.clock) + EPOCH - STALE_RUN_AGE * plan.faults.stale_imu
        files["acc_start_time.csv"] = (
            f"{day % SECONDS_PER_DAY * 1000:.6g}"  # this file has no newline
        )
    return {f"csv_files/{name}": text for name, text in files.items()}


def realtime_stream(frames: pd.DataFrame, sensors: Sensors, plan: SimulatedRecording) -> Files:
    """Return a capture of the realtime port, `received_s,payload_hex`, and epoch-time sensors."""
    lines = (f"{EPOCH + time:.6f},{data.hex()}\n" for time, data in _receipts(frames, plan) if data)
    return {
        ROBOT_FILES["realtime-stream"]: "received_s,payload_hex\n" + "".join(lines),
        **_sensor_tables(sensors, plan, EPOCH),
    }


def rtde_csv(frames: pd.DataFrame, sensors: Sensors, plan: SimulatedRecording) -> Files:
    """Return one CSV with RTDE names, and sensors with times from the robot's first row."""
    names = frames.columns.drop(["time", "sent", "kept"])
    header = ",".join(["timestamp", *names]) + "\n"
    rows = _rows(frames["time"] + CONTROLLER_UPTIME, frames[names].to_numpy(), ",")
    return {ROBOT_FILES["rtde-csv"]: header + rows, **_sensor_tables(sensors, plan, 0.0)}


def messages(frames: pd.DataFrame) -> list[bytes]:
    """Return frames as messages of the realtime port."""
    channels = {name: channel(frames, name) for name in fields(MESSAGE_BYTES)}
    return encoded(MESSAGE_BYTES, frames["time"].to_numpy() + CONTROLLER_UPTIME, channels)


def _receipts(frames: pd.DataFrame, plan: SimulatedRecording) -> list[tuple[float, bytes]]:
    """Return time [s] and bytes of each receipt; messages that were cut end early."""
    lengths = (MESSAGE_BYTES * frames["kept"]).astype(int)
    packets = [message[:end] for message, end in zip(messages(frames), lengths, strict=True)]
    time = frames["sent"].to_numpy()
    if plan.faults.late_packets:
        return receipts_with_late_packets(packets, time, is_moving(frames))
    return list(zip(time.tolist(), packets, strict=True))


def _sensor_tables(sensors: Sensors, plan: SimulatedRecording, zero: float) -> Files:
    """Return `force_sensor.csv` and `imu.csv`; their time starts at `zero` [s]."""
    other_run = {"imu": STALE_RUN_AGE * plan.faults.stale_imu}
    return {
        f"{name}.csv": _rows(
            zero + _stamp(getattr(plan, name).clock) - other_run.get(name, 0.0) + table["time"],
            table.drop(columns="time").to_numpy(),
        )
        for name, table in sensors.items()
    }


def _stamp(clock: Clock) -> float:
    """Return a device's start stamp, relative to the robot's start [s]."""
    return clock.offset_s + clock.stamp_error_s


def _rows(time: pd.Series, values: np.ndarray, mark: str = ", ") -> str:
    """Return one row per sample with six decimals."""
    return _formatted(np.column_stack([time, values]), mark.join(["%.6f"] * (1 + values.shape[1])))


def _formatted(table: np.ndarray, row: str) -> str:
    return (f"{row}\n" * len(table)) % tuple(table.ravel().tolist())
