"""Programs that clients send to the controller, and ur_rtde's control script, executed natively.

A program is one line, or all lines from `def` to `end`; a new one replaces the one that runs.
RTDEControlInterface uploads a program in URScript (`rtde_control.script` of its sources) and talks
with it by registers: input integer 0 is the command, further inputs are its arguments; output
integer 0 is 1 for "ready" and 2 for "command done", which the client acknowledges by command 0.
Realtime commands are executed in every cycle and need no acknowledgement.
"""

import re
from asyncio import StreamReader
from collections.abc import Callable

import numpy as np

from ur5lib.doubles import urscript
from ur5lib.doubles.control_box import ControlBox, Program, UnsupportedCommandError, Watchdog
from ur5lib.timeseries.arrays import Array

NAME = "def rtde_control()"
OFFSET = re.compile(r"# int register offset\n(\d+)")
PATH = re.compile(r"# inject move path\n(.*?)\n    end", re.DOTALL)

COMMAND, ASYNCHRONOUS = 0, 1  # input integers
STATE, RESULT, PROGRESS = 0, 1, 2  # output integers
READY, DONE = 1, 2
STOP_SCRIPT = 255
RUNNING, COUNT, OPERATION = 1 << 15, 1 << 16, 1 << 24  # in the register of progress
COUNTED = 128  # counts and operations are counted modulo this


async def run_programs(box: ControlBox, reader: StreamReader) -> None:
    """Start every complete program of a client until it hangs up."""
    while line := await _line(reader):
        text = line
        if re.match(r"(def|sec)\s", line):
            while line and not line.startswith("end"):
                line = await _line(reader)
                text += line
        if NAME in text and line:
            box.run(ControlScript(text, box).run())
        elif line and text.strip():
            box.run(urscript.program(text.splitlines(), box))


async def _line(reader: StreamReader) -> str:
    """Return the next line, empty at the end; the last line may lack its end."""
    return (await reader.readline()).decode("utf-8", "replace")


class ControlScript:
    """The state of ur_rtde's control script on one controller."""

    def __init__(self, text: str, box: ControlBox) -> None:
        """text: the program as uploaded, with the client's insertions."""
        self.box, self._motion = box, box.arm.motion
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
        yield from HANDLERS[command](self) or ()

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
        return int(self.box.registers[f"input_int_register_{k + self._offset}"])

    def _doubles(self, first: int, count: int) -> Array:
        names = (f"input_double_register_{first + k + self._offset}" for k in range(count))
        return np.array([self.box.registers[name] for name in names])

    def _write(self, k: int, value: int) -> None:
        self.box.registers[f"output_int_register_{k + self._offset}"] = value

    # The commands

    def move_j(self) -> Program | None:
        """Move to joint angles."""
        *goal, speed, acceleration = self._doubles(0, 8)
        self._motion.movej(np.array(goal), speed, acceleration)
        return self._start(urscript.wait_until_done(self.box))

    def move_path(self) -> Program | None:
        """Move along the path that the client has inserted; blends are not emulated."""
        return self._start(urscript.program(self._path, self.box))

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
        return urscript.wait_until_done(self.box)

    def freedrive(self) -> None:
        """Let the arm be led by hand; along some axes only is not emulated."""
        if not all(self._integer(axis) for axis in range(1, 7)):
            raise UnsupportedCommandError("freedrive along some axes only is not emulated")
        self.box.arm.release()

    def set_payload(self) -> None:
        """Declare a payload: mass and centre of mass."""
        mass, *center = self._doubles(0, 4)
        self.box.arm.declare(mass, center)

    def set_target_payload(self) -> None:
        """Declare a payload: mass, centre of mass and inertia."""
        mass, *rest = self._doubles(0, 10)
        self.box.arm.declare(mass, rest[:3], rest[3:])

    def set_watchdog(self) -> None:
        """Stop the program when the client stops writing."""
        name = f"input_int_register_{self._offset}"
        self.box.watchdog = Watchdog(name, 1 / self._doubles(0, 1)[0], self.box.time)

    def is_within_limits(self) -> None:
        """Answer whether joint angles are within the limits."""
        limits = [high for _, high in self.box.arm.rig.robot.position_limits()]
        self.write_result(bool((np.abs(self._doubles(0, 6)) <= limits).all()))

    def outputs(self, name: str) -> Array:
        """Return an output of the controller (6,)."""
        return np.asarray(self.box.outputs[name])

    def write_result(self, value: int) -> None:
        """Answer an integer."""
        self._write(RESULT, value)

    def answer(self, *values: float) -> None:
        """Answer doubles."""
        for k, value in enumerate(values, self._offset):
            self.box.registers[f"output_double_register_{k}"] = float(value)


Handler = Callable[[ControlScript], Program | None]

REALTIME = (9, 11, 26, 38, 58)
HANDLERS: dict[int, Handler] = {
    0: lambda _: None,
    1: ControlScript.move_j,
    8: lambda script: script.box.zero_force(),
    9: ControlScript.speed_j,
    11: ControlScript.servo_j,
    15: ControlScript.stop_motion,  # speedStop
    16: ControlScript.stop_motion,  # servoStop
    17: ControlScript.set_payload,
    18: lambda script: script.box.arm.release(),  # teachMode
    19: lambda script: urscript.end_freedrive(script.box),  # endTeachMode
    26: lambda script: script.answer(script.box.cycle),  # getStepTime
    29: lambda _: None,  # setTcp
    31: lambda script: script.box.protective_stop("commanded by the program"),
    33: ControlScript.stop_motion,  # stopL
    34: ControlScript.stop_motion,  # stopJ
    35: ControlScript.set_watchdog,
    37: ControlScript.is_within_limits,
    38: lambda script: script.answer(*script.outputs("actual_current_as_torque")),
    40: lambda script: script.answer(*np.zeros(6)),  # getTCPOffset
    43: lambda script: script.answer(*script.outputs("actual_TCP_pose")),
    45: ControlScript.move_path,
    47: lambda script: script.write_result(not script.box.arm.motion.moving),  # isSteady
    52: ControlScript.freedrive,
    53: lambda script: urscript.end_freedrive(script.box),
    54: lambda script: script.write_result(0),  # freedrive is possible in any posture
    58: lambda script: script.answer(*script.outputs("actual_TCP_pose")),
    65: ControlScript.set_target_payload,
}
