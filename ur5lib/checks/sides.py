"""Whether a description has the side of the gears on which the arm's torques are measured."""

from ur5lib.robots.description import Robot


def unknown_side(arm: Robot) -> str:
    """Return why nothing can be fitted to torques that may be those of motors or of joints; empty
    if the description decides it.

    The links are then found from the same torques, and the description has neither the side nor a
    weight that would contradict it.
    """
    if arm.effort != "torque" or arm.links == "known" or arm.weight is not None:
        return ""
    return (
        f"the links of {arm.name} are found from torques that may be those of its motors or of its "
        "joints; write `effort: joint_torque`, or `effort: motor_torque` with each `gear_ratio`, "
        "into its description, or its `weight`"
    )
