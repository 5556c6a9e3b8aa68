"""`ur5 describe`: the description of an arm from its URDF."""

import re
from pathlib import Path

from ur5lib.errors import InputError, with_controls
from ur5lib.robots.description import PROJECT_FOLDER, robot_names, robot_yaml
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.tables import write_new_text


def describe_urdf(
    file: Path, base: str | None, tip: str | None, name: str | None, physical: bool = False
) -> list[str]:
    """Write an arm's description to `robots/`; return sentences about its content and assumptions.

    name: of the arm, None for that of the URDF; others: see `robot_from_urdf`. Raises InputError if
    the name is taken, and as `robot_from_urdf`.
    """
    robot, remarks = robot_from_urdf(file, base, tip, physical)
    name = name or robot.name
    if controls := with_controls([file.name, *remarks]):
        raise InputError(f"{file}: {controls!r} has a control character; give it another name")
    if not re.fullmatch(r"[\w-][\w.-]*", name, re.ASCII):
        raise InputError(f"{name!r} cannot name a file; letters, digits, `_`, `-` and dots can")
    if name in robot_names():
        raise InputError(f"an arm `{name}` is described already; give another name by --name")
    head = "".join(f"# {line}\n" for line in [f"From {file.name}. SI units.", *remarks])
    path = PROJECT_FOLDER / f"{name}.yaml"
    path.parent.mkdir(exist_ok=True)
    write_new_text(head + robot_yaml(robot.model_copy(update={"name": name})), path)
    joints = ", ".join(robot.joints)
    side = (
        f"which side are its torques on? The links': write `effort: joint_torque` into {path}; the "
        "motors': `effort: motor_torque`, and each `gear_ratio`"
    )
    return [*remarks, f"{path} written: {len(robot.joints)} joints ({joints})", side]
