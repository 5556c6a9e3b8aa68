"""The readers, by the name a study calls them."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ur5lib.recordings.quality import Finding
from ur5lib.recordings.realtime_stream import read_stream
from ur5lib.recordings.recording import DeviceRecord, RawRecording, Stamp
from ur5lib.recordings.rtde_csv import read_rtde_csv
from ur5lib.recordings.sensors import read_sensors
from ur5lib.recordings.table_csv import read_table_csv
from ur5lib.recordings.thesis_csv import read_thesis_csv

RECEIVED_STD = 0.01  # s, of when a message came after it was sent


def read_recording(recording: Mapping[str, Any]) -> RawRecording:
    """Read what the devices wrote. recording: an entry of a study, as plain data.

    Raises InputError when it cannot be read.
    """
    return READERS[recording["format"]](recording)


def read_realtime_stream(recording: Mapping[str, Any]) -> RawRecording:
    """Read a capture of the realtime port. recording: `folder`, `file`, and sensors.

    Time counts from the first message; it was sent when it was received, for all that is known.
    """
    path = Path(recording["folder"]) / recording["file"]
    table, found = read_stream(path)
    findings: list[Finding] = [*found]
    start = Stamp(float(table["received"].iloc[0]), RECEIVED_STD, "epoch_s")
    own = table["time"] - table["time"].iloc[0]
    robot = DeviceRecord(table.assign(time=own), start, str(path))
    return RawRecording(robot, None, read_sensors(recording, findings), findings)


READERS: dict[str, Callable[[Mapping[str, Any]], RawRecording]] = {
    "thesis-csv": read_thesis_csv,
    "realtime-stream": read_realtime_stream,
    "rtde-csv": read_rtde_csv,
    "table-csv": read_table_csv,
}
