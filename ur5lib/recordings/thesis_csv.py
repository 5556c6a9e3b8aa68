"""Reader of the thesis's recordings: a folder `csv_files` with one CSV per channel."""

from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.channels import THESIS_FILES
from ur5lib.errors import InputError
from ur5lib.recordings.delimited import drop_untimed, first_line, read_numbers
from ur5lib.recordings.entries import Sensor, ThesisFiles
from ur5lib.recordings.ordering import epochs
from ur5lib.recordings.plausibility import check_pace, stray_times
from ur5lib.recordings.recording import DeviceRecord, RawRecording, Stamp
from ur5lib.recordings.sensors import first_number, read_sensor
from ur5lib.records.codes import Found
from ur5lib.records.quality import Device, Finding, Log, add_finding

CYCLE = 0.008  # s, the CB2 controller's
ROBOT_CHANNELS = {f"log_{file}.csv": name for file, name in THESIS_FILES.items()}
EPOCH_SPACING = 1e6  # s; longer than any recording, so that the epochs of a clock stay apart
FORCE_SENSOR = Sensor(
    file="log_force_sensor.csv",
    columns=["time", "ft"],
    start_file="log_force_sensor_start_time.csv",
)
IMU = Sensor(
    file="acc_data.csv",
    columns=["time", "imu_a", "imu_m", "imu_g"],
    time="day_ms",
    start_file="acc_start_time.csv",
    start="day_ms",
)

# Standard uncertainties of the start stamps [s]: the robot's is rounded to 10 ms, the force
# sensor's has microseconds, the IMU's has 6 digits and its samples arrive 0.1 s late.
ROBOT_START_STD, FORCE_START_STD, IMU_START_STD = 0.005, 0.003, 0.1


def read_thesis_csv(recording: ThesisFiles) -> RawRecording:
    """Return a recording of the thesis from the folder `csv_files` in its folder.

    Raises InputError when a robot channel is missing or has no complete row.
    """
    csv = Path(recording.folder) / "csv_files"
    findings: list[Finding] = []
    seconds = first_number(csv / "start_time.csv", ended=True)
    start = None if seconds is None else Stamp(seconds, ROBOT_START_STD, "epoch_s")
    robot = DeviceRecord(_read_robot(csv, findings), start, str(csv))
    sensors: dict[Device, DeviceRecord | None] = {
        "force": read_sensor(csv, FORCE_SENSOR, "force", findings, FORCE_START_STD, ended=True),
        "imu": read_sensor(csv, IMU, "imu", findings, IMU_START_STD),
    }
    present = {device: record for device, record in sensors.items() if record is not None}
    return RawRecording(robot, CYCLE, present, findings)


def _read_robot(csv: Path, findings: list[Finding]) -> pd.DataFrame:
    """Return a table of all channels, from the first to the last frame that all of them have."""
    channels = [_read_channel(csv / file, name, findings) for file, name in ROBOT_CHANNELS.items()]
    start = max(channel["clock"].iloc[0] for channel in channels) - CYCLE / 4
    end = min(channel["clock"].iloc[-1] for channel in channels) + CYCLE / 4
    if not start < end:
        raise InputError(
            f"{csv}: the channels have no frame in common; use files of one and the same run"
        )
    longest = max(channels, key=len)
    robot = longest[["clock", "time"]]
    for channel in channels:
        # The timestamps of one frame may differ by some µs between the files.
        rows = channel.drop(columns="time")
        robot = pd.merge_asof(robot, rows, on="clock", direction="nearest", tolerance=CYCLE / 4)
    shared = robot[robot["clock"].between(start, end)].drop(columns="clock")
    lost = len(longest) - len(shared)
    detail = "channels end at different frames; cut to the shortest"
    add_finding(findings, "robot", Found.CHANNELS_OF_UNEQUAL_LENGTH, "note", lost, detail)
    return shared.reset_index(drop=True)


def _read_channel(path: Path, name: str, findings: list[Finding]) -> pd.DataFrame:
    """Return a channel's rows, sorted by `clock`, a time that continues where the controller's
    restarts.
    """
    names = ["time", *(f"{name}_{joint}" for joint in range(6))]
    log = Log(path, "robot", findings)
    rows = drop_untimed(read_numbers(log, names), log)
    if rows.empty:
        raise InputError(
            f"{path}, line 1: no complete row of 7 numbers (it begins {first_line(path)}); "
            "record it again, or remove the recording from the study"
        )
    # strays are dropped here because joining loses the file's order
    stray = stray_times(rows["time"].to_numpy())
    meaning = "rows far from all others in time; discarded"
    log.add(Found.IMPOSSIBLE_TIMES, "warning", np.count_nonzero(stray), meaning)
    if len(rows) > 1:
        check_pace(rows["time"].to_numpy()[~stray], str(path), CYCLE / 2)
    rows = rows[~stray].reset_index(drop=True)
    rows["clock"] = rows["time"] + EPOCH_SPACING * epochs(rows["time"].to_numpy())
    rows = rows.sort_values("clock", kind="stable", ignore_index=True)
    repeated = rows.duplicated("clock")
    meaning = "rows with a timestamp that was used before; discarded"
    log.add(Found.REPEATED_STAMPS, "warning", repeated.sum(), meaning)
    return rows[~repeated].reset_index(drop=True)
