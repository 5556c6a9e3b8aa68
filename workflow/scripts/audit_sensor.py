"""What is wrong with the force sensor in the arm's wrist."""

from typing import Any

from ur5lib.pipeline.carried import Carried
from ur5lib.pipeline.sensor_audit import audit
from ur5lib.recordings.quality import Contradictions, Quality
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.force_errors import Audit
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_json


def audit_sensor(input: Any, output: Any, params: Any) -> None:
    signals, kinematics = Signals.read(input.signals), Kinematics.read(input.kinematics)
    robot = load_robot(input.arm).mounted(params.gravity)
    tool = read_record(Carried, input.load).payload
    load = read_record(Prediction, input.currents).load
    own = "force" not in read_record(Quality, input.quality).starts  # not of a file of its own
    found = Audit()
    stopped = read_record(Contradictions, input.contradictions).stop_signs
    if own and signals.force_sensor is not None and not stopped:
        found = audit(robot, signals, kinematics, Motion.read(input.motion), tool, load)
    write_json(found, output.audit)
