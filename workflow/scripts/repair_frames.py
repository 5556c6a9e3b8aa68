"""Read what the devices wrote, and put the robot's frames back on the controller's grid."""

from typing import Any

import pandas as pd

from ur5lib.recordings.formats import READERS
from ur5lib.recordings.frames import to_grid
from ur5lib.steps import run_step
from ur5lib.tables import write_json, write_table

NO_SAMPLES = pd.DataFrame({"time": pd.Series(dtype=float)})


def repair_frames(input: Any, output: Any, params: Any) -> None:
    recording = READERS[params.format](params.folder)
    robot, repairs = to_grid(recording.robot, recording.period, params.max_gap_s)
    findings = recording.findings + repairs
    write_table(robot, output.robot)
    write_table(recording.sensors.get("force", NO_SAMPLES), output.force)
    write_table(recording.sensors.get("imu", NO_SAMPLES), output.imu)
    quality = {
        "frames": len(robot),
        "duration_s": float(robot["time"].iloc[-1] - robot["time"].iloc[0]),
        "devices": ["robot", *recording.sensors],
        "starts": {
            device: {"seconds": start.seconds, "std": start.std}
            for device, start in recording.starts.items()
            if device in recording.sensors
        },
        "findings": [finding.as_row() for finding in findings],
    }
    write_json(quality, output.quality)


if __name__ == "__main__":
    run_step(repair_frames, snakemake)  # type: ignore[name-defined]  # noqa: F821
