"""Doubles of all devices of a laboratory, in place of a study's devices."""

import csv
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from ur5lab.doubles.controller_double import ControllerDouble
from ur5lab.doubles.device_double import HOST, DeviceClock
from ur5lab.doubles.net_ft_double import INTERNAL_RATE, NetFTDouble
from ur5lab.doubles.true_states import force_reading, imu_reading
from ur5lab.doubles.xsens_double import XsensDouble
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import ForceSensor, Imu, SimulatedRecording
from ur5lib.stand.rig import STEP, build_rig
from ur5lib.stand.write_truth import write_truth
from ur5lib.study.devices import (
    ArmSettings,
    LabSettings,
    NetFTSettings,
    XsensSettings,
)

# Clocks and rates differ from device to device, as they do in a laboratory.
FORCE_RATE, IMU_RATE = 500.0, 256.0  # Hz
FORCE_CLOCK, IMU_CLOCK = DeviceClock(drift_ppm=40.0), DeviceClock(drift_ppm=-3000.0)
ARM_CLOCK = DeviceClock(offset_s=4096.0, drift_ppm=25.0)
FORCE_SENSOR, IMU = ForceSensor(bias=(-5.3, 1.8, -1.0, 0.07, 0.43, -0.11)), Imu()
TRUTH_STEM = "truth"  # file of the truth next to a recording's files, without suffix
PUSH = {"kind": "push", "start_s": 8, "seconds": 3, "force": [20.0, -10.0, 25.0]}


@contextmanager
def lab_double(robot: Robot, is_pushed: bool, folder: Path) -> Iterator[LabSettings]:
    """Yield the settings of doubles, which answer only on this computer.

    They replace an arm, an ATI Net F/T on its flange, and an Xsens MTi. is_pushed: whether the arm
    is pushed 8 s after it is switched on. folder: of the recording; the truth is written next to
    its files.
    """
    plain = {"trajectory": {"kind": "standstill"}, "contacts": [PUSH] if is_pushed else []}
    sensors = {"force_sensor": FORCE_SENSOR, "imu": IMU}
    plan = SimulatedRecording.model_validate(plain | sensors)  # at rest until somebody moves it
    with ControllerDouble(robot, plan, clock=ARM_CLOCK) as arm:
        box = NetFTDouble(force_reading(arm.truth, FORCE_SENSOR), FORCE_RATE, FORCE_CLOCK)
        imu = XsensDouble(imu_reading(arm.truth, IMU, IMU_RATE), IMU_RATE, IMU_CLOCK)
        with box, imu:
            yield LabSettings(
                robot=ArmSettings(address=HOST),
                force_sensor=NetFTSettings(address=HOST, port=box.port, http_port=box.http_port),
                imu=XsensSettings(port=imu.path, rate_hz=IMU_RATE),
            )
        start = _first(folder / "robot.csv", "timestamp")
        if start is not None:  # the arm was recorded
            _write_truth(arm, box, imu, folder, start)


def _write_truth(
    arm: ControllerDouble, box: NetFTDouble, imu: XsensDouble, folder: Path, start: float
) -> None:
    """Write the truth of a recording that starts at a time of the controller's clock [s]."""
    counts = {  # of each sensor: first sample in its file, rate, clock
        "force": (_first(folder / "force_sensor.csv", "ft_sequence"), INTERNAL_RATE, box.clock),
        "imu": (_first(folder / "imu.csv", "sample_counter"), IMU_RATE, imu.clock),
    }
    clocks = {
        name: {"offset_s": arm.clock.shown(clock.host(count / rate)) - start}
        for name, (count, rate, clock) in counts.items()
        if count is not None
    }
    setup = arm.setup
    motion = arm.truth.states(round((start - setup.clock.offset_s) / STEP))
    rig = build_rig(setup.robot, setup.plan, np.random.default_rng(setup.seed))
    write_truth(rig, setup.plan, motion, 1 / setup.rate, clocks, folder / TRUTH_STEM)


def _first(file: Path, column: str) -> float | None:
    """Return the first number in a column of a file, None without one."""
    if not file.is_file():
        return None
    with file.open(encoding="ascii") as lines:
        row = next(csv.DictReader(lines), None)
    return float(row[column]) if row else None
