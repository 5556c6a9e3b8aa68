"""Simulation of one recording: the motion of the arm and the files of its devices."""

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Literal

import numpy as np
import pandas as pd

from ur5lib.robots.description import Robot
from ur5lib.stand.controller_channels import frames
from ur5lib.stand.device_files import (
    Files,
    Sensors,
    realtime_stream,
    rtde_csv,
    thesis_csv,
    write_files,
)
from ur5lib.stand.faults import apply_faults, draw_faulty_frames
from ur5lib.stand.layout import FORMATS_WITH_PAYLOAD
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import perform
from ur5lib.stand.sensors import force_readings, imu_readings, wrist_channels
from ur5lib.stand.write_truth import write_truth

Format = Literal["thesis-csv", "realtime-stream", "rtde-csv"]

# Each has its own random generator, so that an additional sensor does not change the others.
RANDOM_STREAMS = ("arm", "controller", "faults", "force_sensor", "imu", "wrist")
READINGS: dict[str, Callable[..., pd.DataFrame]] = {
    "force_sensor": force_readings,
    "imu": imu_readings,
}
WRITERS: dict[str, Callable[[pd.DataFrame, Sensors, SimulatedRecording], Files]] = {
    "thesis-csv": thesis_csv,
    "realtime-stream": realtime_stream,
    "rtde-csv": rtde_csv,
}
CYCLE_BY_FORMAT = {"thesis-csv": 0.008, "realtime-stream": 0.008, "rtde-csv": 0.002}  # s


def simulate(
    robot: Robot, plan: SimulatedRecording, format: Format, folder: Path, truth: Path
) -> None:
    """Write one recording as real devices would, and the truth about it as separate files.

    folder: of the files that `layout.file_names` lists; truth: path of the truth's table and
    summary, without the suffixes .parquet and .json. The same plan gives the same bytes. Raises
    InputError when the arm cannot execute the plan.
    """
    generators = np.random.default_rng(plan.seed).spawn(len(RANDOM_STREAMS))
    random = dict(zip(RANDOM_STREAMS, generators, strict=True))
    experiment = perform(robot, plan, random["arm"], declare=format in FORMATS_WITH_PAYLOAD)
    cycle = CYCLE_BY_FORMAT[format]
    sent = frames(experiment, cycle, random["controller"] if plan.noise else None)
    if plan.wrist_sensor is not None:
        sent = sent.assign(**wrist_channels(experiment, sent, random["wrist"]))
    faulty = draw_faulty_frames(plan.faults, len(sent), random["faults"])
    sent = apply_faults(sent, faulty, random["faults"])
    sensors = {
        name: READINGS[name](getattr(plan, name), experiment.motion, random[name], plan.noise)
        for name in plan.sensors()
    }
    files = WRITERS[format](sent, sensors, plan)
    write_files(files, folder, plan.faults.torn_files)
    numbers = {name: np.flatnonzero(flags) for name, flags in asdict(faulty).items()}
    devices = {"force": plan.force_sensor, "imu": plan.imu}
    clocks = {
        name: device.clock.model_dump(include={"offset_s", "drift_ppm"})
        for name, device in devices.items()
        if device is not None
    }
    write_truth(experiment.rig, plan, experiment.motion, cycle, clocks, truth, numbers)
