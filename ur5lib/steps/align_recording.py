"""Put every device on the robot's clock, and smooth the joints' motion."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.channels import columns
from ur5lib.records.clocks import HostDrift, OwnClock, SettledClock
from ur5lib.records.motion import Alignment, Motion
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.signals.clock import settle_clocks
from ur5lib.signals.resampling import resample
from ur5lib.smoothing.encoders import smooth_encoders
from ur5lib.smoothing.smoothed_motion import (
    measured,
    motion_account,
    motion_record,
)


class AlignedRecording(NamedTuple):
    """All devices on the robot's clock, and the joints' motion."""

    signals: pd.DataFrame
    motion: Motion
    alignment: Alignment


@step("recording", "signals.parquet motion.parquet alignment.json")
def align_recording(
    robot: pd.DataFrame,
    force: pd.DataFrame,
    imu: pd.DataFrame,
    clocks: dict[str, OwnClock],
    drifts: dict[str, HostDrift] | None = None,
) -> AlignedRecording:
    """Return the devices on the robot's clock, and the motion by a Kalman smoother.

    drifts: of the hosts' clocks, where the study names hosts.
    """
    time = robot["time"].to_numpy()
    settled = settle_clocks(clocks, drifts or {}, float(time[-1] - time[0]))
    table = on_robot_clock(robot, {"force": force, "imu": imu}, settled)
    signals = Signals.from_table(table)
    motion = smooth_encoders(signals.time, signals.segment, *measured(signals))
    return AlignedRecording(
        table,
        motion_record(signals, motion),
        Alignment(settled, motion_account(motion)),
    )


def on_robot_clock(
    robot: pd.DataFrame, devices: dict[str, pd.DataFrame], clocks: dict[str, SettledClock]
) -> pd.DataFrame:
    """Return the robot's table with the samples of its devices at the robot's times."""
    signals = dict(robot.items())
    for device, clock in clocks.items():
        signals |= dict(resample(devices[device], clock, robot["time"].to_numpy()).items())
    if "ft_fx" in signals:  # a sensor without moments has NaN there
        absent = [name for name in columns("ft") if name not in signals]
        signals |= dict.fromkeys(absent, np.full(len(robot), np.nan))
    return pd.DataFrame(signals, copy=False)
