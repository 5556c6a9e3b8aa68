"""An emulated laboratory that replaces the devices of a study."""

import csv
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ur5lib.recorder.lab import ArmDevice, Lab, NetFTDevice, XsensDevice
from ur5lib.robots.description import Robot
from ur5lib.stand.lab.controller import HOST, EmulatedController
from ur5lib.stand.lab.device_clock import DeviceClock, Drift
from ur5lib.stand.lab.net_ft_box import INTERNAL_RATE, NetFTBox
from ur5lib.stand.lab.readings import ForceReading, ImuReading
from ur5lib.stand.lab.truth_recorder import TruthRecorder
from ur5lib.stand.lab.xsens_device import XsensDevice as EmulatedXsens
from ur5lib.stand.plan import ForceSensor, Imu, SimulatedRecording

FORCE_RATE, IMU_RATE = 1000.0, 256.0  # Hz
FORCE_DRIFT, IMU_DRIFT = 40.0, -3000.0  # ppm, of the devices' clocks
ARM_DRIFT = 25.0  # ppm
PLAN = {  # the arm rests until somebody moves it
    "trajectory": {"kind": "standstill"},
    "force_sensor": {"bias": [-5.3, 1.8, -1.0, 0.07, 0.43, -0.11]},
    "imu": {},
}
TRUTH = "truth"  # file of the truth beside a recording's files, without suffix
PUSH = {"kind": "push", "start_s": 8, "seconds": 3, "force": [20.0, -10.0, 25.0]}


@contextmanager
def emulated_lab(robot: Robot, is_pushed: bool, folder: Path) -> Iterator[Lab]:
    """Yield the devices of an emulated laboratory, which answer on this computer alone.

    An arm, an ATI Net F/T on its flange, and an Xsens MTi. is_pushed: whether the arm is pushed 8 s
    after it is switched on. folder: of the recording; the truth is written beside its files.
    """
    plan = SimulatedRecording.model_validate(PLAN | {"contacts": [PUSH] if is_pushed else []})
    with ExitStack() as devices:
        arm = EmulatedController(robot, plan=plan, drift_ppm=ARM_DRIFT)
        truth = devices.enter_context(arm).truth
        collected = devices.enter_context(TruthRecorder(arm))
        force = ForceReading(truth, plan.force_sensor or ForceSensor())
        box = devices.enter_context(NetFTBox(force, FORCE_RATE, Drift(drift_ppm=FORCE_DRIFT)))
        turning = ImuReading(truth, plan.imu or Imu())
        imu = devices.enter_context(EmulatedXsens(turning, IMU_RATE, Drift(drift_ppm=IMU_DRIFT)))
        yield Lab(
            robot=ArmDevice(address=HOST),
            force_sensor=NetFTDevice(address=HOST, port=box.port, http_port=box.http_port),
            imu=XsensDevice(port=imu.path, rate_hz=IMU_RATE),
        )
        start = _first(folder / "robot.csv", "timestamp")
        if start is not None:
            counters = {
                "force": (box.clock, folder / "force_sensor.csv", "ft_sequence", INTERNAL_RATE),
                "imu": (imu.clock, folder / "imu.csv", "sample_counter", IMU_RATE),
            }
            begins = {name: _begin(*counter) for name, counter in counters.items()}
            clocks = {
                name: {"offset_s": arm.clock.stamp(begin) - start}
                for name, begin in begins.items()
                if begin is not None
            }
            collected.write(start, clocks, folder / TRUTH)


def _begin(clock: DeviceClock, file: Path, counter: str, rate: float) -> float | None:
    """Return the host's time [s] of the first sample in a file, by the device's counter."""
    count = _first(file, counter)
    return None if count is None else clock.host(count / rate)


def _first(file: Path, column: str) -> float | None:
    """Return the first number in a column of a file, None without one."""
    if not file.is_file():
        return None
    with file.open(encoding="ascii") as lines:
        row = next(csv.DictReader(lines), None)
    return float(row[column]) if row else None
