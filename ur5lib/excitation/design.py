"""The design of a trajectory: as informative as an arm's limits and its surroundings allow."""

from collections.abc import Callable
from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from scipy.optimize import minimize

from ur5lib.excitation.feasible import feasible, free_postures, random_path
from ur5lib.excitation.limits import Margins
from ur5lib.excitation.objective import Objective, Task
from ur5lib.excitation.path import Path
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class Effort:
    """The effort of the search.

    starts: random ones; first: iterations from each; rounds: for each round from the best start,
    the weight of the penalty and the number of iterations.
    """

    starts: int = 4
    first: int = 40
    rounds: tuple[tuple[float, int], ...] = ((1e2, 120), (1e3, 60), (1e4, 60))

    def iterations(self) -> int:
        """Return the total number of iterations."""
        return self.starts * self.first + sum(count for _, count in self.rounds)


@dataclass(frozen=True)
class Design:
    """A trajectory within all limits, its margins, and the information (P, P) once recorded."""

    path: Path
    margins: Margins
    information: Array


LINE_SEARCH_FAILED = 2  # SciPy's status of L-BFGS-B

USUAL = Effort()
Stepped = Callable[[int], object]  # called with the number of iterations since the last call


def design(
    task: Task, seed: int, effort: Effort = USUAL, stepped: Stepped = lambda _: None
) -> Design:
    """Return the most informative trajectory from several random starts; the seed determines it.

    stepped: called as the search advances, `effort.iterations()` steps in total. A penalty method
    with exact gradients (L-BFGS-B); a result that exceeds a limit at 1 kHz is shrunk until it does
    not. Raises InputError if the arm has no room to move.
    """
    random, objective = np.random.default_rng(seed), Objective(task)
    postures = free_postures(task.cell, random)
    starts = [random_path(task, random, postures) for _ in range(effort.starts)]
    weight = effort.rounds[0][0]
    tries = [objective.variables(path) for path in starts]
    improved = [_improved(objective, x, weight, effort.first, stepped) for x in tries]
    best = min(improved, key=lambda x: objective(x, weight)[0])
    for weight, iterations in effort.rounds:
        best = _improved(objective, best, weight, iterations, stepped)
    path, margins = feasible(task.cell, objective.path(best))
    return Design(path, margins, task.information(path))


def _improved(
    objective: Objective, start: Array, weight: float, iterations: int, stepped: Stepped
) -> Array:
    """Return the best point of L-BFGS-B from a start; steps that it does not need count as done.

    Sign changes of dry friction cause kinks of the criterion. Where one stops the line search, the
    search restarts at the lowest point seen.
    """
    lowest = np.inf, start

    def seen(x: Array) -> tuple[float, Array]:
        nonlocal lowest
        value, gradient = objective(x, weight)
        lowest = min(lowest, (value, x.copy()), key=itemgetter(0))
        return value, gradient

    done = 0
    while done < iterations:
        before, remaining = lowest[0], iterations - done
        options = {"maxiter": remaining, "maxfun": 2 * remaining, "ftol": 0.0, "gtol": 0.0}
        run = minimize(
            seen,
            lowest[1],
            method="L-BFGS-B",
            jac=True,
            options=options,
            callback=lambda _: stepped(1),
        )
        done += run.nit
        if run.status != LINE_SEARCH_FAILED or lowest[0] >= before:
            break
    stepped(iterations - done)
    return lowest[1]
