"""The controller's own estimate of the contact wrench, F^u."""

from ur5lib.records.forces import FurtherForces
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


def environment_on_arm(stated: Array) -> Array:
    """Return the wrench (N, 6) of the environment on the arm: -F^u.

    A controller states F^u = J^-T (tau_motor - tau_model), the arm on its environment. The sign is
    reversed here and nowhere else.
    """
    return -stated


def controller_estimate(robot: Robot, signals: Signals) -> dict[str, Array]:
    """Return {"Fu": (N, 6) [N, Nm]}, the controller's estimate as the environment acting on the
    arm; empty if it was not recorded.

    Without a wrist sensor, the controller states the arm acting on its environment.
    """
    if signals.actual_TCP_force is None:
        return {}
    stated = signals.actual_TCP_force
    return {"Fu": stated if robot.wrist_sensor else environment_on_arm(stated)}


def further_or_controller(
    further: FurtherForces | None, robot: Robot, signals: Signals, withheld: bool = False
) -> FurtherForces:
    """Return a topic's force estimates, else the controller's; none if `further` is None and the
    controller's are withheld.
    """
    if further is not None:
        return further
    stated = {} if withheld else controller_estimate(robot, signals)
    return FurtherForces(
        time=signals.time, segment=signals.segment, printed=stated, corrected=stated
    )
