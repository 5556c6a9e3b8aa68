"""Clocks of a recording's devices from start stamps and motion."""

from typing import Any

from ur5lib.pipeline.own_clocks import own_clocks
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.tables import read_json, read_table, write_json


def estimate_clocks(input: Any, output: Any, params: Any) -> None:
    robot, kinematics = Signals.read(input.robot), Kinematics.read(input.kinematics)
    devices = {"force": read_table(input.force), "imu": read_table(input.imu)}
    starts = read_json(input.quality)["starts"]
    clocks = {}
    if starts:  # without a device, nothing of a long recording need be read
        frames = kinematics.rotation, kinematics.jacobian
        clocks = own_clocks(starts, devices, robot, *frames)
    write_json(clocks, output.clocks)
