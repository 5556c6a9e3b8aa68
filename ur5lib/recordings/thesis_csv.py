"""Reader of the thesis's recordings: a folder `csv_files` with one CSV per channel."""

import io
import math
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.csv as pacsv

from ur5lib.errors import InputError
from ur5lib.recordings.quality import Device, Finding
from ur5lib.recordings.recording import RawRecording, StartOffset

PERIOD = 0.008  # s, the CB2 controller's cycle
DAY = 86400.0
STALE = 2.0  # s; devices of one run start within 0.1 s of one another

ROBOT_CHANNELS = {  # file: RTDE name
    "log_q_actual.csv": "actual_q",
    "log_qd_actual.csv": "actual_qd",
    "log_i_actual.csv": "actual_current",
    "log_q_target.csv": "target_q",
    "log_qd_target.csv": "target_qd",
    "log_qdd_target.csv": "target_qdd",
    "log_i_target.csv": "target_current",
    "log_m_target.csv": "target_moment",
    "log_tcp_force.csv": "actual_TCP_force",
    "log_tcp_speed.csv": "actual_TCP_speed",
    "log_tool_vector.csv": "actual_TCP_pose",
}
FORCE_COLUMNS = [f"ft_{quantity}{axis}" for quantity in "ft" for axis in "xyz"]
IMU_COLUMNS = [f"imu_{quantity}{axis}" for quantity in "amg" for axis in "xyz"]

# Standard uncertainty of a start against the robot's [s]: the force sensor's stamp agrees to
# 10 ms with the motion; the IMU's has 6 digits and its samples were seen to come 0.1 s late.
FORCE_START_STD, IMU_START_STD = 0.006, 0.1


def read(folder: str | Path) -> RawRecording:
    """Read a recording of the thesis.

    Raises InputError when a robot channel is missing or holds no complete row.
    """
    csv = Path(folder) / "csv_files"
    findings: list[Finding] = []
    robot = _read_robot(csv, findings)
    readings: dict[Device, pd.DataFrame | None] = {
        "force": _read_force(csv / "log_force_sensor.csv", findings),
        "imu": _read_imu(csv / "acc_data.csv", findings),
    }
    starts = _read_starts(csv)
    sensors = {
        device: table
        for device, table in readings.items()
        if table is not None and _belongs(device, starts, findings)
    }
    return RawRecording(robot, PERIOD, sensors, starts, findings)


def _read_robot(csv: Path, findings: list[Finding]) -> pd.DataFrame:
    """One table of all channels, on the frames that every channel has."""
    robot: pd.DataFrame | None = None
    longest = 0
    for file, name in ROBOT_CHANNELS.items():
        names = ["time"] + [f"{name}_{joint}" for joint in range(6)]
        rows = _read_rows(csv / file, names, "robot", findings).sort_values("time")
        if rows.empty:
            raise InputError(
                f"{csv / file} holds no complete row of 7 numbers; record it again or take the "
                "recording out of the study"
            )
        longest = max(longest, len(rows))
        robot = rows if robot is None else _match_frames(robot, rows)
    if robot is None or robot.empty:
        raise InputError(
            f"{csv}: no frame is present in every channel; put files of one run together"
        )
    if len(robot) < longest:
        detail = "channels end at different frames; only frames that all channels have are used"
        lost = longest - len(robot)
        findings.append(Finding("robot", "channels of unequal length", "note", lost, detail))
    return robot


def _match_frames(frames: pd.DataFrame, channel: pd.DataFrame) -> pd.DataFrame:
    """Frames that both have; the same frame's stamps may differ by some µs between files."""
    both = pd.merge_asof(frames, channel, on="time", direction="nearest", tolerance=PERIOD / 4)
    return both.dropna(ignore_index=True)


def _read_force(path: Path, findings: list[Finding]) -> pd.DataFrame | None:
    table = _read_device(path, ["time", *FORCE_COLUMNS], "force", findings)
    if table is not None and (table[FORCE_COLUMNS].abs() <= 1e-6).all(axis=None):
        _absent("force", findings, f"{path.name} holds only zeros: no sensor was connected")
        return None
    return table


def _read_imu(path: Path, findings: list[Finding]) -> pd.DataFrame | None:
    table = _read_device(path, ["time", *IMU_COLUMNS], "imu", findings)
    if table is None:
        return None
    table["time"] = (table["time"] - table["time"].iloc[0]) / 1000  # from a counter of ms
    return table


def _read_device(
    path: Path, names: list[str], device: Device, findings: list[Finding]
) -> pd.DataFrame | None:
    """A sensor's table, or None and a note when there is none."""
    if not path.is_file():
        _absent(device, findings, f"there is no {path.name}")
        return None
    text = path.read_bytes()
    if b"no values recorded" in text[:100] or not text.strip():
        _absent(device, findings, f"{path.name} says that no values were recorded")
        return None
    table = _read_rows(path, names, device, findings)
    if table.empty:
        _absent(device, findings, f"{path.name} holds no complete row of {len(names)} numbers")
        return None
    return table


def _absent(device: Device, findings: list[Finding], detail: str) -> None:
    findings.append(Finding(device, "no sensor", "note", 1, detail))


def _read_rows(
    path: Path, names: list[str], device: Device, findings: list[Finding]
) -> pd.DataFrame:
    """The complete rows of a headerless CSV; damaged lines are left out and found."""
    if not path.is_file():
        raise InputError(f"{path} is missing; copy it there or take the recording out of the study")
    data = path.read_bytes()
    complete = data[: data.rfind(b"\n") + 1]
    lines = complete.count(b"\n")
    if len(complete) < len(data):
        detail = f"{path.name}, line {lines + 1}: ends in the middle, left out"
        findings.append(Finding(device, "torn last line", "note", 1, detail))
    rows = _parse(complete, names)
    if len(rows) < lines:
        detail = f"{path.name}: lines that are not {len(names)} numbers are left out"
        findings.append(Finding(device, "damaged lines", "warning", lines - len(rows), detail))
    return rows


def _parse(data: bytes, names: list[str]) -> pd.DataFrame:
    """Rows of as many finite numbers as there are names."""
    if not data.strip():
        return pd.DataFrame(columns=names, dtype=float)
    table = pacsv.read_csv(
        io.BytesIO(data),
        read_options=pacsv.ReadOptions(column_names=names),
        parse_options=pacsv.ParseOptions(invalid_row_handler=lambda _: "skip"),
        convert_options=pacsv.ConvertOptions(column_types=dict.fromkeys(names, pa.string())),
    ).to_pandas()
    numbers = table.apply(pd.to_numeric, errors="coerce").astype(float)
    return numbers[numbers.abs().lt(math.inf).all(axis="columns")].reset_index(drop=True)


def _read_starts(csv: Path) -> dict[Device, StartOffset]:
    """How much later than the robot's the devices' clocks started, by the stamps."""
    robot = _first_number(csv / "start_time.csv")
    force = _first_number(csv / "log_force_sensor_start_time.csv")
    imu = _first_number(csv / "acc_start_time.csv")  # ms of the day, without a date
    starts: dict[Device, StartOffset] = {}
    if robot is not None and force is not None:
        starts["force"] = StartOffset(force - robot, FORCE_START_STD)
    if robot is not None and imu is not None:
        apart = (imu / 1000 - robot + DAY / 2) % DAY - DAY / 2
        starts["imu"] = StartOffset(apart, IMU_START_STD)
    return starts


def _first_number(path: Path) -> float | None:
    words = path.read_text(errors="replace").split() if path.is_file() else []
    try:
        return float(words[0]) if words else None
    except ValueError:
        return None


def _belongs(device: Device, starts: dict[Device, StartOffset], findings: list[Finding]) -> bool:
    """Whether a device's file is known to be of this run, by its start stamp."""
    if device not in starts:
        detail = "start stamps are missing or torn: its clock cannot be placed, not used"
        findings.append(Finding(device, "no start stamp", "warning", 1, detail))
        return False
    apart = starts[device].seconds
    if abs(apart) > STALE:
        detail = f"started {apart:+.0f} s from the robot: a copy from another run, not used"
        findings.append(Finding(device, "stale copy", "warning", 1, detail))
        return False
    return True
