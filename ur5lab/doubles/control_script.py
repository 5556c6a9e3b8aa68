"""Programs that clients send to the controller, and ur_rtde's control script, executed natively.

A program is one line, or all lines from `def` to `end`; a new one replaces the one that runs.
RTDEControlInterface uploads a program in URScript (`rtde_control.script` of its sources) and talks
with it by registers: input integer 0 is the command, further inputs are its arguments; output
integer 0 is 1 for "ready" and 2 for "command done", which the client acknowledges by command 0.
Realtime commands are executed in every cycle and need no acknowledgement.
"""

import re
from asyncio import StreamReader

import numpy as np

from ur5lab.doubles import urscript_programs
from ur5lab.doubles.control_box import ControlBox, Program, UnsupportedCommandError, Watchdog
from ur5lib.timeseries.arrays import Array

CONTROL_SCRIPT_HEAD = "def rtde_control()"
OFFSET_PATTERN = re.compile(r"# int register offset\n(\d+)")
PATH_PATTERN = re.compile(r"# inject move path\n(.*?)\n    end", re.DOTALL)

COMMAND_REGISTER, ASYNCHRONOUS_REGISTER = 0, 1  # input integers
STATE_REGISTER, RESULT_REGISTER, PROGRESS_REGISTER = 0, 1, 2  # output integers
READY_STATE, DONE_STATE = 1, 2
STOP_COMMAND = 255
REALTIME_COMMANDS = (9, 11, 26, 38, 58)
# Parts of the progress register.
RUNNING_BIT, COUNT_UNIT, OPERATION_UNIT = 1 << 15, 1 << 16, 1 << 24
PROGRESS_MODULUS = 128  # counts and operations are counted modulo this


async def run_programs(box: ControlBox, reader: StreamReader) -> None:
    """Read a client's programs and start each when it is complete, until the client hangs up."""
    while line := await _line(reader):
        text = line
        if re.match(r"(def|sec)\s", line):
            while line and not line.startswith("end"):
                line = await _line(reader)
                text += line
        if CONTROL_SCRIPT_HEAD in text and line:
            box.run(ControlScript(text, box).run())
        elif line and text.strip():
            box.run(urscript_programs.program(text.splitlines(), box))


async def _line(reader: StreamReader) -> str:
    """Return the next line, empty at the end of the stream; the last line may lack its newline."""
    return (await reader.readline()).decode("utf-8", "replace")


class ControlScript:
    """ur_rtde's control script as it runs on one controller, executed natively."""

    def __init__(self, text: str, box: ControlBox) -> None:
        """Take a program; text: as uploaded, with the client's insertions."""
        self._box = box
        offset, path = OFFSET_PATTERN.search(text), PATH_PATTERN.search(text)
        self._offset = int(offset[1]) if offset else 0
        self._path = path[1].splitlines() if path else []
        self._moves: Program | None = None  # of an asynchronous command
        self._count = self._operation = 0

    def run(self) -> Program:
        """Yield once per cycle until the client stops the script."""
        self._signal_progress(running=False)
        acknowledged = True
        self._write(STATE_REGISTER, READY_STATE)
        while (command := self._integer(COMMAND_REGISTER)) != STOP_COMMAND:
            if command == 0 or command in REALTIME_COMMANDS:
                acknowledged = command == 0 or acknowledged
                yield from self._execute(command)
                self._write(STATE_REGISTER, READY_STATE)
            elif acknowledged:
                acknowledged = False
                yield from self._execute(command)
                self._write(STATE_REGISTER, DONE_STATE)
            if self._moves is not None and next(self._moves, "ended") == "ended":
                self._moves = None
                self._signal_progress(running=False)
            yield

    def _execute(self, command: int) -> Program:
        """Execute a command; yield once per cycle while it lasts."""
        box, motion = self._box, self._box.arm.motion
        match command:
            case 1:  # moveJ
                *goal, speed, acceleration = self._doubles(8)
                motion.movej(np.array(goal), speed, acceleration)
                yield from self._started(urscript_programs.wait_until_done(box))
            case 45:  # movePath; blends are not emulated
                yield from self._started(urscript_programs.program(self._path, box))
            case 9:  # speedJ
                *speeds, acceleration = self._doubles(7)
                motion.speedj(np.array(speeds), acceleration)
            case 11:  # servoJ
                motion.servoj(self._doubles(6), self._doubles(10)[9])
            case 15 | 16 | 33 | 34:  # speedStop, servoStop, stopL, stopJ
                self._moves = None
                self._signal_progress(running=False)
                motion.stopj(self._doubles(1)[0])
                yield from urscript_programs.wait_until_done(box)
            case 52 if not all(self._integer(axis) for axis in range(1, 7)):
                raise UnsupportedCommandError("freedrive along some axes only is not emulated")
            case 18 | 52:  # teachMode, freedriveMode
                box.arm.release()
            case 19 | 53:  # endTeachMode, endFreedriveMode
                yield from urscript_programs.end_freedrive(box)
            case _:
                self._set_or_answer(command)

    def _set_or_answer(self, command: int) -> None:
        """Execute a command that ends at once."""
        box = self._box
        match command:
            case 0 | 29:  # no command; setTcp
                pass
            case 8:  # zeroFtSensor
                box.zero_force()
            case 17:  # setPayload
                mass, *center = self._doubles(4)
                box.arm.declare(mass, center)
            case 65:  # setTargetPayload
                mass, *rest = self._doubles(10)
                box.arm.declare(mass, rest[:3], rest[3:])
            case 26:  # getStepTime
                self._answer(box.cycle)
            case 31:  # triggerProtectiveStop
                box.protective_stop("commanded by the program")
            case 35:  # setWatchdog
                name = f"input_int_register_{self._offset}"
                box.watchdog = Watchdog(name, 1 / self._doubles(1)[0], box.time)
            case 37:  # isJointsWithinSafetyLimits
                is_within = np.abs(self._doubles(6)) <= box.arm.position_limits
                self._write(RESULT_REGISTER, bool(is_within.all()))
            case 38:  # getJointTorques
                self._answer(*np.asarray(box.outputs["actual_current_as_torque"]))
            case 40:  # getTCPOffset
                self._answer(*np.zeros(6))
            case 43 | 58:  # getForwardKinematics, getActualToolFlangePose
                self._answer(*np.asarray(box.outputs["actual_TCP_pose"]))
            case 47:  # isSteady
                self._write(RESULT_REGISTER, not box.arm.motion.moving)
            case 54:  # getFreedriveStatus: possible in any posture
                self._write(RESULT_REGISTER, 0)
            case _:
                raise UnsupportedCommandError(f"command {command} of ur_rtde is not emulated")

    def _started(self, moves: Program) -> Program:
        """Yield once per cycle until moves have ended; if the command is asynchronous, only start
        them and return.
        """
        if not self._integer(ASYNCHRONOUS_REGISTER):
            self._moves = None
            yield from moves
            return
        self._operation = (self._operation + 1) % PROGRESS_MODULUS
        self._moves = moves
        next(moves, None)
        self._signal_progress(running=True)

    def _signal_progress(self, running: bool) -> None:
        self._count = (self._count + 1) % PROGRESS_MODULUS
        value = self._count * COUNT_UNIT + self._operation * OPERATION_UNIT + RUNNING_BIT * running
        self._write(PROGRESS_REGISTER, value)

    def _integer(self, k: int) -> int:
        return int(self._box.registers[f"input_int_register_{k + self._offset}"])

    def _doubles(self, count: int) -> Array:
        """Return the first `count` input registers of type double (count,)."""
        names = (f"input_double_register_{k + self._offset}" for k in range(count))
        return np.array([self._box.registers[name] for name in names])

    def _write(self, k: int, value: int) -> None:
        self._box.registers[f"output_int_register_{k + self._offset}"] = value

    def _answer(self, *values: float) -> None:
        for k, value in enumerate(values, self._offset):
            self._box.registers[f"output_double_register_{k}"] = float(value)
