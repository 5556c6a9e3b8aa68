"""ur_rtde's control script, executed natively.

RTDEControlInterface uploads a program in URScript (`rtde_control.script` of its sources) and talks
with it by registers: input integer 0 is the command, further inputs are its arguments; output
integer 0 is 1 for "ready" and 2 for "command done", which the client acknowledges by command 0.
Realtime commands are executed in every cycle and need no acknowledgement.
"""

import re
from collections.abc import Callable

import numpy as np

from ur5lib.robots.description import Payload
from ur5lib.stand.lab import urscript
from ur5lib.stand.lab.control_box import (
    ControlBox,
    Program,
    UnsupportedCommandError,
    Watchdog,
)

NAME = "def rtde_control()"
OFFSET = re.compile(r"# int register offset\n(\d+)")
PATH = re.compile(r"# inject move path\n(.*?)\n    end", re.DOTALL)

COMMAND, ASYNCHRONOUS = 0, 1  # input integers
STATE, RESULT, PROGRESS = 0, 1, 2  # output integers
READY, DONE = 1, 2
STOP_SCRIPT = 255
RUNNING, COUNT, OPERATION = 1 << 15, 1 << 16, 1 << 24  # in the register of progress
COUNTED = 128  # counts and operations are counted modulo this


def is_control_script(text: str) -> bool:
    """Return whether a program is ur_rtde's."""
    return NAME in text


class ControlScript:
    """The state of ur_rtde's control script on one controller."""

    def __init__(self, text: str, box: ControlBox) -> None:
        """text: the program as uploaded, with the client's insertions."""
        self._box, self._registers, self._motion = box, box.registers, box.arm.motion
        offset = OFFSET.search(text)
        self._offset = int(offset[1]) if offset else 0
        path = PATH.search(text)
        self._path = path[1].splitlines() if path else []
        self._moves: Program | None = None  # of an asynchronous command
        self._count = self._operation = 0

    def run(self) -> Program:
        """Yield once per cycle until the client stops the script."""
        self._signal_progress(running=False)
        acknowledged = True
        self._write(STATE, READY)
        while (command := self._integer(COMMAND)) != STOP_SCRIPT:
            if command == 0 or command in REALTIME:
                acknowledged = command == 0 or acknowledged
                yield from self._execute(command)
                self._write(STATE, READY)
            elif acknowledged:
                acknowledged = False
                yield from self._execute(command)
                self._write(STATE, DONE)
            self._continue_moves()
            yield

    def _execute(self, command: int) -> Program:
        if command not in HANDLERS:
            raise UnsupportedCommandError(f"command {command} of ur_rtde is not emulated")
        steps = HANDLERS[command](self)
        if steps is not None:
            yield from steps

    def _continue_moves(self) -> None:
        if self._moves is not None and next(self._moves, "ended") == "ended":
            self._moves = None
            self._signal_progress(running=False)

    def _start(self, moves: Program) -> Program | None:
        """Return moves to wait for; if asynchronous, start them beside the script."""
        if not self._integer(ASYNCHRONOUS):
            self._moves = None
            return moves
        self._operation = (self._operation + 1) % COUNTED
        self._moves = moves
        next(moves, None)
        self._signal_progress(running=True)
        return None

    def _signal_progress(self, running: bool) -> None:
        self._count = (self._count + 1) % COUNTED
        value = self._count * COUNT + self._operation * OPERATION + RUNNING * running
        self._write(PROGRESS, value)

    def _integer(self, k: int) -> int:
        return self._registers.integer(k + self._offset)

    def _doubles(self, first: int, count: int) -> np.ndarray:
        return self._registers.doubles(first + self._offset, count)

    def _write(self, k: int, value: int) -> None:
        self._registers.write_integer(k + self._offset, value)

    def _answer(self, values: np.ndarray) -> None:
        self._registers.write_doubles(self._offset, iter(values))

    # The commands

    def nothing(self) -> None:
        """Do nothing: no command, or one without a counterpart here."""

    def move_j(self) -> Program | None:
        """Move to joint angles."""
        *goal, speed, acceleration = self._doubles(0, 8)
        self._motion.movej(np.array(goal), speed, acceleration)
        return self._start(urscript.wait_until_done(self._box))

    def move_path(self) -> Program | None:
        """Move along the path that the client has inserted; blends are not emulated."""
        return self._start(urscript.program(self._path, self._box))

    def servo_j(self) -> None:
        """Follow joint angles."""
        self._motion.servoj(self._doubles(0, 6), self._doubles(9, 1)[0])

    def speed_j(self) -> None:
        """Move at joint speeds."""
        self._motion.speedj(self._doubles(0, 6), self._doubles(6, 1)[0])

    def stop_motion(self) -> Program:
        """Brake all joints."""
        self._moves = None
        self._signal_progress(running=False)
        self._motion.stopj(self._doubles(0, 1)[0])
        return urscript.wait_until_done(self._box)

    def teach_mode(self) -> None:
        """Let the arm be led by hand."""
        self._box.arm.release()

    def freedrive(self) -> None:
        """Let the arm be led by hand; along some axes only is not emulated."""
        if not all(self._integer(axis) for axis in range(1, 7)):
            raise UnsupportedCommandError("freedrive along some axes only is not emulated")
        self._box.arm.release()

    def end_freedrive(self) -> Program:
        """Stay where the arm was led."""
        self._box.hold()
        return urscript.wait_until_done(self._box)

    def get_freedrive_status(self) -> None:
        """Answer that freedrive is possible: emulated joints are backdrivable in any posture."""
        self._write(RESULT, 0)

    def set_payload(self) -> None:
        """Declare a payload: mass and centre of mass."""
        mass, *center = self._doubles(0, 4)
        self._declare(mass, center, np.zeros(6))

    def set_target_payload(self) -> None:
        """Declare a payload: mass, centre of mass and inertia."""
        mass, *center = self._doubles(0, 4)
        self._declare(mass, center, self._doubles(4, 6))

    def _declare(self, mass: float, center: list[float], inertia: np.ndarray) -> None:
        payload = Payload(mass=mass, center_of_mass=tuple(center), inertia=tuple(inertia))
        self._box.arm.declare(payload if mass else None)

    def zero_force(self) -> None:
        """Zero the wrist sensor."""
        self._box.zero_force()

    def protective_stop(self) -> None:
        """Stop the arm."""
        self._box.protective_stop("commanded by the program")

    def set_watchdog(self) -> None:
        """Stop the program when the client stops writing."""
        least = self._doubles(0, 1)[0]
        name = f"input_int_register_{self._offset}"
        self._box.watchdog = Watchdog(name, least, self._box.time)

    def is_within_limits(self) -> None:
        """Answer whether joint angles are within the limits."""
        limits = self._box.arm.rig.robot.position_limits()
        self._write(RESULT, bool((np.abs(self._doubles(0, 6)) <= limits).all()))

    def is_steady(self) -> None:
        """Answer whether the arm is at rest."""
        self._write(RESULT, not self._motion.moving)

    def get_step_time(self) -> None:
        """Answer the cycle [s]."""
        self._answer(np.array([self._box.cycle]))

    def get_joint_torques(self) -> None:
        """Answer the torques of the joints [Nm]."""
        self._answer(np.asarray(self._box.outputs["actual_current_as_torque"]))

    def get_pose(self) -> None:
        """Answer the pose of the flange, which is that of the tool."""
        self._answer(np.asarray(self._box.outputs["actual_TCP_pose"]))

    def get_tool_offset(self) -> None:
        """Answer the pose of the tool in the flange's frame."""
        self._answer(np.zeros(6))


Handler = Callable[[ControlScript], Program | None]

REALTIME = (9, 11, 26, 38, 58)
HANDLERS: dict[int, Handler] = {
    0: ControlScript.nothing,
    1: ControlScript.move_j,
    8: ControlScript.zero_force,
    9: ControlScript.speed_j,
    11: ControlScript.servo_j,
    15: ControlScript.stop_motion,  # speedStop
    16: ControlScript.stop_motion,  # servoStop
    17: ControlScript.set_payload,
    18: ControlScript.teach_mode,
    19: ControlScript.end_freedrive,  # endTeachMode
    26: ControlScript.get_step_time,
    29: ControlScript.nothing,  # setTcp
    31: ControlScript.protective_stop,
    33: ControlScript.stop_motion,  # stopL
    34: ControlScript.stop_motion,  # stopJ
    35: ControlScript.set_watchdog,
    37: ControlScript.is_within_limits,
    38: ControlScript.get_joint_torques,
    40: ControlScript.get_tool_offset,
    43: ControlScript.get_pose,
    45: ControlScript.move_path,
    47: ControlScript.is_steady,
    52: ControlScript.freedrive,
    53: ControlScript.end_freedrive,
    54: ControlScript.get_freedrive_status,
    58: ControlScript.get_pose,
    65: ControlScript.set_target_payload,
}
