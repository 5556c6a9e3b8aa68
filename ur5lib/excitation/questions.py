"""The questions that a recording may be designed for, as functions of its information."""

from collections.abc import Callable

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.excitation.problem import Problem, random_states
from ur5lib.timeseries.arrays import Array, Mask

Criterion = Callable[[Array], tuple[float, Array]]
"""From the information M (P, P) to a value, the larger the better, and its gradient (P, P)."""

PREDICTED_SPEED, PREDICTED_ACCELERATION = 1.0, 2.0  # rad/s, rad/s²: where forces are estimated


def d_optimality(wanted: Mask) -> Criterion:
    """Return log det of the information on some parameters (P,), whatever the others are.

    log det M - log det M_oo with o the others: of the Schur complement (D_s-optimality).
    """
    others = np.ix_(~wanted, ~wanted)

    def of(information: Array) -> tuple[float, Array]:
        gradient = np.asarray(np.linalg.inv(information), np.float64)
        gradient[others] -= np.linalg.inv(information[others])
        value = np.linalg.slogdet(information)[1] - np.linalg.slogdet(information[others])[1]
        return float(value), gradient

    return of


def i_optimality(rows: Array) -> Criterion:
    """Return -P/2 log of the mean variance of predictions rows · θ; rows: (N, P)."""
    weight, half = rows.T @ rows / len(rows), rows.shape[1] / 2

    def of(information: Array) -> tuple[float, Array]:
        covariance = np.linalg.inv(information)
        mean = float(np.sum(weight * covariance))
        return -half * float(np.log(mean)), half / mean * covariance @ weight @ covariance

    return of


def _model(problem: Problem, _: LinkModel) -> Criterion:
    return d_optimality(np.full(len(problem.theta), True))


def _friction(problem: Problem, _: LinkModel) -> Criterion:
    wanted = np.zeros(len(problem.theta), dtype=bool)
    wanted[problem.of_currents] = True
    return d_optimality(wanted)


def _payload(problem: Problem, _: LinkModel) -> Criterion:
    wanted = np.zeros(len(problem.theta), dtype=bool)
    wanted[problem.of_payload] = True
    return d_optimality(wanted)


def _force_bands(problem: Problem, model: LinkModel) -> Criterion:
    """Predicted currents at random states: external forces are what they leave of the measured."""
    q, qd, qdd = random_states(PREDICTED_SPEED, PREDICTED_ACCELERATION)
    rows = problem.rows(problem.theta, model.regressor(q, qd, qdd), qd)
    return i_optimality(rows[:, 6:].reshape(-1, len(problem.theta)))


QUESTIONS: dict[str, Callable[[Problem, LinkModel], Criterion]] = {
    "model": _model,
    "friction": _friction,
    "payload": _payload,
    "force-bands": _force_bands,
}
