"""Joint torques of every link model: at the targets and at the measured motion."""

from typing import Any

from ur5lib.pipeline.carried import carried, disagreements, load_account
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.torques import joint_torques
from ur5lib.recordings.stop_signs import CHECKED, stop_signs
from ur5lib.robots.description import Payload, load_robot
from ur5lib.tables import column_names, read_table, write_json


def compute_torques(input: Any, output: Any, params: Any) -> None:
    signals, motion = Signals.read(input.signals), Motion.read(input.motion)
    declared = Payload.model_validate_json(params.payload) if params.payload else None
    load = carried(declared, signals)
    robot = load_robot(input.arm).mounted(params.gravity)
    table = read_table(input.signals, [*CHECKED.intersection(column_names(input.signals))])
    signs = stop_signs(table, robot, load.told, load.payload, params.role == "fit")
    del table
    joint_torques(robot, load, signals, motion).write(output.torques)
    doubts = disagreements(declared, params.tcp or None, signals)
    write_json(load_account(load, doubts) | {"stop_signs": signs}, output.summary)
