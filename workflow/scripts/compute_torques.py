"""Joint torques of every link model: at the targets and at the measured motion."""

from typing import Any

from ur5lib.pipeline.carried import carried, disagreements, load_account
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.torques import joint_torques
from ur5lib.recordings.stop_signs import stop_signs
from ur5lib.robots.description import Payload, load_robot
from ur5lib.tables import read_table, write_json


def compute_torques(input: Any, output: Any, params: Any) -> None:
    table, motion = read_table(input.signals), Motion.read(input.motion)
    signals = Signals.from_table(table)
    declared = Payload.model_validate_json(params.payload) if params.payload else None
    load = carried(declared, signals)
    robot = load_robot(input.arm).mounted(params.gravity)
    joint_torques(robot, load, signals, motion).write(output.torques)
    fitted = params.role == "fit"
    signs = stop_signs(table, robot, load.told, load.payload, fitted)
    doubts = disagreements(declared, params.tcp or None, signals)
    write_json(load_account(load, doubts) | {"stop_signs": signs}, output.summary)
