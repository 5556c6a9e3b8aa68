"""The speeds at which friction is predicted."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.made_records import motion_of, stretch
from tests.made_tables import gathered, record
from tests.rubbing_arm import friction, robot
from ur5lib.identification.currents import torque_constants
from ur5lib.identification.validation import SPEED_BINS
from ur5lib.records.currents import Currents
from ur5lib.records.friction import CurrentFit
from ur5lib.topics.observability.measure_observability import Judged, at_rest, judged, observability
from ur5lib.topics.observability.rows import Observed


def test_the_worth_of_the_band_at_rest() -> None:
    """Of a joint, 95 % of the errors at rest lie within half of its band, and all in it."""
    speed = np.tile([0.0, 0.3], 1000)[:, None]
    of_band = np.where(speed == 0.0, np.linspace(0.0, 0.5 / 0.95, 2000)[:, None], 3.0)
    found = [*observability([Judged(speed, of_band)])]
    assert [r.value for r in found if r.quantity == "friction_in_band" and r.speed_low == 0] == [1]
    (factor,) = (row for row in found if row.quantity == "rest_band_factor")
    assert factor.value == pytest.approx(0.5, abs=0.001)
    assert factor.samples == 1000
    moving = Judged(speed[1::2], of_band[1::2])
    assert not any(row.quantity.startswith("rest_") for row in observability([moving]))


def shares(folder: Path) -> pd.DataFrame:
    """Observed shares of an arm whose joint 3 is predicted from 0.2 rad/s on, others throughout."""
    speed = np.tile(np.repeat(SPEED_BINS[:-1] + 1e-4, 50)[:, None], 6)
    inside = np.ones_like(speed)
    inside[speed[:, 2] < 0.2, 2] = 0.0
    return gathered(Observed, [*observability([Judged(speed, 2 - inside)])], folder)


def test_the_table_has_each_joint(tmp_path: Path) -> None:
    table = shares(tmp_path)
    assert {*table["robot"]} == {"ur5"}
    least = table[table["quantity"] == "least_velocity"].set_index("joint")["value"]
    assert least.to_dict() == {1: 0.0, 2: 0.0, 3: 0.2, 4: 0.0, 5: 0.0, 6: 0.0}
    assert (table["quantity"] == "friction_in_band").sum() == 6 * 9


def test_errors_are_within_the_band_that_is_stated_at_their_speed() -> None:
    """Not within that of motion, 0.1 A, at rest, where a wider one is stated."""
    fit = friction(robot()).fit
    time = 0.1 * np.arange(100)
    resting = (time < 5)[:, None] * np.ones(6)
    own = Currents(
        **stretch(time),
        current_band=0.1 + 0.4 * resting,
        external_torque=0.3 * torque_constants(fit) * np.ones((100, 6)),
    )
    found = judged(motion_of(time, 0 * resting, 1 - resting), own, fit)
    np.testing.assert_array_equal(found.of_band <= 1, resting)
    np.testing.assert_array_equal(found.speed, 1 - resting)


def test_the_band_at_rest_is_told_beside_that_of_motion() -> None:
    joints = [{"band_moving": 0.1, "band_standing": wide} for wide in (0.4, 0.2)]
    found = [*at_rest(record(CurrentFit, {"joints": joints}))]
    assert [(row.joint, row.value) for row in found] == [(1, 4.0), (2, 2.0)]
