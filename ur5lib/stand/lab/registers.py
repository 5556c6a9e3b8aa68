"""The general-purpose registers of a controller, shared by programs and RTDE's clients."""

from collections.abc import Iterator

import numpy as np

from ur5lib.robots.rtde_variables import REGISTERS
from ur5lib.timeseries.arrays import Array


class Registers:
    """48 integers and 48 doubles to the controller, and as many from it, by their RTDE names."""

    def __init__(self) -> None:
        self.values: dict[str, float] = {}
        for direction in ("input", "output"):
            for k in range(REGISTERS):
                self.values[f"{direction}_int_register_{k}"] = 0
                self.values[f"{direction}_double_register_{k}"] = 0.0

    def integer(self, k: int) -> int:
        """Return an integer that a client has written."""
        return int(self.values[f"input_int_register_{k}"])

    def doubles(self, first: int, count: int) -> Array:
        """Return doubles that a client has written (count,)."""
        return np.array([self.values[f"input_double_register_{first + k}"] for k in range(count)])

    def write_integer(self, k: int, value: int) -> None:
        """Write an integer that clients read."""
        self.values[f"output_int_register_{k}"] = value

    def write_doubles(self, first: int, values: Iterator[float]) -> None:
        """Write doubles that clients read, from a register on."""
        for k, value in enumerate(values, first):
            self.values[f"output_double_register_{k}"] = float(value)
