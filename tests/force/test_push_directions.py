"""The push by direction: at which postures, and how large."""

import numpy as np
import pytest

from tests.tried_pushes import EYE, PERIOD
from ur5lib.force.push_directions import (
    ANGLES,
    PLANES,
    POSTURES,
    Needed,
    Place,
    motion_at,
    push_directions,
)
from ur5lib.force.trial_contacts import Untouched, unit_along
from ur5lib.records.pushes import PushDirection
from ur5lib.timeseries.arrays import Array

UNITS = np.array([2.0, 5.0, 10.0])  # N, along x, y, z
NEEDED = {"slow": Needed(4.0, 0.5), "fast": Needed(6.0, 1.0)}


def place(reach: float, units: Array = UNITS, motion: str = "slow") -> Place:
    """A place whose axes are worth so much, with the flange so far away on x."""
    flange = reach * np.eye(3)[0]
    return Place("free", reach, np.zeros(6), flange, motion, np.diag(units**-2.0))


PLACES = [place(reach) for reach in (0.5, 0.3, 0.9, 0.2, 0.6)]


def stated(places: list[Place], felt: float = 100.0, most: float = 100.0) -> list[PushDirection]:
    return [*push_directions(places, NEEDED, felt, most)]


def test_along_an_axis_it_is_that_of_the_axis_and_between_them_on_an_ellipse() -> None:
    rows = stated(PLACES)
    assert len(rows) == len(POSTURES) * len(PLANES) * len(ANGLES)
    for row in rows:
        ends = UNITS[[*PLANES[row.plane]]]
        angle = np.radians(row.angle_deg)
        ellipse = np.hypot(np.cos(angle) / ends[0], np.sin(angle) / ends[1]) ** -1
        assert row.unit == pytest.approx(ellipse)
        assert row.value == pytest.approx(4.0 * ellipse)
        assert row.std_error == pytest.approx(0.5 * ellipse)


def test_what_is_not_felt_or_beyond_the_trials_has_a_gap() -> None:
    unfelt = [place(one.time, np.array([2.0, np.inf, 10.0])) for one in PLACES]
    up = [row for row in stated(unfelt) if row.angle_deg == 90.0]
    assert {row.value for row in up if row.plane == "horizontal"} == {None}
    assert {row.unit for row in up if row.plane == "horizontal"} == {None}
    assert [row.value for row in up if row.plane == "vertical"] == pytest.approx([40.0] * 4)
    for felt, most in ((19.0, 100.0), (100.0, 39.0)):
        gaps = {(row.plane, row.angle_deg) for row in stated(PLACES, felt, most) if not row.value}
        assert {("vertical", 90.0), ("vertical", 270.0)} <= gaps
        assert not any(plane == "horizontal" for plane, _ in gaps)


def test_each_posture_is_the_extreme_one_that_its_name_says() -> None:
    """Of motions in which trials determine a push."""
    others = [place(0.4, 0.1 * UNITS), place(0.45, 3 * UNITS), place(2.0, 9 * UNITS, "at rest")]
    rows = stated(PLACES + others)
    found = {row.posture: row.time_s for row in rows}
    assert found == {"stretched out": 0.9, "folded": 0.2, "easiest": 0.4, "hardest": 0.45}
    assert stated(others) == []


def test_the_unit_of_a_place_is_that_of_all_joints() -> None:
    """(Σ J² / S)^-½, on average over the samples of the place."""
    random = np.random.default_rng(0)
    jacobian, hiding = random.normal(size=(50, 6, 6)), random.uniform(1, 2, (50, 6))
    run = Untouched(jacobian, np.zeros(50), PERIOD, [], hiding)
    units = unit_along(run.information((10, 40)), np.eye(3))
    for axis, unit in enumerate(units):
        felt = (jacobian[10:40, axis] ** 2 / hiding[10:40]).sum(axis=1).mean()
        assert unit == pytest.approx(felt**-0.5)
    flat = Untouched(EYE[:50] * [1, 0, 1, 0, 0, 0], np.zeros(50), PERIOD, [], hiding)
    assert unit_along(flat.information((0, 50)), np.eye(3)[1]) == np.inf


def test_a_motion_begins_at_its_speed() -> None:
    found = [motion_at(speed) for speed in (0.0, 0.01, 0.2, 0.25, 3.0)]
    assert found == ["at rest", "slow", "slow", "fast", "fast"]
