"""Straight-line programs in URScript: motion commands one after the other.

Source: Universal Robots' script manual, module motion. Loops, conditions and variables are not
emulated; a program that needs them ends with a message in the robot's log.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ur5lab.doubles.control_box import (
    PROGRAM_END_DECELERATION,
    ControlBox,
    Program,
    UnsupportedCommandError,
)
from ur5lib.robots.urscript import (
    MOVE_ARGUMENTS,
    Command,
    ToolPose,
    calls,
    parse,
    six,
    speed_and_acceleration,
)
from ur5lib.timeseries.arrays import Array

# rad; least travel of a move with a duration, which defines its speed.
MIN_WAY = 1e-9  # rad


def program(lines: Sequence[str], box: ControlBox) -> Program:
    """Execute a program's commands; yield once per cycle while they last.

    Raises UnsupportedCommandError at the first line that is not emulated.
    """
    for _, text in calls(lines):
        try:
            command = parse(text)
        except ValueError as error:
            raise UnsupportedCommandError(f"`{text[:60]}` is not emulated") from error
        if any(isinstance(value, ToolPose) for value in [*command.values, *command.named.values()]):
            raise UnsupportedCommandError(f"`{text[:60]}` is not emulated")
        yield from _execute(command, box)


def wait_until_done(box: ControlBox) -> Program:
    """Yield once per cycle until the motion has ended."""
    while box.arm.motion.moving:
        yield


def end_freedrive(box: ControlBox) -> Program:
    """End freedrive where the arm was guided; yield once per cycle until it rests."""
    box.arm.motion.stopj(PROGRAM_END_DECELERATION)
    yield from wait_until_done(box)


def _execute(command: Command, box: ControlBox) -> Program:
    """Execute a command that takes time; yield once per cycle while it lasts."""
    motion = box.arm.motion
    match command.name:
        case "movej":
            q, a, v, t, _ = command.arguments(**MOVE_ARGUMENTS["movej"])
            goal = _joint_values(q)
            if t:
                way = float(np.abs(goal - motion.q).max()) or MIN_WAY
                v, a = speed_and_acceleration(way, t)
            motion.movej(goal, v, a)
            yield from wait_until_done(box)
        case "servoj":
            defaults = {"q": None, "a": 0, "v": 0, "t": 0.002, "lookahead_time": 0.1, "gain": 300}
            q, _, _, t, lookahead, _ = command.arguments(**defaults)
            motion.servoj(_joint_values(q), lookahead)
            yield from _wait(t, box)
        case "speedj":
            qd, a, t = command.arguments(qd=None, a=1.4, t=0)
            motion.speedj(_joint_values(qd), a)
            yield from _wait(t, box)
        case "stopj":
            motion.stopj(*command.arguments(a=2.0))
            yield from wait_until_done(box)
        case "end_freedrive_mode" | "end_teach_mode":
            yield from end_freedrive(box)
        case "sleep":
            yield from _wait(command.arguments(t=0.01)[0], box)
        case _:
            _set(command, box)
            yield


def _set(command: Command, box: ControlBox) -> None:
    """Execute a command that ends at once."""
    match command.name:
        case "freedrive_mode" | "teach_mode":
            axes, _ = command.arguments(freeAxes=(1, 1, 1, 1, 1, 1), feature=None)
            if not all(axes):
                raise UnsupportedCommandError("freedrive along some axes only is not emulated")
            box.arm.release()
        case "set_payload":
            box.arm.declare(*command.arguments(m=0.0, cog=(0.0, 0.0, 0.0)))
        case "textmsg":
            box.say("".join(map(str, command.values)))
        case "protective_stop":
            box.protective_stop("commanded by the program")
        case "zero_ftsensor":
            box.zero_force()
        case "write_output_integer_register":
            register, value = command.arguments(address=0, value=0)
            box.registers[f"output_int_register_{register}"] = value
        case "signal_async_progress" | "sync":
            pass
        case _:
            raise UnsupportedCommandError(f"{command.name}() is not emulated")


def _joint_values(values: Any) -> Array:
    """Return six joint values. Raises UnsupportedCommandError for anything else."""
    try:
        return six(values)
    except ValueError as error:
        raise UnsupportedCommandError(f"{values!r} instead of six joint values") from error


def _wait(seconds: float, box: ControlBox) -> Program:
    """Yield once per cycle for some seconds, at least once."""
    for _ in range(max(1, round(seconds / box.cycle))):
        yield
