"""An emulated laboratory, in place of devices that a study names."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

from ur5lib.recorder.lab import ArmDevice, Lab, NetFTDevice, XsensDevice
from ur5lib.robots.description import Robot
from ur5lib.stand.lab.controller import HOST, EmulatedController
from ur5lib.stand.lab.net_ft_box import NetFTBox
from ur5lib.stand.lab.own_clock import Drift
from ur5lib.stand.lab.readings import ForceReading, ImuReading
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
PUSH = {"kind": "push", "start_s": 8, "seconds": 3, "force": [20.0, -10.0, 25.0]}


@contextmanager
def emulated_lab(robot: Robot, is_pushed: bool) -> Iterator[Lab]:
    """Yield the devices of an emulated laboratory, which answer on this computer alone.

    An arm, which a hand pushes 8 s after it is switched on if `is_pushed`, an ATI Net F/T between
    flange and hand, and an Xsens MTi.
    """
    plan = SimulatedRecording.model_validate(PLAN | {"contacts": [PUSH] if is_pushed else []})
    with ExitStack() as devices:
        arm = EmulatedController(robot, plan=plan, drift_ppm=ARM_DRIFT)
        truth = devices.enter_context(arm).truth
        force = ForceReading(truth, plan.force_sensor or ForceSensor())
        box = devices.enter_context(NetFTBox(force, FORCE_RATE, Drift(drift_ppm=FORCE_DRIFT)))
        turning = ImuReading(truth, plan.imu or Imu())
        imu = devices.enter_context(EmulatedXsens(turning, IMU_RATE, Drift(drift_ppm=IMU_DRIFT)))
        yield Lab(
            robot=ArmDevice(address=HOST),
            force_sensor=NetFTDevice(address=HOST, port=box.port, http_port=box.http_port),
            imu=XsensDevice(port=imu.path, rate_hz=IMU_RATE),
        )
