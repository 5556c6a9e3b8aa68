"""What is stated while the gate is shut, on made-up torques of an arm at rest and in motion."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_up_torques import MODEL, free_run
from ur5lib.force.while_shut import usual_limits
from ur5lib.force.wrench_estimate import WrenchEstimate
from ur5lib.records.forces import Forces
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Mask
from ur5lib.timeseries.metrics import NORMAL95

WAYS = [way / np.linalg.norm(way) for way in np.random.default_rng(5).normal(size=(4, 3))]
PRESS = 25.0  # N


def test_limits_are_medians_where_no_contact_is_found() -> None:
    """Of the largest axis; nothing is told without such samples."""
    time, shut = np.arange(5.0), np.array([True, True, True, False, True])
    limit = np.array([[1.0, 2.0, 3.0], [9.0, 4.0, 4.0], [5.0, 5.0, 5.0], [0, 0, 0], [np.nan] * 3])
    known = {name: k * limit for k, name in enumerate(("untouched", "hidden", "hidden_at_all"), 1)}
    forces = Forces(time=time, segment=np.zeros(5, int), if_untouched=shut, **known)
    assert usual_limits(forces) == {"untouched_n": 5.0, "hidden_n": 10.0, "hidden_at_all_n": 15.0}
    assert usual_limits(replace(forces, if_untouched=np.zeros(5, bool))) == {}


def shut(estimate: WrenchEstimate) -> Mask:
    return (estimate.wrench == 0).all(axis=1)


def band(estimate: WrenchEstimate) -> np.ndarray:
    return NORMAL95 * estimate.std[:, :3]


@pytest.mark.parametrize("moving", [True, False], ids=["moving", "resting"])
def test_the_statements_are_ordered(ur5: Robot, moving: bool) -> None:
    """In motion, and in contacts, the band if untouched is the band; in these, none is hidden."""
    run = free_run(ur5, seed=30, moving=moving)
    force = 60.0 * ((run.time > 10) & (run.time < 12))[:, None] * np.eye(3)[2]
    estimate = run.pushed(run.wrench(force)).estimate()
    free = shut(estimate)
    assert 0.05 < (~free).mean() < 0.5
    same = moving | ~free
    np.testing.assert_allclose(estimate.untouched[same], band(estimate)[same])
    assert (estimate.untouched <= band(estimate) + 1e-9).all()
    assert (estimate.hidden[~free] == 0).all()
    assert (estimate.hidden[free] > 0).all()
    assert (estimate.hidden_at_all >= estimate.hidden).all()
    if moving:
        np.testing.assert_array_equal(estimate.hidden, estimate.hidden_at_all)


@pytest.mark.parametrize("way", WAYS)
def test_a_slow_press_is_in_the_band_or_what_may_be_hidden(ur5: Robot, way: np.ndarray) -> None:
    run = free_run(ur5, seed=31, moving=False)
    force = PRESS * np.clip((run.time - 5) / 3, 0, 1)[:, None] * way
    estimate = run.pushed(run.wrench(force)).estimate()
    error = np.abs(force - estimate.wrench[:, :3])
    held = (error <= np.maximum(band(estimate), estimate.hidden))[run.time > 6]
    assert held.mean() > 0.9


def test_what_presses_since_before_a_rest_widens_what_may_be_hidden_at_all_alone(
    ur5: Robot,
) -> None:
    """The bands of this rest are those of the same rest without it."""
    run = free_run(ur5, seed=32, moving=False)
    force = np.tile(PRESS * WAYS[0], (len(run.time), 1))
    alone, own = run.estimate(), run.pushed(run.wrench(force)).estimate()
    assert shut(own).all()
    for name in ("untouched", "hidden"):
        np.testing.assert_allclose(getattr(own, name), getattr(alone, name), rtol=0.25)
    np.testing.assert_allclose(own.std, alone.std, rtol=0.25)
    assert own.hidden_at_all.mean() > 1.2 * alone.hidden_at_all.mean()
    assert (np.abs(force) <= own.hidden_at_all).mean() > 0.75


def test_a_short_rest_has_no_beginning_to_compare_with(ur5: Robot) -> None:
    """What presses all of it may be hidden as what began before."""
    runs = [free_run(ur5, seed=34, seconds=own, moving=False) for own in (1.9, 20.0)]
    short, long = (
        run.pushed(run.wrench(np.tile(PRESS * WAYS[1], (len(run.time), 1)))).estimate()
        for run in runs
    )
    assert shut(short).all()
    np.testing.assert_allclose(short.hidden, short.hidden_at_all)
    assert long.hidden.mean() < 0.8 * long.hidden_at_all.mean()


def test_a_force_is_averaged_longer_where_few_paths_were_fitted(ur5: Robot) -> None:
    """Peaks are told of the force before."""
    run = free_run(ur5, seed=33, moving=False)
    force = 60.0 * ((run.time > 10) & (run.time < 13))[:, None] * np.eye(3)[2]
    touched, inner = run.pushed(run.wrench(force)), (run.time > 10.5) & (run.time < 12.5)
    many, few = (touched.estimate(model=replace(MODEL, doubt=doubt)) for doubt in (1.0, 1.0 + 1e-9))

    def rough(values: np.ndarray) -> float:
        return float(np.abs(np.diff(values[inner, 2], n=2)).mean())

    assert rough(few.wrench) < 0.9 * rough(many.wrench)
    assert rough(many.wrench) < rough(many.unsmoothed)
    np.testing.assert_allclose(few.unsmoothed, many.unsmoothed, rtol=1e-5, atol=1e-6)
