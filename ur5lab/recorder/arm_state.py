"""The identity of an arm by its controller's dashboard, and its present state by RTDE."""

import contextlib
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from ur5lab.recorder.device import ANSWER_TIMEOUT, DeviceLost, of_recorder
from ur5lab.recorder.rtde_arm import PORT, RtdeClient
from ur5lab.rtde_variables import RobotMode, RuntimeState, SafetyMode
from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array

STATE_OUTPUTS = ("actual_q", "actual_qd", "robot_mode", "safety_mode", "runtime_state")
SAFE_MODES = (SafetyMode.NORMAL, SafetyMode.REDUCED)


@dataclass(frozen=True)
class ArmState:
    """The state of an arm and its controller at one moment.

    q, qd: angles and speeds of the joints (6,) [rad, rad/s]; robot_mode, safety_mode: the
    controller's modes, in words; ready: whether the arm can move now; program_runs: whether a
    program is running, which may move it.
    """

    q: Array
    qd: Array
    robot_mode: str
    safety_mode: str
    ready: bool
    program_runs: bool


def read_state(address: str, port: int = PORT) -> ArmState:
    """Return the state of the arm at an address. Raises InputError when it does not answer."""
    client = RtdeClient(address, port)
    try:
        client.start(STATE_OUTPUTS, 125.0)  # Hz, which every controller offers
        # the first bytes may be part of a package only
        packages = client.receive(ANSWER_TIMEOUT) or client.receive(ANSWER_TIMEOUT)
    except DeviceLost as error:
        raise InputError(f"{error} while its state was read; is the controller booting?") from error
    finally:
        client.close()
    if not packages:
        raise InputError(f"{address} accepts RTDE but sends nothing; restart the controller")
    numbers = packages[-1][1]
    robot, safety, runtime = map(int, numbers[12:])
    return ArmState(
        q=np.array(numbers[:6]),
        qd=np.array(numbers[6:12]),
        robot_mode=_mode_name(robot, RobotMode),
        safety_mode=_mode_name(safety, SafetyMode),
        ready=robot == RobotMode.RUNNING and safety in SAFE_MODES,
        program_runs=runtime == RuntimeState.PLAYING,
    )


def _mode_name(mode: int, modes: type[IntEnum]) -> str:
    if mode not in modes.__members__.values():
        return f"unknown mode {mode}"
    return modes(mode).name.lower().replace("_", " ")


def identify(address: str) -> dict[str, str]:
    """Return the `model`, `serial_number` and `firmware` of the arm at an address, by these names.

    Raises InputError when ur_rtde is not installed or the dashboard does not answer.
    """
    ur_rtde = of_recorder("dashboard_client", "asking the dashboard")
    dashboard = ur_rtde.DashboardClient(address)
    try:
        dashboard.connect()
        identity = {"model": dashboard.getRobotModel(), "firmware": dashboard.polyscopeVersion()}
        identity["serial_number"] = ""
        with contextlib.suppress(RuntimeError):  # of controllers without this command
            identity["serial_number"] = str(dashboard.getSerialNumber())
        dashboard.disconnect()
    except RuntimeError as error:
        raise InputError(
            f"the dashboard of {address}, port 29999, does not answer ({error}); check that the "
            "controller is switched on and in remote control"
        ) from error
    return identity
