"""Torques less gravity get it again, with the declared payload's; their numbers tell them."""

import numpy as np
import pandas as pd
import pytest

from tests.checks.test_commanded import CONSTANTS, arm, motion
from ur5lib.recordings.intake import with_efforts
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import channel, named

__all__ = ["arm"]  # a fixture
LOAD = Payload(mass=2.0, center_of_mass=(0.0, 0.0, 0.08))


@pytest.mark.parametrize("name", ["actual_torque_less_gravity", "actual_current_as_torque"])
@pytest.mark.parametrize("payload", [None, LOAD])
def test_the_currents_are_those_of_the_whole_torque(
    arm: Robot, name: str, payload: Payload | None
) -> None:
    table, _, rubbing = motion(arm)
    loaded = arm.carrying(payload)
    gravity = gravity_torque(loaded, loaded.chosen_model, channel(table, "actual_q"))
    findings: list[Finding] = []
    found = with_efforts(table.assign(**named(rubbing, name)), arm, findings, payload)
    currents = channel(found, "actual_current")
    np.testing.assert_allclose(currents, (gravity + rubbing) / CONSTANTS, rtol=0.01, atol=1e-6)
    codes = {one.code for one in findings}
    assert Found.GRAVITY_ADDED in codes
    assert (Found.LESS_GRAVITY in codes) is (name == "actual_current_as_torque")


def codes_of(arm: Robot, table: pd.DataFrame, torque: np.ndarray) -> set[str]:
    findings: list[Finding] = []
    with_efforts(table.assign(**named(torque, "actual_current_as_torque")), arm, findings)
    return {one.code for one in findings}


def test_a_torque_with_gravity_and_an_exchanged_one_stay_what_they_are(arm: Robot) -> None:
    table, gravity, rubbing = motion(arm)
    whole = gravity + rubbing
    for torque in (
        whole,
        0.5 * whole,
        whole[:, [5, 4, 3, 2, 1, 0]],
        rubbing[:, [5, 4, 3, 2, 1, 0]],
    ):
        assert Found.LESS_GRAVITY not in codes_of(arm, table, torque)
