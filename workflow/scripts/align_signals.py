"""Put every device on the robot's clock."""

from dataclasses import asdict
from typing import Any

import pandas as pd

from ur5lib.device_clock import device_clock
from ur5lib.signals.resampling import resample
from ur5lib.steps import run_step
from ur5lib.tables import channel, read_json, read_table, write_json, write_table


def align_signals(input: Any, output: Any, params: Any) -> None:
    robot, kinematics = read_table(input.robot), read_table(input.kinematics)
    rotation = channel(kinematics, "R6", 9).reshape(-1, 3, 3)
    jacobian = channel(kinematics, "J", 36).reshape(-1, 6, 6)
    signals, summary = [robot], {}
    for device, start in read_json(input.quality)["starts"].items():
        table = read_table(getattr(input, device))
        clock, warning = device_clock(table, start, robot, rotation, jacobian)
        signals.append(resample(table, clock, robot["time"].to_numpy()))
        summary[device] = asdict(clock) | {"warning": warning}
    write_table(pd.concat(signals, axis="columns"), output.signals)
    write_json(summary, output.clocks)


if __name__ == "__main__":
    run_step(align_signals, snakemake)  # type: ignore[name-defined]  # noqa: F821
