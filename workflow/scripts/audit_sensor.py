"""What is wrong with the force sensor in the arm's wrist."""

from typing import Any

from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.sensor_audit import audit
from ur5lib.robots.description import Payload, load_robot
from ur5lib.tables import read_json, write_json


def audit_sensor(input: Any, output: Any, params: Any) -> None:
    signals, kinematics = Signals.read(input.signals), Kinematics.read(input.kinematics)
    robot = load_robot(input.arm).mounted(params.gravity)
    known, load = read_json(input.load), read_json(input.currents).get("load")
    own = "force" not in read_json(input.quality)["starts"]  # not of a file of its own
    summary: dict[str, Any] = {}
    stopped = read_json(input.contradictions)["stop_signs"]
    if own and signals.force_sensor is not None and not stopped:
        tool = Payload(**known["payload"]) if known["payload"] else None
        summary = audit(robot, signals, kinematics, Motion.read(input.motion), tool, load)
    write_json(summary, output.audit)
