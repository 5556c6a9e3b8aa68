"""Which terms of friction recordings show that no fit has seen, and how much of it they show."""

from dataclasses import replace

import numpy as np
import pytest

from tests.current_study import CONSTANT, make_record, prior, smooth
from ur5lib.force.external_torque import JointState
from ur5lib.force.force_input import ForceInput, Gears
from ur5lib.force.shown_friction import MIN_MOTION, shown_friction
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.samples import CurrentSamples, held_columns
from ur5lib.identification.selection import is_less
from ur5lib.robots.friction import FITTED_TERMS, friction_columns
from ur5lib.timeseries.arrays import Array

SLOW = 0.03  # rad/s


def with_more(
    records: int, current: Array, term: str = "", distance: float = 0.0
) -> list[CurrentSamples]:
    """Recordings with noise and with more friction (6,) [A]: of a term, or held over a distance."""
    study = []
    for seed in range(records):
        record = make_record(seed)
        motions = [record.joint(joint) for joint in range(6)]
        more = [
            friction_columns(own, [term])[:, 0] if term else held_columns(own, [distance])[:, 1]
            for own in motions
        ]
        noise = 0.02 * np.random.default_rng(seed).normal(size=record.current.shape)
        added = current * np.stack(more, axis=1) + noise
        study.append(replace(record, current=record.current + added))
    return study


def test_the_root_of_velocity_comes_back() -> None:
    true = 3.0 / CONSTANT
    fit = fit_currents(with_more(6, true, "velocity_root"), smooth, prior())
    assert fit.joints[0].terms == FITTED_TERMS
    found = [joint.estimate.coefficients[-1] for joint in fit.joints]
    np.testing.assert_allclose(found, true, rtol=0.1)


def test_the_square_of_velocity_is_added_where_an_arm_has_it() -> None:
    for size, added in ((0.0, ()), (-3.0, ("velocity_square",))):
        fit = fit_currents(with_more(6, size / CONSTANT, "velocity_square"), smooth, prior())
        assert {joint.terms for joint in fit.joints} == {(*FITTED_TERMS, *added)}


def test_stribeck_friction_is_added_where_paths_show_it() -> None:
    """With three widths it is wrong elsewhere by one path: there, it is not tried."""
    for records, size, added in ((6, 3.0, True), (6, 0.0, False), (1, 3.0, False)):
        study = with_more(records, size / CONSTANT, "velocity_stribeck")
        fit = fit_currents(study, smooth, prior())
        assert {"velocity_stribeck" in joint.terms for joint in fit.joints} == {added}


def test_what_gains_in_motion_and_loses_at_rest_is_no_stribeck_friction() -> None:
    """Fits without a stop would state friction at rest that is twice what the arm has."""
    study = with_more(6, 6.0 / CONSTANT, "velocity_stribeck")
    without = with_more(6, 0.0 / CONSTANT, "velocity_stribeck")
    slow = [np.abs(record.qd) < SLOW for record in study]
    mixed = [
        replace(record, current=np.where(rests, other.current, record.current))
        for record, other, rests in zip(study, without, slow, strict=True)
    ]
    fit = fit_currents(mixed, smooth, prior())
    assert not any("velocity_stribeck" in joint.terms for joint in fit.joints)


@pytest.mark.parametrize("distance", [1e-5, 1e-3])
def test_friction_at_rest_reverses_over_the_distance_that_it_has(distance: float) -> None:
    """And over the usual one alone where nothing shows another."""
    true = 6.0 / CONSTANT
    fit = fit_currents(with_more(6, true, distance=distance), smooth, prior())
    assert {joint.distances for joint in fit.joints} == {(distance,)}
    found = np.array([joint.held[1] for joint in fit.joints])
    assert (np.abs(found - true) < 0.5 * true).all()
    usual = fit_currents(with_more(6, 0 * true, distance=distance), smooth, prior())
    assert {joint.distances for joint in usual.joints} == {()}


def test_less_is_surely_less() -> None:
    """By a share, by standard errors over what is left out, and not by two of it alone."""
    errors, noise = np.ones(6), np.exp(0.2 * np.array([1, -1, 1, -1, 1, -1]))
    assert is_less(0.9 * errors, errors, 0.02, 2.0)
    assert not is_less(0.99 * errors, errors, 0.02, 2.0)
    assert not is_less(0.9 * noise, errors, 0.02, 2.0)
    assert not is_less(0.5 * errors[:2], errors[:2], 0.02, 2.0)


PERIOD = 0.01  # s


def led(share: float, moving: int) -> tuple[ForceInput, Array]:
    """A motion in which the motors overcome a share of the friction, while a hand does the rest,
    and the breakaway torques; moving: samples of joint 3, the others stop, and show anything.
    """
    random = np.random.default_rng(0)
    friction, breakaway = random.normal(size=(400, 6)), np.geomspace(1.0, 50.0, 6)
    friction *= breakaway
    states = np.full((400, 6), JointState.RESTING, np.int8)
    states[:moving, 2] = JointState.MOVING
    moves = states == JointState.MOVING
    torque = np.where(moves, (1 - share) * friction, 7 * friction)
    q, segment = np.zeros((400, 6)), np.zeros(400, np.int64)
    gears = Gears(0 * friction, 0 * friction, friction)
    return ForceInput(q, q, torque, states, segment, PERIOD, gears=gears), breakaway


@pytest.mark.parametrize("share", [1.0, 0.55, 0.0])
def test_motors_show_the_share_of_friction_that_they_overcome(share: float) -> None:
    run, breakaway = led(share, moving=300)
    assert shown_friction(run, breakaway) == pytest.approx(share, abs=1e-12)
    both = replace(run, states=run.states.copy(), torque=run.torque.copy())
    both.states[:300, 5] = JointState.MOVING  # of which the motor overcomes all
    both.torque[:300, 5] = 0.0
    weights = [((run.gears.friction[:300, k] / breakaway[k]) ** 2).sum() for k in (2, 5)]
    expected = (share * weights[0] + weights[1]) / sum(weights)
    assert shown_friction(both, breakaway) == pytest.approx(expected, abs=1e-12)


def test_a_moment_of_motion_shows_no_share() -> None:
    enough = round(MIN_MOTION / PERIOD)
    for moving, known in ((0, False), (enough, False), (enough + 1, True)):
        assert np.isfinite(shown_friction(*led(0.5, moving))) == known
    run, breakaway = led(0.5, 300)
    assert np.isnan(shown_friction(replace(run, gears=None), breakaway))
    run.torque[100:] = np.nan
    assert np.isnan(shown_friction(run, breakaway))
