"""Straight-line URScript: one call with plain numbers in every line.

Source: Universal Robots' script manual. Loops, conditions and variables are not supported.
"""

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.errors import InputError
from ur5lib.strict import expect_file
from ur5lib.timeseries.arrays import Array

FRAMING_STARTS = ("def ", "sec ", "end", "global ")  # starts of lines without a command
MOVE_ARGUMENTS: dict[str, dict[str, float | None]] = {  # their defaults are URScript's, in SI units
    "movej": {"q": None, "a": 1.4, "v": 1.05, "t": 0.0, "r": 0.0},
    "movel": {"pose": None, "a": 1.2, "v": 0.25, "t": 0.0, "r": 0.0},
}


@dataclass(frozen=True)
class ToolPose:
    """A pose `p[x, y, z, rx, ry, rz]` in the base frame: position [m], rotation vector [rad]."""

    values: tuple[float, ...]


Value = float | Sequence[float] | ToolPose


@dataclass(frozen=True)
class Command:
    """A call of URScript: its name, its arguments in order and by name."""

    name: str
    values: tuple[Value, ...]
    named: dict[str, Value]

    def arguments(self, **defaults: Any) -> list[Any]:
        """Return the arguments in the order of `defaults`, which replace missing ones.

        Raises ValueError for arguments that are not among `defaults`.
        """
        unknown = [name for name in self.named if name not in defaults]
        if unknown or len(self.values) > len(defaults):
            raise ValueError(f"arguments of {self.name}")
        arguments = dict(zip(defaults, self.values, strict=False)) | self.named
        return [arguments.get(name, default) for name, default in defaults.items()]


def calls(lines: Sequence[str]) -> Iterator[tuple[int, str]]:
    """Yield the lines with commands, without comments, and their numbers from 1."""
    for number, line in enumerate(lines, start=1):
        text = line.split("#")[0].strip()
        if text and not text.startswith(FRAMING_STARTS):
            yield number, text


def read_calls(path: Path, content: str) -> list[tuple[int, str]]:
    """Return the lines of a file with commands, and their numbers.

    content: of the file, for messages. Raises InputError where the file is no text.
    """
    expect_file(path)
    try:
        return [*calls(path.read_text(encoding="utf-8").splitlines())]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path} cannot be read ({error}); give a text file of {content}"
        ) from error


def parse(line: str) -> Command:
    """Return the command in a line. Raises ValueError when it is not a plain call."""
    try:
        call = ast.parse(line, mode="eval").body
        if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name):
            raise ValueError(f"{line!r} is no call")
        named = {str(word.arg): _value(word.value) for word in call.keywords}
        return Command(call.func.id, tuple(map(_value, call.args)), named)
    except (SyntaxError, TypeError, RecursionError, MemoryError) as error:
        raise ValueError(f"{line!r} is no plain call") from error


def speed_and_acceleration(way: float, seconds: float) -> tuple[float, float]:
    """Return speed and acceleration of a move by its duration `t`, which overrides both.

    way: [rad] or [m]; the arm accelerates for half of the time.
    """
    return 2 * way / seconds, 4 * way / seconds**2


def six(values: Any) -> Array:
    """Return six finite numbers (6,). Raises ValueError for anything else."""
    try:
        numbers = np.array(values, np.float64)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.shape != (6,) or not np.isfinite(numbers).all():
        raise ValueError(f"{values!r} instead of six numbers")
    return numbers


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Subscript) and ast.unparse(node.value) == "p":
        return ToolPose(tuple(six(ast.literal_eval(node.slice)).tolist()))
    return ast.literal_eval(node)
