"""The quantities that the panels of a figure show: of joints, or along and about x, y and z."""

from typing import NamedTuple

from ur5lib.channels import MOST_JOINTS


class Panel(NamedTuple):
    """The quantity of one of the six panels: in plain text, as mathematics, its unit."""

    name: str
    symbol: str
    unit: str


def joint_quantity(symbol: str, unit: str) -> list[Panel]:
    """Return a panel for each joint, for as many joints as an arm may have."""
    joints = range(1, MOST_JOINTS + 1)
    return [Panel(f"joint {joint}", f"{symbol}_{joint}", unit) for joint in joints]


def cartesian_quantity(linear: tuple[str, str, str], angular: tuple[str, str, str]) -> list[Panel]:
    """Return six panels, x, y, z linear and angular; linear, angular: name, symbol and unit."""
    return [
        Panel(f"{name}{axis}", f"{symbol}_{axis}", unit)
        for name, symbol, unit in (linear, angular)
        for axis in "xyz"
    ]
