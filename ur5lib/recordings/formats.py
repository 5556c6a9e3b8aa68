"""The readers of all formats, by the name that a study uses."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.channels import SIGNED_CHANNELS, columns, joint_count
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

POSITION_CHANNELS = ("actual_q", "target_q")
READERS: dict[str, Callable[[Any], RawRecording]] = {
    "thesis-csv": read_thesis_csv,
    "realtime-stream": read_realtime_stream,
    "rtde-csv": read_rtde_csv,
    "table-csv": read_table_csv,
    **dict.fromkeys(LOADERS, read_arrays),
}


def read_recording(recording: Files) -> RawRecording:
    """Read the files of a recording, or the part that is wanted of them.

    Raises InputError when they cannot be read.
    """
    raw = on_robot_clock(READERS[recording.format](recording))
    robot = replace(raw.robot, table=as_described(raw.robot.table, recording))
    return excerpt(replace(raw, robot=robot), recording.from_s, recording.to_s)


def as_described(table: pd.DataFrame, recording: Files) -> pd.DataFrame:
    """Return a robot's table with its joints counted as the arm's description counts them.

    q = q_home + s q_recorded, joint by joint, with the angles q_home of `home_deg` and the signs s
    of `directions`; velocities, accelerations, currents and torques have the sign alone. Raises
    InputError where these are not as many as the recorded joints.
    """
    stated = {"home_deg": recording.home_deg, "directions": recording.directions}
    joints = joint_count(table.columns)
    for key, values in stated.items():
        if values is not None and len(values) != joints:
            raise InputError(
                f"`{key}` in the study has {len(values)} entries, but {recording.path} has "
                f"{joints} joints; give one for each joint"
            )
    if not any(stated.values()):
        return table
    home = np.radians(recording.home_deg or [0.0] * joints)
    described = {
        name: sign * table[name] + (zero if channel in POSITION_CHANNELS else 0.0)
        for channel in SIGNED_CHANNELS
        for name, sign, zero in zip(
            columns(channel, joints), recording.directions or [1] * joints, home, strict=True
        )
        if name in table
    }
    return table.assign(**described)


def excerpt(raw: RawRecording, start: float | None, end: float | None) -> RawRecording:
    """Return a recording with the robot's frames from `start` until before `end` alone.

    start, end: [s] since the recording's first frame; None: its own. Clocks and stamps stay, and
    with them the place of the sensors. Raises InputError when no frame is left.
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
