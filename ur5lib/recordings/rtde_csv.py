"""Reader of CSV files from ur_rtde's file recording and Universal Robots' own RTDE client."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.columns import RESERVED
from ur5lib.recordings.delimited import drop_untimed, first_line, read_numbers
from ur5lib.recordings.plausibility import first_time
from ur5lib.recordings.quality import Finding
from ur5lib.recordings.recording import DeviceRecord, RawRecording, Stamp
from ur5lib.recordings.sensors import read_sensors


def read_rtde_csv(recording: Mapping[str, Any]) -> RawRecording:
    """Read a CSV with RTDE names in its header. recording: `folder`, `file`, and sensors.

    `timestamp` counts from the controller's start; the time returned counts from the first row.
    `host_time`, if there is one, is when each row arrived [s].
    Raises InputError when there is no `timestamp` column or no complete row.
    """
    path = Path(recording["folder"]) / recording["file"]
    findings: list[Finding] = []
    table = read_numbers(path, None, "robot", findings)
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
    table = table.drop(columns=RESERVED, errors="ignore")
    table = table.rename(columns={"timestamp": "time", "host_time": "received"})
    table = drop_untimed(table, path, "robot", findings)
    table["time"] -= first_time(table["time"].to_numpy())
    robot = DeviceRecord(table, Stamp(0.0, 0.0, "relative_s"), str(path))
    return RawRecording(robot, None, read_sensors(recording, findings), findings)
