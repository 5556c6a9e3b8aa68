"""A part of a recording, by time."""

from dataclasses import replace

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.plausibility import first_time
from ur5lib.recordings.recording import RawRecording


def excerpt(raw: RawRecording, start: float | None, end: float | None) -> RawRecording:
    """Return a recording with the robot's frames from `start` until before `end` alone.

    start, end: [s] since the recording's first frame; None: its own. Clocks and stamps stay, and
    with them the place of the sensors. Raises InputError when no frame is left.
    """
    if start is None and end is None:
        return raw
    table = raw.robot.table
    since = table["time"].to_numpy(float) - first_time(table["time"].to_numpy(float))
    within = (since >= (start or 0.0)) & (since < (np.inf if end is None else end))
    if not within.any():
        raise InputError(
            f"{raw.robot.source}: has no frame between `from_s` and `to_s`; it lasts "
            f"{np.nanmax(since):.4g} s"
        )
    part = table[within].reset_index(drop=True)
    return replace(raw, robot=replace(raw.robot, table=part))
