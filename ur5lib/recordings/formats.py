"""The readers of all formats, by the name that a study uses."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ur5lib.recordings.excerpt import excerpt
from ur5lib.recordings.host_clock import on_robot_clock
from ur5lib.recordings.quality import Finding
from ur5lib.recordings.realtime_stream import read_stream
from ur5lib.recordings.recording import DeviceRecord, RawRecording, Stamp
from ur5lib.recordings.rtde_csv import read_rtde_csv
from ur5lib.recordings.sensors import read_sensors
from ur5lib.recordings.stored import LOADERS, read_stored
from ur5lib.recordings.table_csv import read_table_csv
from ur5lib.recordings.thesis_csv import read_thesis_csv

RECEIVED_STD = 0.01  # s, uncertainty of the delay between sending and receiving a message


def read_recording(recording: Mapping[str, Any]) -> RawRecording:
    """Read the files of a recording, or the part that is wanted of them.

    recording: an entry of a study, as plain data. Raises InputError when they cannot be read.
    """
    raw = on_robot_clock(READERS[recording["format"]](recording))
    return excerpt(raw, recording.get("from_s"), recording.get("to_s"))


def read_realtime_stream(recording: Mapping[str, Any]) -> RawRecording:
    """Read a capture of the realtime port. recording: `folder`, `file`, and sensors.

    Time counts from the first message. Its send time is unknown, so its time of receipt is used.
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
    **dict.fromkeys(LOADERS, read_stored),
}
