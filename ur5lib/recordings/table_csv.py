"""Reader of any delimited table whose columns the study declares."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ur5lib.errors import InputError
from ur5lib.recordings.columns import expand, to_si
from ur5lib.recordings.delimited import drop_untimed, first_line, read_numbers
from ur5lib.recordings.plausibility import first_time
from ur5lib.recordings.quality import Finding
from ur5lib.recordings.recording import DeviceRecord, RawRecording
from ur5lib.recordings.sensors import read_sensors, table_start


def read_table_csv(recording: Mapping[str, Any]) -> RawRecording:
    """Read a table. recording: `folder`, `file`, `columns`, `units`, `time`, and sensors.

    Raises InputError when the file has no row of that many numbers.
    """
    path = Path(recording["folder"]) / recording["file"]
    findings: list[Finding] = []
    names = expand(recording["columns"])
    table = read_numbers(path, names, "robot", findings)
    table = drop_untimed(table, path, "robot", findings)
    if table.empty:
        raise InputError(
            f"{path}, line 1: no complete row of {len(names)} numbers (it begins "
            f"{first_line(path)}); correct `columns`, or remove the recording from the study"
        )
    counts = recording["time"]
    units = recording["units"] | ({"time": "ms"} if counts == "day_ms" else {})
    table = to_si(table, units)
    first = first_time(table["time"].to_numpy())
    table["time"] -= first
    robot = DeviceRecord(table, table_start(first, counts), str(path))
    return RawRecording(robot, None, read_sensors(recording, findings), findings)
