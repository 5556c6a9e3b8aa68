"""What each device's start stamp and motion tell of its clock."""

from dataclasses import asdict
from typing import Any

from ur5lib.signals.device_clock import device_clock
from ur5lib.steps import run_step
from ur5lib.tables import channel, read_json, read_table, write_json


def estimate_clocks(input: Any, output: Any, params: Any) -> None:
    robot, kinematics = read_table(input.robot), read_table(input.kinematics)
    rotation = channel(kinematics, "R6", 9).reshape(-1, 3, 3)
    jacobian = channel(kinematics, "J", 36).reshape(-1, 6, 6)
    clocks = {}
    for device, start in read_json(input.quality)["starts"].items():
        table = read_table(getattr(input, device))
        clock, warning = device_clock(table, start, robot, rotation, jacobian)
        clocks[device] = asdict(clock) | {"warning": warning, "stamps": start["seconds"]}
    write_json(clocks, output.clocks)


if __name__ == "__main__":
    run_step(estimate_clocks, snakemake)  # type: ignore[name-defined]  # noqa: F821
