"""Put every device on the robot's clock."""

from typing import Any

import numpy as np

from ur5lib.channels import columns
from ur5lib.signals.clock import HostDrift, OwnClock, settle_clocks
from ur5lib.signals.resampling import resample
from ur5lib.tables import read_record, read_table, write_json, write_table


def align_signals(input: Any, output: Any, params: Any) -> None:
    robot = read_table(input.robot)
    time = robot["time"].to_numpy()
    has_hosts = hasattr(input, "drifts")
    drifts = read_record(dict[str, HostDrift], input.drifts) if has_hosts else {}
    own = read_record(dict[str, OwnClock], input.clocks)
    clocks = settle_clocks(own, drifts, float(time[-1] - time[0]))
    signals = dict(robot.items())
    for device, clock in clocks.items():
        resampled = resample(read_table(getattr(input, device)), clock, time)
        signals |= dict(resampled.items())
    if "ft_fx" in signals:  # the moments of a sensor that has none are NaN
        absent = [name for name in columns("ft") if name not in signals]
        signals |= dict.fromkeys(absent, np.full(len(time), np.nan))
    write_table(signals, output.signals)
    write_json(clocks, output.clocks)
