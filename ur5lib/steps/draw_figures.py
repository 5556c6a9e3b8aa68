"""Figures of one recording, after the thesis's 4.4, 5.11, 5.12, 5.14, 5.15 and 6.4."""

from ur5lib.records.accelerations import Accelerations
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.opened import Opened
from ur5lib.records.scene import Scene
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.report.figures import recording_figures as figures
from ur5lib.report.figures.house_style import Drawing
from ur5lib.report.figures.scene import arm_scene
from ur5lib.robots.description import Robot


class Inputs(Opened):
    """What is read of a recording."""

    role: str
    gravity: list[float] | None
    kinematics: Kinematics
    signals: Signals
    torques: Torques
    currents: Currents
    forces: Forces
    accelerations: Accelerations
    sensor: SensorWrenches


@step(
    "recording",
    "packets.svg torques.svg currents.svg accelerations.svg forces_estimated.svg "
    "moments_estimated.svg scene.json",
    recordings="illustrated",
)
def draw_figures(
    recording: Inputs,
    arm: Robot,
    threshold: dict[str, float],
    min_singular_value: float,
    lowpass: tuple[int, float],
) -> dict[str, Drawing | Scene]:
    """Return the figures of a recording, and the arm in motion for a closer look.

    threshold: of alarms, by estimate; min_singular_value: below it, no force is determined;
    lowpass: of currents, order and cut-off [Hz].
    """
    signals, currents = recording.signals, recording.currents
    forces, sensor = recording.forces, recording.sensor
    hidden = recording.kinematics.smallest_singular_value < min_singular_value
    beside = forces, sensor, hidden
    # each figure reads its signals again, so that none stay in memory
    return {
        "packets": figures.packet_figure(signals.anew()),
        "torques": figures.torque_figure(signals.anew(), recording.torques, arm),
        "currents": figures.effort_figure(signals.anew(), currents, arm.measured, lowpass),
        "accelerations": figures.acceleration_figure(recording.accelerations),
        "forces_estimated": figures.estimate_figure(*beside),
        "moments_estimated": figures.estimate_figure(*beside, moments=True),
        "scene": arm_scene(recording, arm.mounted(recording.gravity), threshold),
    }
