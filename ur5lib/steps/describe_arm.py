"""The description of one individual arm: with its own numbers, name and calibration."""

from pathlib import Path

from ur5lib.records.step import step
from ur5lib.robots.description import robot_path, robot_yaml
from ur5lib.robots.individual import individual_robot


@step("arm", "described.yaml", arm="type", calibration="calibration_file")
def describe_arm(
    arm: str,
    robot: str,
    override: dict[str, object],
    description: list[Path],
    calibration: list[Path],
) -> str:
    """Return an arm's description as YAML.

    arm: its type; robot: its name in the study; override: the study's own numbers; description: its
    file, if the library has none; calibration: file of the controller's, if any.
    """
    file = description[0] if description else robot_path(arm)
    calibrated = str(calibration[0]) if calibration else None
    return robot_yaml(individual_robot(file, robot, override, calibrated))
