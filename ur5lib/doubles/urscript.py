"""Straight-line programs in URScript: motion commands one after the other.

Source: Universal Robots' script manual, module motion. Loops, conditions and variables are not
emulated; a program that needs them ends with a message in the robot's log.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ur5lib.doubles.control_box import ENDING, ControlBox, Program, UnsupportedCommandError
from ur5lib.robots.urscript import Command, ToolPose, calls, parse, six
from ur5lib.timeseries.arrays import Array


def program(lines: Sequence[str], box: ControlBox) -> Program:
    """Yield once per cycle while the commands of a program are executed.

    Raises UnsupportedCommandError at the first line that is not emulated.
    """
    for _, text in calls(lines):
        command = _plain(text)
        if command.name not in COMMANDS:
            raise UnsupportedCommandError(f"{command.name}() is not emulated")
        yield from COMMANDS[command.name](command, box) or wait(0, box)


def _plain(line: str) -> Command:
    """Return the command in a line, if it is a plain call without poses."""
    try:
        command = parse(line)
    except ValueError as error:
        raise UnsupportedCommandError(f"`{line[:60]}` is not emulated") from error
    if any(isinstance(value, ToolPose) for value in [*command.values, *command.named.values()]):
        raise UnsupportedCommandError(f"`{line[:60]}` is not emulated")
    return command


def joints(values: Any) -> Array:
    """Return six joint values. Raises UnsupportedCommandError for anything else."""
    try:
        return six(values)
    except ValueError as error:
        raise UnsupportedCommandError(f"{values!r} instead of six joint values") from error


def wait_until_done(box: ControlBox) -> Program:
    """Yield once per cycle until the motion has ended."""
    while box.arm.motion.moving:
        yield


def wait(seconds: float, box: ControlBox) -> Program:
    """Yield once per cycle for some seconds, at least once."""
    for _ in range(max(1, round(seconds / box.cycle))):
        yield


def _movej(command: Command, box: ControlBox) -> Program:
    q, a, v, t, _ = command.arguments(q=None, a=1.4, v=1.05, t=0, r=0)
    goal = joints(q)
    if t:  # the duration wins over speed and acceleration; half of it accelerates
        way = float(np.abs(goal - box.arm.motion.q).max()) or 1e-9
        v, a = 2 * way / t, 4 * way / t**2
    box.arm.motion.movej(goal, v, a)
    return wait_until_done(box)


def _servoj(command: Command, box: ControlBox) -> Program:
    q, _, _, t, lookahead, _ = command.arguments(
        q=None, a=0, v=0, t=0.002, lookahead_time=0.1, gain=300
    )
    box.arm.motion.servoj(joints(q), lookahead)
    return wait(t, box)


def _speedj(command: Command, box: ControlBox) -> Program:
    qd, a, t = command.arguments(qd=None, a=1.4, t=0)
    box.arm.motion.speedj(joints(qd), a)
    return wait(t, box)


def _stopj(command: Command, box: ControlBox) -> Program:
    box.arm.motion.stopj(*command.arguments(a=2.0))
    return wait_until_done(box)


def _freedrive(command: Command, box: ControlBox) -> None:
    axes, _ = command.arguments(freeAxes=(1, 1, 1, 1, 1, 1), feature=None)
    if not all(axes):
        raise UnsupportedCommandError("freedrive along some axes only is not emulated")
    box.arm.release()


def end_freedrive(box: ControlBox) -> Program:
    """Stay where the arm was led; yield once per cycle until it rests."""
    box.arm.motion.stopj(ENDING)
    return wait_until_done(box)


def _write_integer(command: Command, box: ControlBox) -> None:
    register, value = command.arguments(address=0, value=0)
    box.registers[f"output_int_register_{register}"] = value


COMMANDS: dict[str, Callable[[Command, ControlBox], Program | None]] = {
    "movej": _movej,
    "servoj": _servoj,
    "speedj": _speedj,
    "stopj": _stopj,
    "sleep": lambda command, box: wait(command.arguments(t=0.01)[0], box),
    "freedrive_mode": _freedrive,
    "end_freedrive_mode": lambda _, box: end_freedrive(box),
    "teach_mode": _freedrive,
    "end_teach_mode": lambda _, box: end_freedrive(box),
    "set_payload": lambda command, box: box.arm.declare(
        *command.arguments(m=0.0, cog=(0.0, 0.0, 0.0))
    ),
    "textmsg": lambda command, box: box.say("".join(map(str, command.values))),
    "protective_stop": lambda _, box: box.protective_stop("commanded by the program"),
    "zero_ftsensor": lambda _, box: box.zero_force(),
    "write_output_integer_register": _write_integer,
    "signal_async_progress": lambda _, __: None,
    "sync": lambda _, __: None,
}
