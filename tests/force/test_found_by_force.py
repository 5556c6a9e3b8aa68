"""The share of pushes found, by their force: the curve that a figure draws of pushes.csv."""

import numpy as np
import pytest

from ur5lib.force.smallest_pushes import detectable, found_by_force
from ur5lib.force.trial_contacts import Trials
from ur5lib.records.pushes import PushesFound
from ur5lib.timeseries.arrays import Array

MOST = 105.0  # N


@pytest.fixture(scope="module")
def trials() -> Trials:
    """6000 pushes along x at places of other levers, in slow and fast motion, by a detector of
    which the odds grow as the fourth power of the force; in fast motion, it needs thrice the force.
    """
    random = np.random.default_rng(0)
    force = random.permutation(np.geomspace(1.25, MOST, 6000))
    unit, fast = np.exp(random.normal(0.0, 0.4, 6000)), np.arange(6000) % 2
    found = random.random(6000) < 1 / (1 + (force / (4 * 3**fast * unit)) ** -4)
    speed = np.where(fast, 0.6, 0.1)
    return Trials(force, np.zeros(6000, np.int64), speed, found, unit)


def curves(trials: Trials, *motions: str) -> dict[str, tuple[Array, Array]]:
    """Forces and shares by motion."""
    rows: list[PushesFound] = [*found_by_force(trials, {*motions}, MOST)]
    return {
        name: (
            np.array([row.force for row in rows if row.motion == name]),
            np.array([row.share for row in rows if row.motion == name]),
        )
        for name in {row.motion for row in rows}
    }


def test_the_curve_is_the_share_of_pushes_that_were_found(trials: Trials) -> None:
    """Counted among the pushes of about that force."""
    found = curves(trials, "slow", "fast")
    assert {*found} == {"slow", "fast"}
    for name, (forces, shares) in found.items():
        own = trials.where((trials.speed > 0.3) == (name == "fast"))
        for force, share in zip(forces[2:-2], shares[2:-2], strict=True):
            about = np.abs(np.log(own.force / force)) < 0.15
            assert share == pytest.approx(own.found[about].mean(), abs=0.1)


def test_the_curve_passes_95_of_100_at_the_smallest_push(trials: Trials) -> None:
    for name, (forces, shares) in curves(trials, "slow", "fast").items():
        own = trials.where((trials.speed > 0.3) == (name == "fast"))
        limit = detectable(own, np.inf)
        assert np.interp(limit.value, forces, shares) == pytest.approx(0.95, abs=2e-3)


def test_the_curve_goes_from_the_smallest_push_to_the_largest_trial(trials: Trials) -> None:
    """In even ratios, for the motions that are asked for."""
    ((name, (forces, shares)),) = curves(trials, "fast").items()
    assert name == "fast"
    np.testing.assert_allclose(forces[[0, -1]], [trials.force.min(), MOST])
    np.testing.assert_allclose(np.diff(np.log(forces)), np.log(forces[1] / forces[0]))
    assert (np.diff(shares) > 0).all()
