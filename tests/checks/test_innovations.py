"""To whose motion a current belongs, by its changes from frame to frame."""

import numpy as np
import pandas as pd
import pytest

from ur5lib.checks.innovations import innovation_likelihoods
from ur5lib.timeseries.arrays import Array

COUNT = 1500


def robot(current: Array, q: Array) -> pd.DataFrame:
    columns = {f"actual_q_{j}": q[:, j] for j in range(6)}
    columns |= {f"actual_current_{j}": current[:, j] for j in range(6)}
    about = {"time": 0.008 * np.arange(len(q)), "segment": 0, "interpolated": False}
    return pd.DataFrame(about | columns)


def drawn(seed: int) -> tuple[Array, Array]:
    """Currents and positions that have nothing to do with each other."""
    random = np.random.default_rng(seed)
    current, shaken = random.normal(size=(2, COUNT, 6))
    return current, np.cumsum(shaken, axis=0)


def test_what_has_nothing_to_do_with_a_current_explains_as_much_as_chance_does() -> None:
    """A joint's motion in five frames has ten columns: Σ χ² of ten, of which every second frame
    counts, in half logarithms.
    """
    found = [innovation_likelihoods(robot(*drawn(seed)), 0.008, [0, 3]) for seed in range(6)]
    assert found[0].shape == (2, 6, 6)
    assert np.mean(found) == pytest.approx(10 / 4, rel=0.1)
    assert np.std(found) == pytest.approx(np.sqrt(20) / 4, rel=0.15)


@pytest.mark.parametrize("late", [0, 4])
def test_a_current_belongs_to_the_joint_whose_disturbances_it_answers(late: int) -> None:
    """Each joint's to the next one's, and as late as it is."""
    current, q = drawn(1)
    answer = np.roll(np.diff(q, axis=0, prepend=q[:1]), (late, 1), axis=(0, 1))
    found = innovation_likelihoods(robot(current + 0.5 * answer, q), 0.008, [0, 4])
    shifted = int(late > 0)
    np.testing.assert_array_equal(found[shifted].argmax(axis=1), [5, 0, 1, 2, 3, 4])
    # ln(1 + .25) of the variance is explained, less by jumps that are cut
    explained = found[shifted][range(6), [5, 0, 1, 2, 3, 4]]
    assert explained.mean() == pytest.approx(COUNT / 4 * np.log(1.25), rel=0.15)
    assert found[1 - shifted].mean() < explained.min() / 5 or late == 0


def test_repeated_smoothed_slow_and_short_currents_show_nothing() -> None:
    current, q = drawn(2)
    repeated = np.repeat(current[::2], 2, axis=0)
    smoothed = np.cumsum(np.cumsum(current, axis=0), axis=0)
    for one in (repeated, smoothed):
        assert not innovation_likelihoods(robot(one, q), 0.008, [0]).any()
    assert not innovation_likelihoods(robot(current, q), 0.021, [0]).any()
    few = slice(0, 100)
    assert not innovation_likelihoods(robot(current[few], q[few]), 0.008, [0]).any()
    lost = robot(current, q).assign(interpolated=np.arange(COUNT) % 2 == 0)
    assert not innovation_likelihoods(lost, 0.008, [0]).any()
