"""Figures of one recording, after the thesis's 4.4, 5.11, 5.12, 5.14, 5.15 and 6.4."""

from ur5lib.records.accelerations import Accelerations
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.scene import Scene
from ur5lib.records.signals import Signals
from ur5lib.report.figures import recording_figures as figures
from ur5lib.report.figures.house_style import Drawing
from ur5lib.report.figures.scene import arm_scene
from ur5lib.robots.description import Robot


def draw_figures(
    signals: Signals,
    torques: Torques,
    accelerations: Accelerations,
    currents: Currents,
    kinematics: Kinematics,
    sensor: SensorWrenches,
    forces: Forces,
    arm: Robot,
    threshold: dict[str, float],
    role: str,
    min_singular_value: float,
    lowpass: tuple[int, float],
    gravity: list[float] | None = None,
) -> dict[str, Drawing | Scene]:
    """Return the figures of a recording, and the arm in motion for a closer look.

    threshold: of alarms, by estimate; role: of the recording; min_singular_value: below it, no
    force is determined; lowpass: of currents, order and cut-off [Hz]; gravity: see `Robot.mounted`.
    """
    hidden = kinematics.smallest_singular_value < min_singular_value
    beside = forces, sensor, hidden
    # each figure reads its signals anew, so that none keeps those of another in memory
    return {
        "packets": figures.packet_figure(signals.anew()),
        "torques": figures.torque_figure(signals.anew(), torques, arm),
        "currents": figures.effort_figure(signals.anew(), currents, arm.measured, lowpass),
        "accelerations": figures.acceleration_figure(accelerations),
        "forces_estimated": figures.estimate_figure(*beside),
        "moments_estimated": figures.estimate_figure(*beside, moments=True),
        "scene": arm_scene(
            arm.mounted(gravity), signals.anew(), currents, forces, sensor, threshold, role
        ),
    }
