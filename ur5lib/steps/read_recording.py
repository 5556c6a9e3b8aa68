"""Read the devices' files: the robot's frames on a uniform grid, its poses, the devices' clocks."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from ur5lib.checks.devices import checked_intake
from ur5lib.errors import InputError, UnreadableError
from ur5lib.recordings.entries import Entry
from ur5lib.recordings.intake import read_and_repair
from ur5lib.records.clocks import OwnClock
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.quality import Device, Quality
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.signals.own_clocks import own_clocks
from ur5lib.tables import checksum

SENSORS: tuple[Device, ...] = ("force", "imu")
NO_SAMPLES = pd.DataFrame({"time": pd.Series(dtype=float)})


class ReadRecording(NamedTuple):
    """A recording as read, each device on its own clock.

    clocks: of the devices relative to the robot's, by start stamps and motion.
    """

    robot: pd.DataFrame
    force: pd.DataFrame
    imu: pd.DataFrame
    kinematics: Kinematics
    quality: Quality
    clocks: dict[str, OwnClock]


@step(
    "recording",
    "robot.parquet force.parquet imu.parquet kinematics.parquet quality.json "
    "clocks=own_clocks.json",
    recording="entry",
    arm="described",
)
def read_recording(
    recording: Entry, raw: list[Path], arm: Robot, max_gap_s: float
) -> ReadRecording:
    """Return a recording's repaired frames, devices, poses, clocks and quality.

    recording: its entry in the study; raw: its files. Raises UnreadableError where they cannot be
    used.
    """
    try:
        read = read_and_repair(recording, arm, max_gap_s)
        intake = checked_intake(read, arm, recording.path.parts[-2:])
    except InputError as error:
        raise UnreadableError(str(error)) from None
    force, imu = (intake.sensors.get(device, NO_SAMPLES) for device in SENSORS)
    robot = Signals.from_table(intake.robot)
    kinematics = Kinematics.of(robot.time, *flange_kinematics(arm, robot.actual_q))
    frames = kinematics.rotation, kinematics.jacobian
    clocks = own_clocks(intake.quality.starts, {"force": force, "imu": imu}, robot, *frames)
    quality = replace(intake.quality, read={str(path): checksum(path) for path in raw})
    return ReadRecording(intake.robot, force, imu, kinematics, quality, clocks)
