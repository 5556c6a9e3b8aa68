"""The design of the most informative trajectory within an arm's limits and surroundings."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter

import numpy as np
from scipy.optimize import minimize

from ur5lab.excitation.objective import Objective, Task, Worth
from ur5lab.excitation.trajectory import Margins, Path, WorkCell, resting_series
from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array, Mask

CHECK_RATE = 1000.0  # Hz; of the check of results
COARSE_CHECK_RATE = 25.0  # Hz; of the check of attempts
POSTURE_TRIALS = 1000  # random postures
# rad; in random postures, each joint is within this angle of the middle of its range.
MAX_POSTURE_ANGLE = 2.6  # rad
BISECTION_STEPS = 8  # in the search for the largest share of a path
SHRINK_FACTOR = 0.97  # a path that fails the fine check shrinks by this factor
MAX_SHRINKS = 30
LINE_SEARCH_FAILURE = 2  # status of SciPy's L-BFGS-B


@dataclass(frozen=True)
class Effort:
    """How long the search for a trajectory goes on.

    starts: number of random starts; first: iterations from each; rounds: for each further round
    from the best start, the weight of the penalty and the number of iterations.
    """

    starts: int = 4
    first: int = 40
    rounds: tuple[tuple[float, int], ...] = ((1e2, 120), (1e3, 60), (1e4, 60))

    def iterations(self) -> int:
        """Return the total number of iterations."""
        return self.starts * self.first + sum(count for _, count in self.rounds)


USUAL_EFFORT = Effort()


def feasible_path(cell: WorkCell, path: Path, rate: float = CHECK_RATE) -> tuple[Path, Margins]:
    """Return a path shrunk towards its posture until it keeps all limits, and its margins to them.

    rate: [Hz], at which states are checked. Raises InputError if even the posture itself breaks a
    limit.
    """
    # velocity, acceleration and jerk scale with the path
    rates = zip(path.sampled(COARSE_CHECK_RATE)[1][1:], cell.limits.of_joints()[1:4], strict=True)
    used = [np.abs(part).max(axis=0) / limit for part, limit in rates]
    path = path.shrunk(1 / np.maximum(np.max(used, axis=0), 1))
    path = path.shrunk(_largest_share(cell, path))
    margins = cell.margins(path.sampled(rate if path.coefficients.any() else COARSE_CHECK_RATE)[1])
    for _ in range(MAX_SHRINKS):
        if not margins.broken() or not path.coefficients.any():
            break
        path = path.shrunk(SHRINK_FACTOR)
        margins = cell.margins(path.sampled(rate)[1])
    if margins.broken():
        raise InputError(
            f"no motion about the posture keeps the limits ({margins.broken()[0]}); give the arm "
            "more room"
        )
    return path, margins


def _largest_share(cell: WorkCell, path: Path) -> float:
    """Return the largest factor by which a path may be scaled to keep all limits, by bisection; 0
    if none does.
    """
    if not cell.margins(path.sampled(COARSE_CHECK_RATE)[1]).broken():
        return 1.0
    low, high = 0.0, 1.0
    for _ in range(BISECTION_STEPS):
        middle = (low + high) / 2
        broken = cell.margins(path.shrunk(middle).sampled(COARSE_CHECK_RATE)[1]).broken()
        low, high = (low, middle) if broken else (middle, high)
    return low


def random_path(task: Task, random: np.random.Generator, postures: Array) -> Path:
    """Return a random path, as large as the limits allow.

    postures: (M, n) [rad], of which one is drawn as the start; see `free_postures`.
    """
    basis = resting_series(task.seconds, task.harmonics)
    coefficients = basis @ random.normal(size=(basis.shape[1], postures.shape[1]))
    posture = postures[random.integers(len(postures))]
    path = Path(posture, coefficients, task.seconds)
    speed = np.abs(path.sampled(COARSE_CHECK_RATE)[1].qd).max(axis=0)
    return feasible_path(
        task.cell, path.shrunk(task.cell.limits.velocity / speed), COARSE_CHECK_RATE
    )[0]


def free_postures(cell: WorkCell, random: np.random.Generator) -> Array:
    """Return random postures (M, n) [rad] in which the arm keeps all limits at rest.

    Raises InputError if there is none; its message names the limit that is broken most often.
    """
    turned = np.minimum(MAX_POSTURE_ANGLE, cell.limits.position)
    q = cell.middle + random.uniform(-turned, turned, (POSTURE_TRIALS, len(turned)))
    broken = _broken_at_rest(cell, q)
    keeps_limits = ~np.any(list(broken.values()), axis=0)
    if not keeps_limits.any():
        limit, where = max(broken.items(), key=lambda item: int(item[1].sum()))
        raise InputError(
            f"{cell.robot.name} has no room to move: in {where.mean():.0%} of "
            f"{POSTURE_TRIALS} random postures {limit}; move the table or "
            "the boxes, or mount the arm elsewhere"
        )
    return q[keeps_limits]


def _broken_at_rest(cell: WorkCell, q: Array) -> dict[str, Mask]:
    """Return by limit whether the arm exceeds it at rest in postures (N, n) [rad]."""
    still, clearances = np.zeros_like(q), cell.capsules.near(q)
    torque = cell.model.inverse_dynamics(q, still, still)
    touched = dict[str, Mask]()
    for sample, distance, pair in zip(
        clearances.sample, clearances.distance, clearances.pairs, strict=True
    ):
        if distance < cell.limits.clearance:
            name = f"{' and '.join(pair)} come within {cell.limits.clearance:g} m"
            touched.setdefault(name, np.zeros(len(q), dtype=bool))[sample] = True
    return touched | {
        "gravity needs more than the torque limit": np.any(
            np.abs(torque) > cell.limits.torque, axis=1
        ),
        "the arm is near a singularity": cell.singular_value(q) < cell.limits.singular_value,
    }


@dataclass(frozen=True)
class Design:
    """A designed trajectory for a task, which keeps all limits, and its margins to them."""

    task: Task
    path: Path
    margins: Margins

    @cached_property
    def worth(self) -> Worth:
        """Return how much a recording of the trajectory would add to what is known."""
        return Worth.along(self.task, self.path)


Stepped = Callable[[int], object]  # called with the number of iterations since the last call


def design(
    task: Task, seed: int, effort: Effort = USUAL_EFFORT, stepped: Stepped = lambda _: None
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
    improved = [_improved_point(objective, x, weight, effort.first, stepped) for x in tries]
    best = min(improved, key=lambda x: objective(x, weight)[0])
    for weight, iterations in effort.rounds:
        best = _improved_point(objective, best, weight, iterations, stepped)
    return Design(task, *feasible_path(task.cell, objective.path(best)))


def _improved_point(
    objective: Objective, start: Array, weight: float, iterations: int, stepped: Stepped
) -> Array:
    """Return the best point of L-BFGS-B from a start; unused iterations are reported as done.

    Sign changes of dry friction cause kinks of the criterion. If one stops the line search, the
    search restarts at the lowest point so far.
    """
    lowest = np.inf, start

    def recorded_value(x: Array) -> tuple[float, Array]:
        nonlocal lowest
        value, gradient = objective(x, weight)
        lowest = min(lowest, (value, x.copy()), key=itemgetter(0))
        return value, gradient

    def count_step(xk: Array) -> None:
        stepped(1)

    done = 0
    while done < iterations:
        lowest_before, remaining = lowest[0], iterations - done
        run = minimize(
            recorded_value,
            lowest[1],
            method="L-BFGS-B",
            jac=True,
            options={"maxiter": remaining, "maxfun": 2 * remaining, "ftol": 0.0, "gtol": 0.0},
            callback=count_step,
        )
        done += run.nit
        if run.status != LINE_SEARCH_FAILURE or lowest[0] >= lowest_before:
            break
    stepped(iterations - done)
    return lowest[1]
