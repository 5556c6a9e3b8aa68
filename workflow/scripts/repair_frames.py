"""Read the devices' files, and repair the robot's frames on a uniform grid."""

from dataclasses import replace
from typing import Any

import pandas as pd

from ur5lib.checks.devices import checked_intake
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.intake import read_and_repair
from ur5lib.robots.description import load_robot
from ur5lib.tables import checksum, write_json, write_table

NO_SAMPLES = pd.DataFrame({"time": pd.Series(dtype=float)})


def repair_frames(input: Any, output: Any, params: Any) -> None:
    recording, arm = ENTRY.validate_json(params.recording), load_robot(input.arm)
    intake = checked_intake(read_and_repair(recording, arm, params.max_gap_s), arm)
    write_table(intake.robot, output.robot)
    write_table(intake.sensors.get("force", NO_SAMPLES), output.force)
    write_table(intake.sensors.get("imu", NO_SAMPLES), output.imu)
    read = {path: checksum(path) for path in input.raw}
    write_json(replace(intake.quality, read=read), output.quality)
