"""The rigid-body model identified from the controller's torque, as a further model of the arm."""

from dataclasses import replace
from typing import Any

from ur5lib.errors import reason
from ur5lib.pipeline.identification import with_identified, with_rotors
from ur5lib.pipeline.torques import torque_blocks
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot, robot_yaml
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.tables import read_record, write_json, write_text
from ur5lib.timeseries.lowpass import Butterworth


def identify_model(input: Any, output: Any, params: Any) -> None:
    robot = with_rotors(load_robot(input.arm), read_record(Rotors, input.rotors))
    design = Butterworth(params.order, params.cutoff_hz)
    recordings = zip(params.recordings, params.gravities, input.signals, input.motion, strict=True)
    blocks = {
        name: [
            *torque_blocks(
                robot.mounted(gravity), Signals.read(signals), Motion.read(motion), design
            )
        ]
        for name, gravity, signals, motion in recordings
    }
    known = [block for part in blocks.values() for block in part]
    try:
        robot, found = with_identified(robot, params.gravities, known)
    except ValueError as error:  # too little was recorded, or nothing physical explains it
        found = Identification(refused=reason(error))
    name = "identified" if "identified" in robot.models else robot.chosen_model
    write_text(robot_yaml(robot), output.arm)
    write_text(urdf(robot, rigid_bodies(robot, name)), output.urdf)
    fitted_on = [name for name, part in blocks.items() if part]
    write_json(replace(found, from_=fitted_on), output.summary)
