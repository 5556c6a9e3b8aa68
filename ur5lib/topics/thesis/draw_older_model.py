"""The closed loop with the gains of the thesis's older model [21], after Figures 5.1 to 5.4."""

from pathlib import Path

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.records.carried import configured_payload
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.thesis import figure as figures
from ur5lib.topics.thesis.records import ClosedLoop
from ur5lib.topics.thesis.reference import OLDER_MODEL, Published, read_reference


@step(
    "recording",
    "positions_older.svg velocities_older.svg torques_older.svg",
    recording="name",
)
def draw_older_model(
    recording: str, signals: Signals, closed_loop: ClosedLoop, arm: Robot, reference: Path
) -> dict[str, Drawing]:
    """Return by name the figures of positions, velocities and torques of a recording in the older
    model's closed loop.
    """
    published = Published(read_reference(reference).printed, recording)
    printed = published.values("torque_mae")[OLDER_MODEL]
    modelled = torques(signals, closed_loop, arm) if OLDER_MODEL in closed_loop.q else {}
    return {
        "positions_older": figures.tracking_figure(signals, closed_loop, OLDER_MODEL, "q"),
        "velocities_older": figures.tracking_figure(signals, closed_loop, OLDER_MODEL, "qd"),
        "torques_older": figures.older_torque_figure(signals, modelled, printed),
    }


def torques(signals: Signals, closed_loop: ClosedLoop, robot: Robot) -> dict[str, Array]:
    """Return the chosen model's torque (N, 6) [Nm] at the motion of the older model's loop, with
    gravity and without, which the thesis found missing in the older model.
    """
    q, qd, qdd = (getattr(closed_loop, name)[OLDER_MODEL] for name in ("q", "qd", "qdd"))
    model = LinkModel(robot.carrying(configured_payload(signals)), robot.chosen_model)
    name = f"Model {robot.chosen_model}"
    torque = model.inverse_dynamics(q, qd, qdd)
    return {name: torque, f"{name} without gravity": torque - model.gravity_torque(q)}
