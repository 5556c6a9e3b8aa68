"""The controller's own estimate of the contact wrench, which published ones stand beside."""

from ur5lib.records.forces import PublishedForces
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


def environment_on_arm(published: Array) -> Array:
    """Return the wrench (N, 6) of the environment on the arm, from one of the thesis or F^u.

    The thesis's wrenches and the controller's F^u are J^-T (tau_motor - tau_model), the arm acting
    on its environment. Their sign is reversed here and nowhere else.
    """
    return -published


def controller_estimate(robot: Robot, signals: Signals) -> dict[str, Array]:
    """Return the controller's own F^u, the environment acting on the arm, where it was recorded.

    Without a wrist sensor, the controller states the arm acting on its environment.
    """
    if signals.actual_TCP_force is None:
        return {}
    stated = signals.actual_TCP_force
    return {"Fu": stated if robot.wrist_sensor else environment_on_arm(stated)}


def published_or_controller(
    published: PublishedForces | None, robot: Robot, signals: Signals, withheld: bool = False
) -> PublishedForces:
    """Return the published estimates, in a study without published values the controller's alone;
    none where they are withheld.
    """
    if published is not None:
        return published
    stated = {} if withheld else controller_estimate(robot, signals)
    return PublishedForces(
        time=signals.time, segment=signals.segment, printed=stated, corrected=stated
    )
