"""Friction that varies as on real arms changes currents, and neither motion nor equation."""

import numpy as np

from tests.stand.test_stand import FOURIER, STILL, experiment, own_torques
from ur5lib.stand.rig import STEP
from ur5lib.stand.varied_friction import (
    DRIFT_STD,
    RELAXING_SHARE,
    RUN_STD,
    drift,
    held_at_stops,
    run_factors,
    varied_torque,
)


def test_the_arm_obeys_its_equation_with_it() -> None:
    motion = (done := experiment(friction=True, varied_friction=True)).motion
    given = motion["motor_torque"] - motion["friction_torque"]
    assert np.abs(own_torques(done) - given).max() < 1e-8


def test_it_adds_the_same_to_motor_and_friction() -> None:
    """At rest, where a run's own friction moves nothing: as without it, but for the torques."""
    one, other = (experiment(trajectory=STILL, varied_friction=varied) for varied in (False, True))
    for name in ("q", "qd", "wrench"):
        np.testing.assert_array_equal(one.motion[name], other.motion[name])
    more = other.motion["motor_torque"] - one.motion["motor_torque"]
    np.testing.assert_allclose(
        more, other.motion["friction_torque"] - one.motion["friction_torque"], atol=1e-12
    )
    assert np.abs(more).max() > 0.1  # of place


def test_a_joint_holds_another_torque_at_each_stop() -> None:
    """For 6 s, in which it relaxes by RELAXING_SHARE; none in motion."""
    stopped = np.tile(np.repeat([False, True], 6000)[:, None], (200, 1))
    held = held_at_stops(stopped, STEP, np.random.default_rng(0)).reshape(200, 12_000)
    assert not held[:, :6000].any()
    assert abs(held[:, 6000].std() - 1) < 0.1
    np.testing.assert_allclose(held[:, -1], (1 - RELAXING_SHARE) * held[:, 6000], rtol=0.05)


def test_rest_drifts_from_nothing_to_its_deviation() -> None:
    found = drift((60_000, 400), STEP, np.random.default_rng(0))
    assert found[0].std() < 0.01 * DRIFT_STD * 10
    assert abs(found[-1].std() / DRIFT_STD - 1) < 0.1


def test_in_motion_only_the_load_and_the_place_count() -> None:
    done = experiment(trajectory=FOURIER, friction=True)
    q, friction = done.motion["q"][:100], done.rig.friction
    fast, random = np.full(q.shape, 2.0), np.random.default_rng(0)
    assert np.abs(varied_torque(q, fast, 0 * q, friction, STEP, random)).max() < 1e-9
    one, twice = (varied_torque(q, fast, k + 0 * q, friction, STEP, random) for k in (10.0, 20.0))
    np.testing.assert_allclose(twice, 2 * one)


def test_a_recording_has_its_own_friction() -> None:
    factors = run_factors(4000, np.random.default_rng(0))
    assert abs(np.log(factors).std() / RUN_STD - 1) < 0.05
