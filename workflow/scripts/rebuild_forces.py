"""Contact wrench from motor currents, as the thesis printed it, and by its equations put right;
its torque constants, rebuilt.
"""

from typing import Any

from ur5lib.pipeline.published_constants import current_torque, published_constants
from ur5lib.pipeline.published_forces import published_forces
from ur5lib.recordings.quality import Contradictions
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import PublishedForces
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_json
from ur5lib.timeseries.lowpass import Butterworth


def rebuild_forces(input: Any, output: Any, params: Any) -> None:
    signals, motion = Signals.read(input.signals), Motion.read(input.motion)
    torques, jacobian = Torques.read(input.torques), Kinematics.read(input.kinematics).jacobian
    settings = Butterworth(params.order, params.cutoff_hz), params.min_singular_value
    robot = load_robot(input.arm)
    forces = PublishedForces(time=signals.time, segment=signals.segment)
    stopped = read_record(Contradictions, input.contradictions).stop_signs
    if not stopped and not read_record(Friction, input.friction).stopped:
        forces = published_forces(robot, signals, motion, torques, jacobian, *settings)
    forces.write(output.forces)
    write_json(published_constants(current_torque(robot, signals, torques)), output.constants)
