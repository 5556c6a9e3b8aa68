"""Put every device on the robot's clock."""

from dataclasses import asdict
from typing import Any

import pandas as pd

from ur5lib.signals.clocks import clock_from_stamps
from ur5lib.signals.resampling import resample
from ur5lib.steps import run_step
from ur5lib.tables import read_json, read_table, write_json, write_table


def align_signals(input: Any, output: Any, params: Any) -> None:
    robot = read_table(input.robot)
    starts = read_json(input.quality)["starts"]
    devices = {"force": read_table(input.force), "imu": read_table(input.imu)}
    clocks = {
        device: clock_from_stamps(start["seconds"], start["std"])
        for device, start in starts.items()
    }
    signals = [
        resample(devices[device], clock, robot["time"].to_numpy())
        for device, clock in clocks.items()
    ]
    write_table(pd.concat([robot, *signals], axis="columns"), output.signals)
    write_json({device: asdict(clock) for device, clock in clocks.items()}, output.clocks)


if __name__ == "__main__":
    run_step(align_signals, snakemake)  # type: ignore[name-defined]  # noqa: F821
