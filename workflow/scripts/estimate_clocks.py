"""Clocks of a recording's devices from start stamps and motion."""

from typing import Any

import pandas as pd

from ur5lib.pipeline.clocks import own_clocks
from ur5lib.recordings.quality import Device, Quality
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.signals import Signals
from ur5lib.tables import read_record, read_table, write_json


def estimate_clocks(input: Any, output: Any, params: Any) -> None:
    robot, kinematics = Signals.read(input.robot), Kinematics.read(input.kinematics)
    devices: dict[Device, pd.DataFrame] = {
        "force": read_table(input.force),
        "imu": read_table(input.imu),
    }
    starts = read_record(Quality, input.quality).starts
    clocks = {}
    if starts:  # without a device, nothing of a long recording need be read
        frames = kinematics.rotation, kinematics.jacobian
        clocks = own_clocks(starts, devices, robot, *frames)
    write_json(clocks, output.clocks)
