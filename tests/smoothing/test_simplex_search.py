"""Several searches that advance together end where scipy's single ones do."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.optimize import minimize

from ur5lib.smoothing.simplex_search import search_together
from ur5lib.timeseries.arrays import Array

TOLERANCES = {"xatol": 0.01, "fatol": 1e-4}


@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.integers(1, 6))
@example(9067, 5, 6)  # takes more than scipy's default number of costs
def test_each_search_ends_where_scipy_ends(seed: int, count: int, parameters: int) -> None:
    draw = np.random.default_rng(seed)
    slopes = draw.normal(size=(count, parameters, parameters))
    offsets = 2 * draw.normal(size=(count, parameters))
    bounds = np.stack([-draw.uniform(0, 2, parameters), draw.uniform(0.1, 2, parameters)], axis=1)
    start = draw.uniform(*bounds.T)
    simplex = np.vstack([start, start + np.diag(draw.normal(size=parameters))]).clip(*bounds.T)

    def cost(k: int, point: Array) -> float:
        return float(np.abs(slopes[k] @ point - offsets[k]).sum() + np.sin(3 * point).sum())

    together = search_together(
        lambda which, points: [*map(cost, which, points)], count, simplex, bounds, **TOLERANCES
    )
    for k in range(count):
        alone = minimize(
            lambda point, k=k: cost(k, point),
            start,
            method="Nelder-Mead",
            bounds=[*bounds],
            options={"initial_simplex": simplex, "maxfev": np.inf, **TOLERANCES},
        )
        np.testing.assert_array_equal(together[k], alone.x)
