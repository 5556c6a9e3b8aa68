"""The search of Nelder and Mead for several functions, whose costs are computed together.

scipy's `minimize` calls one function at one point. The searches here take the same steps, each for
its own function, and wait for each other: one call computes the costs of all.
"""

from collections.abc import Callable, Generator, Sequence

import numpy as np

from ur5lib.timeseries.arrays import Array

MAX_STEPS_PER_PARAMETER = 200

Costs = Callable[[Sequence[int], Array], Sequence[float]]
"""Returns the costs of some functions, each at its own point; points: (K, P)."""


def search_together(
    costs: Costs, count: int, simplex: Array, bounds: Array, xatol: float, fatol: float
) -> Array:
    """Return the points (count, P) at which the functions 0 to count - 1 have their least costs.

    simplex: (P + 1, P), inside the bounds, where each search starts; bounds: (P, 2); xatol, fatol:
    largest differences of points and costs within a simplex at which a search ends, as of scipy's
    `minimize(method="Nelder-Mead")`, whose results these are to the bit, without a limit of costs.
    """
    low, high = bounds.T
    searches = [_search(simplex.copy(), low, high, xatol, fatol) for _ in range(count)]
    points = dict(enumerate(map(next, searches)))
    found = np.empty((count, simplex.shape[1]))
    while points:
        known = costs([*points], np.array([*points.values()]))
        for k, cost in zip([*points], known, strict=True):
            try:
                points[k] = searches[k].send(cost)
            except StopIteration as end:
                found[k] = end.value
                del points[k]
    return found


def _search(
    simplex: Array, low: Array, high: Array, xatol: float, fatol: float
) -> Generator[Array, float, Array]:
    """Yield the points whose costs it takes; return the best one."""
    costs = yield from _in_turn(simplex)
    for _ in range(MAX_STEPS_PER_PARAMETER * len(low)):
        order = np.argsort(costs)
        simplex, costs = simplex[order], costs[order]
        sizes = np.abs(simplex[1:] - simplex[0]).max(), np.abs(costs[1:] - costs[0]).max()
        if sizes[0] <= xatol and sizes[1] <= fatol:
            break
        better = yield from _better(simplex, costs, low, high)
        if better is not None:
            simplex[-1], costs[-1] = better
            continue
        simplex[1:] = np.clip(simplex[0] + (simplex[1:] - simplex[0]) / 2, low, high)
        costs[1:] = yield from _in_turn(simplex[1:])
    return simplex[np.argmin(costs)]


def _in_turn(points: Array) -> Generator[Array, float, Array]:
    """Yield the points one by one; return their costs."""
    costs = np.empty(len(points))
    for k, point in enumerate(points):
        costs[k] = yield point
    return costs


def _better(
    simplex: Array, costs: Array, low: Array, high: Array
) -> Generator[Array, float, tuple[Array, float] | None]:
    """Return a point in place of the worst one, with its cost; None if the simplex must shrink."""
    worst, centre = simplex[-1], simplex[:-1].sum(axis=0) / len(low)

    def beyond(reach: float) -> Array:
        """Return the point on the line from the worst through the others' centre."""
        return np.clip((1 + reach) * centre - reach * worst, low, high)

    reflected = beyond(1)
    cost = yield reflected
    if cost < costs[0]:
        expanded = beyond(2)
        further = yield expanded
        return (expanded, further) if further < cost else (reflected, cost)
    if cost < costs[-2]:
        return reflected, cost
    contracted = beyond(0.5 if cost < costs[-1] else -0.5)
    nearer = yield contracted
    accepted = nearer <= cost if cost < costs[-1] else nearer < costs[-1]
    return (contracted, nearer) if accepted else None
