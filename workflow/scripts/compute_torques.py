"""Joint torques of every link model: at the targets and at the measured motion."""

from typing import Any

from ur5lib.pipeline.carried import carried
from ur5lib.pipeline.torques import joint_torques
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, load_robot
from ur5lib.tables import write_json


def compute_torques(input: Any, output: Any, params: Any) -> None:
    signals, motion = Signals.read(input.signals), Motion.read(input.motion)
    declared = Payload.model_validate_json(params.payload) if params.payload else None
    load = carried(declared, signals)
    robot = load_robot(input.arm).mounted(params.gravity)
    joint_torques(robot, load, signals, motion).write(output.torques)
    write_json(load, output.summary)
