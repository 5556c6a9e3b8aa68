"""The readers of all formats, by the name that a study uses."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.array_files import LOADERS
from ur5lib.recordings.arrays import read_arrays
from ur5lib.recordings.entries import Files
from ur5lib.recordings.host_clock import on_robot_clock
from ur5lib.recordings.ordering import continued, epochs
from ur5lib.recordings.plausibility import first_time
from ur5lib.recordings.recording import RawRecording
from ur5lib.recordings.robot_files import read_realtime_stream, read_rtde_csv, read_table_csv
from ur5lib.recordings.thesis_csv import read_thesis_csv

READERS: dict[str, Callable[[Any], RawRecording]] = {
    "thesis-csv": read_thesis_csv,
    "realtime-stream": read_realtime_stream,
    "rtde-csv": read_rtde_csv,
    "table-csv": read_table_csv,
    **dict.fromkeys(LOADERS, read_arrays),
}


def read_recording(recording: Files) -> RawRecording:
    """Read the files of a recording, cut to its `from_s` and `to_s`, with sensors of the same host
    on the robot's clock.

    Raises InputError when they cannot be read.
    """
    raw = on_robot_clock(READERS[recording.format](recording))
    return excerpt(raw, recording.from_s, recording.to_s)


def excerpt(raw: RawRecording, start: float | None, end: float | None) -> RawRecording:
    """Return a recording with only the robot's frames from `start` until before `end`.

    start, end: [s] since the recording's first frame; None for its begin or end. Clocks and stamps
    stay, so that sensors keep their place. Raises InputError when no frame is left.
    """
    if start is None and end is None:
        return raw
    table, time = raw.robot.table, raw.robot.table["time"].to_numpy(float)
    since = continued(time, epochs(time)) - first_time(time)
    within = (since >= (start or 0.0)) & (since < (np.inf if end is None else end))
    if not within.any():
        raise InputError(
            f"{raw.robot.source}: has no frame between `from_s` and `to_s`; it lasts "
            f"{np.nanmax(since):.4g} s"
        )
    part = table[within].reset_index(drop=True)
    return replace(raw, robot=replace(raw.robot, table=part))
