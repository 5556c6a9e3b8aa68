"""Readers of a robot's own files: tables, the CSV of RTDE, captures of the realtime port."""

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.delimited import TextTable, drop_untimed, first_line, read_numbers
from ur5lib.recordings.entries import (
    RESERVED_COLUMNS,
    RecordedFiles,
    RtdeFiles,
    TableFiles,
    expand,
)
from ur5lib.recordings.plausibility import first_time
from ur5lib.recordings.realtime_stream import read_stream
from ur5lib.recordings.recording import DeviceRecord, RawRecording, Stamp
from ur5lib.recordings.sensors import counted_from_first, read_sensors
from ur5lib.records.quality import Finding, Log

RECEIVED_STD = 0.01  # s, uncertainty of the delay between sending and receiving a message


def read_table_csv(recording: TableFiles) -> RawRecording:
    """Return a recording from a table. Raises InputError when the file has no row of that many
    numbers.
    """
    findings: list[Finding] = []
    path, names = recording.path, expand(recording.columns)
    log = Log(path, "robot", findings)
    table = drop_untimed(recording.in_si(*TextTable(log).rows(names)), log)
    if table.empty:
        raise InputError(
            f"{path}, line 1: no complete row of {len(names)} numbers (it begins "
            f"{first_line(path)}); correct `columns`, or remove the recording from the study"
        )
    robot = counted_from_first(table, first_time(table["time"].to_numpy()), recording, path)
    return RawRecording(robot, recording.cycle, read_sensors(recording, findings), findings)


def read_rtde_csv(recording: RtdeFiles) -> RawRecording:
    """Return a recording from a CSV with RTDE names in its header, by ur_rtde or Universal Robots'
    own client.

    `timestamp` counts from the controller's start; the time returned counts from the first row.
    `host_time`, if there is one, is when each row arrived [s]. Raises InputError when there is no
    `timestamp` column, no complete row, or an unknown unit.
    """
    path, findings = recording.path, list[Finding]()
    log = Log(path, "robot", findings)
    table = read_numbers(log, None)
    begins = f"(it begins {first_line(path)})"
    if "timestamp" not in table:
        raise InputError(
            f"{path}, line 1: no column `timestamp` {begins}; "
            "record it with a header, or use format table-csv and name the columns in the study"
        )
    if not np.isfinite(table["timestamp"]).any():
        raise InputError(
            f"{path}, line 1: no complete row of {len(table.columns)} numbers {begins}; record it "
            "again, or use format table-csv and name the columns in the study"
        )
    table = table.drop(columns=RESERVED_COLUMNS, errors="ignore")
    table = table.rename(columns={"timestamp": "time", "host_time": "received"})
    table = drop_untimed(recording.in_si(table), log)
    table["time"] -= first_time(table["time"].to_numpy())
    robot = DeviceRecord(table, Stamp(0.0, 0.0, "relative_s"), str(path))
    return RawRecording(robot, None, read_sensors(recording, findings), findings)


def read_realtime_stream(recording: RecordedFiles) -> RawRecording:
    """Return a recording from a capture of the realtime port; time counts from the first message.

    When a message was sent is unknown; the recording's start stamp is when the first was received.
    """
    table, findings = read_stream(recording.path)
    start = Stamp(float(table["received"].iloc[0]), RECEIVED_STD, "epoch_s")
    since_first = table["time"] - table["time"].iloc[0]
    robot = DeviceRecord(table.assign(time=since_first), start, str(recording.path))
    return RawRecording(robot, None, read_sensors(recording, findings), findings)
