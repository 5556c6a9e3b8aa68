"""Clocks of a recording's devices from their start stamps and from motion."""

from collections.abc import Mapping
from dataclasses import asdict

import pandas as pd

from ur5lib.records.clocks import OwnClock
from ur5lib.records.quality import Device, StartOffset
from ur5lib.records.signals import SENSOR_COLUMNS, Signals
from ur5lib.signals.clock import clock_from_stamps
from ur5lib.signals.device_clock import device_clock
from ur5lib.timeseries.arrays import Array

GYROSCOPE = SENSOR_COLUMNS["imu"][3:]


def own_clocks(
    starts: Mapping[Device, StartOffset],
    devices: Mapping[Device, pd.DataFrame],
    robot: Signals,
    rotation: Array,
    jacobian: Array,
) -> dict[str, OwnClock]:
    """Return each device's clock.

    starts: offset of each device's start stamp; devices: as read, each on its own clock; rotation,
    jacobian: R_6 (N, 3, 3) and J_g (N, 6, 6) of the robot's samples.
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
