"""The present state of an arm."""

from dataclasses import dataclass

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recorder.device import DeviceLost
from ur5lib.recorder.rtde_client import PATIENCE, PORT, RtdeClient
from ur5lib.timeseries.arrays import Array

NAMES = ("actual_q", "actual_qd", "robot_mode", "safety_mode", "runtime_state")
ROBOT_MODES = {  # RTDE's `robot_mode`
    -1: "no controller",
    0: "disconnected",
    1: "confirm safety",
    2: "booting",
    3: "power off",
    4: "power on",
    5: "idle",
    6: "backdrive",
    7: "running",
}
SAFETY_MODES = {  # RTDE's `safety_mode`
    1: "normal",
    2: "reduced",
    3: "protective stop",
    4: "recovery",
    5: "safeguard stop",
    6: "system emergency stop",
    7: "robot emergency stop",
    8: "violation",
    9: "fault",
}
RUNNING, PLAYING = 7, 2
SAFE = (1, 2)


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
        client.start(NAMES, 125.0)
        packages = client.receive(PATIENCE) or client.receive(PATIENCE)
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
        robot_mode=ROBOT_MODES.get(robot, f"unknown mode {robot}"),
        safety_mode=SAFETY_MODES.get(safety, f"unknown mode {safety}"),
        ready=robot == RUNNING and safety in SAFE,
        program_runs=runtime == PLAYING,
    )
