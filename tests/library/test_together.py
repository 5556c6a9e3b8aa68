"""Optimisers whose costs are evaluated together find what each finds alone."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import minimize

from ur5lib.smoothing.together import Cost, minimise_together
from ur5lib.timeseries.arrays import Array

PLACES = np.array([[0.0, 1.0], [30.0, -2.0], [0.1, 0.1]])  # minima; the second is found last


def descend(cost: Cost) -> Array:
    return np.asarray(minimize(cost, np.zeros(2), method="Nelder-Mead").x)


def distance(parameters: Array, place: Array) -> float:
    return float(np.sum((parameters - place) ** 2))


def test_each_finds_what_it_finds_alone_and_all_that_run_are_asked_at_once() -> None:
    rounds = []

    def costs(ones: Sequence[int], parameters: Array) -> Array:
        rounds.append([*ones])
        return np.array([distance(p, PLACES[one]) for one, p in zip(ones, parameters, strict=True)])

    found = minimise_together(descend, costs, len(PLACES))
    alone = [descend(lambda p, place=place: distance(p, place)) for place in PLACES]
    assert (found == np.stack(alone)).all()
    assert rounds[0] == [0, 1, 2]
    assert all({*later} <= {*earlier} for earlier, later in pairwise(rounds))


def test_an_error_of_the_costs_reaches_the_caller() -> None:
    def costs(ones: Sequence[int], parameters: Array) -> Array:
        raise ValueError("no joint moves")

    with pytest.raises(ValueError, match="no joint moves"):
        minimise_together(descend, costs, 3)
