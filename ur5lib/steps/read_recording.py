"""Read the devices' files: the robot's frames on a uniform grid, its poses, the devices' clocks."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from ur5lib.checks.devices import checked_intake
from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.errors import InputError, UnreadableError
from ur5lib.recordings.entries import Entry
from ur5lib.recordings.intake import read_and_repair
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.quality import Device, Quality, StartOffset
from ur5lib.records.signals import SENSOR_COLUMNS, Signals
from ur5lib.robots.description import Robot
from ur5lib.signals.clock import OwnClock, clock_from_stamps
from ur5lib.signals.device_clock import device_clock
from ur5lib.tables import checksum
from ur5lib.timeseries.arrays import Array

SENSORS: tuple[Device, ...] = ("force", "imu")
GYROSCOPE = SENSOR_COLUMNS["imu"][3:]
NO_SAMPLES = pd.DataFrame({"time": pd.Series(dtype=float)})


class ReadRecording(NamedTuple):
    """A recording as read: each device on its own clock, and its clock beside the robot's.

    clocks: by device, from its start stamp and its motion.
    """

    robot: pd.DataFrame
    force: pd.DataFrame
    imu: pd.DataFrame
    kinematics: Kinematics
    quality: Quality
    clocks: dict[str, OwnClock]


def read_recording(
    recording: Entry, raw: list[Path], arm: Robot, max_gap_s: float
) -> ReadRecording:
    """Return a recording's frames, repaired, with what is wrong with them.

    recording: its entry in the study; raw: its files. Raises UnreadableError where they cannot be
    used.
    """
    try:
        intake = checked_intake(read_and_repair(recording, arm, max_gap_s), arm)
    except InputError as error:
        raise UnreadableError(str(error)) from None
    force, imu = (intake.sensors.get(device, NO_SAMPLES) for device in SENSORS)
    robot = Signals.from_table(intake.robot)
    kinematics = Kinematics.of(robot.time, *flange_kinematics(arm, robot.actual_q))
    frames = kinematics.rotation, kinematics.jacobian
    clocks = own_clocks(intake.quality.starts, {"force": force, "imu": imu}, robot, *frames)
    quality = replace(intake.quality, read={str(path): checksum(path) for path in raw})
    return ReadRecording(intake.robot, force, imu, kinematics, quality, clocks)


def own_clocks(
    starts: Mapping[Device, StartOffset],
    devices: Mapping[Device, pd.DataFrame],
    robot: Signals,
    rotation: Array,
    jacobian: Array,
) -> dict[str, OwnClock]:
    """Return each device's clock.

    starts: of its stamps; devices: as read, each on its own clock; rotation, jacobian: R_6
    (N, 3, 3) and J_g (N, 6, 6) of the robot's samples.
    """
    clocks = dict[str, OwnClock]()
    for name, start in starts.items():
        device = devices[name]
        turns = set(GYROSCOPE) <= set(device)
        clock, warning = device_clock(
            device["time"].to_numpy(),
            device[GYROSCOPE].to_numpy() if turns else None,
            clock_from_stamps(start.seconds, start.std, start.drift_std),
            (robot.time, robot.segment, robot.actual_q),
            (rotation, jacobian),
        )
        clocks[name] = OwnClock(**asdict(clock), warning=warning, stamps=start.seconds)
    return clocks
