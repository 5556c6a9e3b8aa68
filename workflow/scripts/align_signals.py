"""Put every device on the robot's clock."""

from typing import Any

from ur5lib.signals.host_drifts import HostDrift, read_clock, settle_clocks
from ur5lib.signals.resampling import resample
from ur5lib.tables import read_json, read_table, write_json, write_table


def align_signals(input: Any, output: Any, params: Any) -> None:
    robot = read_table(input.robot)
    time = robot["time"].to_numpy()
    known = read_json(input.drifts) if hasattr(input, "drifts") else {}
    drifts = {host: HostDrift(**drift) for host, drift in known.items()}
    clocks = settle_clocks(read_json(input.clocks), drifts, float(time[-1] - time[0]))
    signals = dict(robot.items())
    for device, clock in clocks.items():
        resampled = resample(read_table(getattr(input, device)), read_clock(clock), time)
        signals |= dict(resampled.items())
    write_table(signals, output.signals)
    write_json(clocks, output.clocks)
