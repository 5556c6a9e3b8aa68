"""Currents of a recording that has only the torques that a driver computed from them."""

import numpy as np
import pandas as pd

from ur5lib.recordings.quality import Finding
from ur5lib.robots.description import Robot
from ur5lib.tables import channel, named

TORQUE, CURRENT = "actual_current_as_torque", "actual_current"


def with_currents(table: pd.DataFrame, arm: Robot, findings: list[Finding]) -> pd.DataFrame:
    """Return a table with currents [A] where it has only motor torques [Nm].

    They are divided by the torque constants of the arm's joints. A fit of friction finds the
    constants anew, so that errors of these cancel where currents become torques again.
    """
    if f"{TORQUE}_5" not in table or f"{CURRENT}_0" in table:
        return table
    constants = np.array(arm.maker_torque_constants())
    if np.isnan(constants).any():
        unknown = {"arm": arm.name}
        findings.append(Finding("robot", "no currents", "warning", len(table), unknown))
        return table
    known = {"constants": constants.tolist(), "arm": arm.name}
    findings.append(Finding("robot", "currents from torques", "note", len(table), known))
    return table.assign(**named(channel(table, TORQUE) / constants, CURRENT))
