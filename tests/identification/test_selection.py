"""What left-out parts of recordings show of a term."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from tests.current_study import cut, make_record, prior
from ur5lib.identification.at_rest import AtRest
from ur5lib.identification.current_regression import expected_fit
from ur5lib.identification.currents import spring_current
from ur5lib.identification.regression import huber_weight
from ur5lib.identification.samples import JointSamples
from ur5lib.identification.selection import MOVING, RESTING, errors, shows
from ur5lib.records.friction import CurrentFit
from ur5lib.robots.friction import USUAL_TEMPERATURE


def one_a_path(moving: bool) -> JointSamples:
    """A sample on each of twelve paths."""
    return cast(JointSamples, SimpleNamespace(moving=np.full(12, moving), path=np.arange(12)))


def test_a_path_with_hardly_any_error_counts_as_much_as_one_with_much() -> None:
    """It is the share by which an error falls that shows a term, on each path."""
    known = np.array([3.0, *[0.1] * 11])
    for states, moving in ((MOVING, True), (RESTING, False)):
        samples = [one_a_path(moving)]
        assert shows(samples, [known], [0.5 * known], states)
        assert not shows(samples, [known], [known], states)
        elsewhere = RESTING if moving else MOVING  # nothing was seen there
        assert not shows(samples, [known], [0.5 * known], elsewhere)
    alone = np.where(np.arange(12) == 0, 0.1, known)  # less on the first path, elsewhere the same
    assert not shows([one_a_path(True)], [known], [alone], MOVING)


def test_a_joint_is_warm_by_what_it_has_above_the_usual_temperature() -> None:
    record = make_record(3)
    warm = np.add.outer(np.linspace(0, 9, len(record.q)), np.arange(6.0))
    found = replace(record, temperature=USUAL_TEMPERATURE + warm).joint(2).warmth
    np.testing.assert_allclose(found, warm[:, 2])
    assert record.joint(2).warmth == 0.0


@pytest.mark.parametrize("moving", [1, 2, 11])
def test_the_errors_before_a_change_count_each_sample_once(moving: int) -> None:
    """Of each joint, in motion and at rest, over all paths."""
    rows = SimpleNamespace(moving=np.arange(12) < moving, path=np.arange(12) // 3)
    known = np.random.default_rng(moving).normal(size=(2, 12))
    told = errors([cast(JointSamples, rows)] * 2, [*known], [*known], (True, False))
    assert told.shape == (4,)
    assert told.sum() == pytest.approx(24)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 8, 9, 10])
def test_residuals_beyond_a_multiple_of_the_median_count_less(count: int) -> None:
    """Huber's weight, whether the number of residuals is even or odd."""
    residual = np.random.default_rng(count).normal(size=count) ** 3
    scale = 1.4826 * np.median(np.abs(residual))
    weight = np.minimum(1.0, 1.345 * scale / np.abs(residual))
    np.testing.assert_allclose(huber_weight(residual), weight, rtol=1e-4)


@pytest.mark.parametrize(("count", "together"), [(20, 1), (21, 5), (24, 5), (25, 5)])
def test_postures_in_a_row_are_drawn_together_where_that_leaves_five(
    count: int, together: int
) -> None:
    postures = AtRest.of([(np.ones((count, 6)), np.ones((count, 6)))])
    assert postures is not None
    np.testing.assert_array_equal(postures.stretches(), np.arange(count) // together)


def test_a_spring_s_current_is_what_the_prediction_has_more_by_it() -> None:
    """Of joints 2 and 3; others have none."""
    record = replace(cut(make_record(3), slice(100)), balanced=(1, 2))
    springs = {1: (2.0, -1.0), 2: (0.5, 3.0)}
    joints = []
    for k, joint in enumerate(expected_fit(prior()).joints):
        own = np.append(joint.estimate.coefficients, springs.get(k, (0.0, 0.0)))
        estimate = replace(joint.estimate, coefficients=own)
        joints.append(replace(joint, estimate=estimate, terms=(*joint.terms, "balance")))
    q, expected = record.q, np.zeros_like(record.q)
    expected[:, 1] = 2.0 * np.sin(q[:, 1]) - np.cos(q[:, 1])
    expected[:, 2] = 0.5 * np.sin(q[:, 2]) + 3.0 * np.cos(q[:, 2])
    np.testing.assert_allclose(spring_current(CurrentFit(tuple(joints), 0), record), expected)
