"""The description of an arm, with the numbers, the name and the calibration that are its own."""

import json
from typing import Any

from ur5lib.robots.description import robot_path, robot_yaml
from ur5lib.robots.individual import individual_robot
from ur5lib.tables import write_text


def describe_arm(input: Any, output: Any, params: Any) -> None:
    calibration = input.calibration or None
    override = json.loads(params.override)
    [description] = input.description or [robot_path(params.arm)]
    robot = individual_robot(description, params.robot, override, calibration)
    write_text(robot_yaml(robot), output.arm)
