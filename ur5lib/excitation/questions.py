"""The questions for which a recording is designed, as criteria of its information."""

from collections.abc import Callable

import numpy as np

from ur5lib.excitation.problem import Problem, random_states
from ur5lib.excitation.trajectory import Cell
from ur5lib.timeseries.arrays import Array, Mask

Criterion = Callable[[Array], tuple[float, Array]]
"""From the information M (P, P) to a value, the larger the better, and its gradient (P, P)."""

CONDITION = 30.0  # weight of a condition number's logarithm beside log det
RESOLVED = 1e-12  # smallest share of the largest eigenvalue that is not rounding
PREDICTED_SPEED, PREDICTED_ACCELERATION = 1.0, 2.0  # rad/s, rad/s²: where forces are estimated


def d_optimality(wanted: Mask) -> Criterion:
    """Return the criterion log det of the information on some parameters, with the others unknown.

    wanted: (P,), which parameters. log det M - log det M_oo, with o the others, which is the log
    det of the Schur complement (D_s-optimality).
    """
    others = np.ix_(~wanted, ~wanted)

    def value_and_gradient(information: Array) -> tuple[float, Array]:
        gradient = np.asarray(np.linalg.inv(information), np.float64)
        gradient[others] -= np.linalg.inv(information[others])
        value = np.linalg.slogdet(information)[1] - np.linalg.slogdet(information[others])[1]
        return float(value), gradient

    return value_and_gradient


def i_optimality(rows: Array) -> Criterion:
    """Return the criterion -P/2 log v, with v the mean variance of predictions rows · θ.

    rows: (N, P).
    """
    weight, half = rows.T @ rows / len(rows), rows.shape[1] / 2

    def value_and_gradient(information: Array) -> tuple[float, Array]:
        covariance = np.linalg.inv(information)
        mean = float(np.sum(weight * covariance))
        return -half * float(np.log(mean)), half / mean * covariance @ weight @ covariance

    return value_and_gradient


def conditioning(scale: Array) -> Criterion:
    """Return the criterion -log of the information's condition number, in units of a scale (P,).

    Parameters of scale zero are left out. The criterion is zero if the number is too large for
    double precision.
    """
    kept = np.ix_(scale > 0, scale > 0)
    weight = np.outer(scale, scale)

    def value_and_gradient(information: Array) -> tuple[float, Array]:
        values, vectors = np.linalg.eigh((weight * information)[kept])
        gradient = np.zeros_like(information)
        if values[0] < RESOLVED * values[-1]:
            return 0.0, gradient
        least, most = (np.outer(vectors[:, k], vectors[:, k]) / values[k] for k in (0, -1))
        gradient[kept] = least - most
        return float(np.log(values[0] / values[-1])), weight * gradient

    return value_and_gradient


def _model(problem: Problem, _: Cell) -> Criterion:
    """Return D-optimality plus two condition numbers, to which it is hardly sensitive.

    That of the base parameters is in SI units, as in the literature; that of all parameters is in
    units of their prior standard deviations.
    """
    of_base = np.where(np.arange(len(problem.theta)) < problem.count, 1.0, 0.0)
    of_all = np.sqrt(np.diag(np.linalg.inv(problem.prior)))
    informed = d_optimality(np.full(len(problem.theta), True))
    conditioned = conditioning(of_base), conditioning(of_all)

    def value_and_gradient(information: Array) -> tuple[float, Array]:
        value, gradient = informed(information)
        for part in conditioned:
            added, slope = part(information)
            value, gradient = value + CONDITION * added, gradient + CONDITION * slope
        return value, gradient

    return value_and_gradient


def _undetermined(problem: Problem, _: Cell) -> Criterion:
    """Return I-optimality of standard errors relative to the prior's.

    The largest ratios dominate their mean square.
    """
    return i_optimality(problem.to_physical() / problem.standard_errors(problem.prior)[:, None])


def _d_optimality_of(problem: Problem, place: slice) -> Criterion:
    """Return D-optimality of the parameters at a place in θ."""
    wanted = np.zeros(len(problem.theta), dtype=bool)
    wanted[place] = True
    return d_optimality(wanted)


def _force_bands(problem: Problem, cell: Cell) -> Criterion:
    """Return I-optimality of the currents that are predicted at random states.

    External forces are estimated from the difference between measured and predicted currents.
    """
    q, qd, qdd = random_states(cell.robot, PREDICTED_SPEED, PREDICTED_ACCELERATION)
    rows = problem.rows(problem.theta, cell.model.regressor(q, qd, qdd), qd)
    return i_optimality(rows[:, problem.joints :].reshape(-1, len(problem.theta)))


QUESTIONS: dict[str, Callable[[Problem, Cell], Criterion]] = {
    "model": _model,
    "undetermined": _undetermined,
    "friction": lambda problem, _: _d_optimality_of(problem, problem.of_currents),
    "payload": lambda problem, _: _d_optimality_of(problem, problem.of_payload),
    "force-bands": _force_bands,
}
