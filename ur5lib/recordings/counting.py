"""From what a controller counts to the channels of the arm's joints."""

import pandas as pd

from ur5lib.channels import MEASURED_CURRENT, SIGNED_CHANNELS
from ur5lib.errors import InputError
from ur5lib.recordings.entries import Files
from ur5lib.robots.description import Robot
from ur5lib.robots.drives import of_the_joints
from ur5lib.tables import channel, named


def counted_as(recording: Files, arm: Robot) -> Robot:
    """Return an arm with the zeros and directions of its joints as a recording states them, else
    the arm's own.

    Raises InputError where it does not state a value for each joint.
    """
    stated = {"home_deg": recording.home_deg, "directions": recording.directions}
    given = {key: tuple(values) for key, values in stated.items() if values is not None}
    for key, values in given.items():
        if len(values) != len(arm.joints):
            raise InputError(
                f"`{key}` in the study has {len(values)} entries for {recording.path}, but "
                f"{arm.name} has {len(arm.joints)} joints; give one for each joint"
            )
    return arm.model_copy(update={"drives": arm.drives.model_copy(update=given)})


def at_the_joints(table: pd.DataFrame, arm: Robot) -> pd.DataFrame:
    """Return a table with the controller's positions, rates and torques converted to those of the
    arm's joints, by their directions, zeros and couplings. Of currents, only the sign changes.

    Raises InputError for currents of coupled motors, which belong to no single joint.
    """
    if not arm.is_counted():
        return table
    if arm.drives.coupling and f"{MEASURED_CURRENT}_0" in table:
        raise InputError(
            f"the motors of {arm.name} are coupled, so that no current belongs to one joint; log "
            "their torques instead (actual_torque, `effort: motor_torque` of the arm), or leave "
            "actual_current out"
        )
    counts = {
        name: channel(table, name, len(arm.joints))
        for name in SIGNED_CHANNELS
        if {f"{name}_{joint}" for joint in range(len(arm.joints))} <= {*table}
    }
    columns = [named(of_the_joints(name, values, arm), name) for name, values in counts.items()]
    return table.assign(**{name: values for part in columns for name, values in part.items()})
