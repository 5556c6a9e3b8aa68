"""F̂ᵐᵃᵖ in forty lines, on a push whose size is known."""

from dataclasses import replace

import numpy as np
import pytest

from tests.rivals.synthetic_run import COUNT, PERIOD, synthetic_run
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimators.forty_lines import learn
from ur5rivals.run import Run

TIME = PERIOD * np.arange(COUNT)
PUSHED = (TIME > 9) & (TIME < 11)
FORCE = np.array([20.0, -30.0, 10.0])


def pushed(noise: float) -> Run:
    """A push of two seconds above a background that stays."""
    run = synthetic_run(0)
    torque = np.einsum("nij,i->nj", run.jacobian[:, :3], FORCE) * PUSHED[:, None]
    drift = np.array([3.0, -2.0, 1.0, 0.5, 0.2, 0.1])
    error = noise * np.random.default_rng(1).normal(size=torque.shape)
    return replace(run, smoothed=torque + drift + error)


def free(seed: int) -> Run:
    error = 0.5 * np.random.default_rng(seed).normal(size=(COUNT, 6))
    return replace(synthetic_run(seed), smoothed=error)


@pytest.fixture(scope="module")
def found() -> tuple[Array, Array]:
    own = learn([free(seed) for seed in range(2, 5)]).method(pushed(0.5))
    assert own is not None
    assert own.std is not None
    return own.wrench, own.std


def test_the_push_is_found_in_its_time_alone(found: tuple[Array, Array]) -> None:
    wrench, _ = found
    mean = np.median(wrench[PUSHED, :3], axis=0)
    assert mean == pytest.approx(FORCE, rel=0.2, abs=1.0)
    assert not wrench[(TIME < 8) | (TIME > 12)].any()


def test_its_band_holds_the_force(found: tuple[Array, Array]) -> None:
    wrench, std = found
    inside = np.abs(wrench[PUSHED, :3] - FORCE) <= 1.96 * std[PUSHED, :3]
    assert inside.mean() > 0.9


def test_what_is_unknown_stays_unknown() -> None:
    run = pushed(0.5)
    run.smoothed[100:110] = np.nan
    own = learn([free(seed) for seed in range(2, 5)]).method(run)
    assert own is not None
    assert np.flatnonzero(np.isnan(own.wrench).any(axis=1)).tolist() == [*range(100, 110)]
