"""The printed motor constants and friction of an arm, to compare with the fitted ones."""

from ur5lib.records.friction import Friction
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.topics.thesis.rows import PrintedFriction, printed_friction


@step("arm", "rows=printed_friction.csv", arm="described")
def list_printed_friction(friction: Friction, arm: Robot) -> list[PrintedFriction]:
    """Return the printed values of the fitted parameters, of those for which the arm's description
    has one.
    """
    return [*printed_friction(friction, arm)]
