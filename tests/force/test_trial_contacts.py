"""Trial pushes: which are tried, what the motors feel of them, and which are found."""

import numpy as np
import pytest

from tests.made_up_torques import MODEL
from tests.tried_pushes import detected_above, is_resting
from ur5lib.force.external_torque import JointState
from ur5lib.force.force_input import Gears
from ur5lib.force.trial_contacts import (
    PAUSE_DURATION,
    PUSH_DURATION,
    TRIAL_SIZES,
    Untouched,
    felt_push,
    pushes_at_each_place,
    smallest_force,
)


def test_a_push_is_found_from_the_limit_of_its_place_on() -> None:
    """At rest from 40 N on, in motion from 10 N on; none is tried during the recording's alarm."""
    trials = detected_above(np.where(is_resting(), 40.0, 10.0))
    assert len(trials.force) == 89
    assert trials.force.min() == pytest.approx(15.0 * TRIAL_SIZES[0], rel=0.06)
    assert trials.force.max() == pytest.approx(15.0 * TRIAL_SIZES[1])
    for low, high, limit in ((0.0, 0.1, 40.0), (0.5, 1.0, 10.0)):
        part = trials.within(low, high)
        assert len(part.force) > 30
        np.testing.assert_array_equal(part.found, part.force > limit)
        assert smallest_force(part.force, part.found)[0] == pytest.approx(limit, rel=0.4)


@pytest.mark.parametrize("state", [JointState.MOVING, JointState.STILL])
def test_dry_friction_and_gears_bear_their_part_of_a_push(state: int) -> None:
    """In motion what load friction takes, at rest at most the share of the breakaway torque."""
    torque = np.tile([0.5, -2.0, 8.0, -30.0, 1.0, 0.0], (2000, 1))
    gears = Gears(*(np.full_like(torque, value) for value in (50.0, 0.2, 0.0)))
    time, most = np.arange(2000) * (PUSH_DURATION + PAUSE_DURATION), 0.45 * MODEL.breakaway
    known = np.full(torque.shape, state, np.int8), gears, most, np.random.default_rng(0)
    felt = felt_push(torque, time, *known)
    if state == JointState.MOVING:
        np.testing.assert_allclose(gears.contact_torque(felt)[0], torque)
    else:
        bears = np.sign(torque) * (torque - felt)
        assert (bears >= 0).all()
        assert (bears <= np.minimum(most, np.abs(torque))).all()
        assert bears[:, 3].mean() == pytest.approx(most[3] / 2, rel=0.03)
        twice = felt_push(torque, time // 2, *known)  # two samples of each push
        np.testing.assert_array_equal(twice[::2], twice[1::2])


def test_without_a_place_nothing_is_tried() -> None:
    jacobian = np.broadcast_to(np.eye(6), (50, 6, 6))
    run = Untouched(jacobian, np.zeros(50), 0.01, [], np.ones((50, 6)))
    random = np.random.default_rng(0)
    trials = pushes_at_each_place(run, random, 15.0).tried(run, [])
    assert len(trials.force) == len(trials.found) == 0


def test_a_recording_of_few_places_is_tried_with_all_sizes() -> None:
    """Before, one with two places a round had the smallest and the largest alone."""
    count = 890
    jacobian = np.broadcast_to(np.eye(6), (count, 6, 6))
    run = Untouched(jacobian, np.zeros(count), 0.01, [], np.ones((count, 6)))
    random = np.random.default_rng(0)
    rounds = [pushes_at_each_place(run, random, 15.0, later / 20) for later in range(20)]
    assert {len(own.force) for own in rounds} == {2}
    force = np.log(np.sort(np.concatenate([own.force for own in rounds])) / 15.0)
    np.testing.assert_allclose(force, np.linspace(*np.log(TRIAL_SIZES), 41)[1:])
