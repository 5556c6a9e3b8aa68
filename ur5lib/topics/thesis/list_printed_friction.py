"""The printed motor constants and friction of an arm, to compare with the fitted ones."""

from ur5lib.records.friction import Friction
from ur5lib.robots.description import Robot
from ur5lib.topics.thesis.rows import PrintedFriction, printed_friction


def list_printed_friction(friction: Friction, arm: Robot) -> list[PrintedFriction]:
    """Return what the arm's description has of the parameters that were fitted."""
    return [*printed_friction(friction, arm)]
