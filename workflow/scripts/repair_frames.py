"""Read the devices' files, and repair the robot's frames on a uniform grid."""

import json
from typing import Any

import pandas as pd

from ur5lib.recordings.intake import checksum, read_and_repair
from ur5lib.recordings.stop_signs import with_stop_signs
from ur5lib.robots.description import Payload, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import write_json, write_table

NO_SAMPLES = pd.DataFrame({"time": pd.Series(dtype=float)})


def repair_frames(input: Any, output: Any, params: Any) -> None:
    arm = load_robot(input.arm).mounted(params.gravity)
    payload = Payload.model_validate_json(params.payload) if params.payload else None
    intake = read_and_repair(json.loads(params.recording), arm, params.max_gap_s)
    intake = with_stop_signs(intake, arm, payload, params.role)
    write_table(intake.robot, output.robot)
    write_table(intake.sensors.get("force", NO_SAMPLES), output.force)
    write_table(intake.sensors.get("imu", NO_SAMPLES), output.imu)
    read = {path: checksum(path) for path in input.raw}
    write_json(intake.quality | {"read": read}, output.quality)


if __name__ == "__main__":
    run_step(repair_frames, snakemake)  # type: ignore[name-defined]  # noqa: F821
