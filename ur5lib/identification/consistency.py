"""Physically consistent inertial parameters: positive definite pseudo-inertias."""

import warnings
from functools import cache
from typing import NamedTuple

import cvxpy as cp
import numpy as np

from ur5lib.errors import RefusalError
from ur5lib.identification.base_parameters import PARAMETERS_PER_JOINT, InertialEstimate
from ur5lib.records.codes import CauseCode
from ur5lib.timeseries.arrays import Array

LINK_LENGTH = 0.1  # m; it scales masses, moments and inertias alike
SOLVED = cp.OPTIMAL, cp.OPTIMAL_INACCURATE  # inaccurate: within 5e-5 of a standard error's square
DEFINITENESS_MARGIN = 1e-6  # kg, kg m²: far below any link's, far above the solver's tolerance


@cache
def pseudo_inertia_basis() -> Array:
    """Return the pseudo-inertia [[½ tr(I) 1 - I, m c], [m cᵀ, m]] of each parameter, (10, 4, 4)."""
    basis = np.zeros((10, 4, 4))
    basis[0, 3, 3] = 1
    for i in range(3):
        basis[1 + i, [i, 3], [3, i]] = 1
    for row, (i, j) in enumerate([(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)], start=4):
        basis[row, [i, j], [j, i]] = -1
        if i == j:
            basis[row, :3, :3] += np.eye(3) / 2
    scale = np.array([1 / LINK_LENGTH] * 3 + [1.0])
    return basis * np.outer(scale, scale)


def pseudo_inertias(parameters: Array) -> Array:
    """Return the pseudo-inertias (n, 4, 4) [kg] of the links with parameters π (P,), lengths in
    LINK_LENGTH.
    """
    joints = len(parameters) // PARAMETERS_PER_JOINT
    return np.einsum(
        "ki,imn->kmn", parameters[:-joints].reshape(joints, -1), pseudo_inertia_basis()
    )


def smallest_eigenvalues(parameters: Array) -> Array:
    """Return the pseudo-inertias' least eigenvalues (n,) [kg], positive for bodies (Wensing)."""
    return np.linalg.eigvalsh(pseudo_inertias(parameters))[:, 0].astype(np.float64)


class LinkBounds(NamedTuple):
    """Bounds of an arm's links.

    weight: largest sum of all links' masses [kg], None where unknown; low, high: corners (n, 3) [m]
    of boxes that contain their centres of mass, in the frames of π.
    """

    weight: float | None
    low: Array
    high: Array


def consistent_parameters(estimate: InertialEstimate) -> Array:
    """Return the physically consistent π (P,) nearest to an estimate, in the metric of its errors.

    Its standard errors are those of the estimate. Raises RefusalError if no bodies explain the
    torques.
    """
    return nearest_bodies(estimate.parameters, estimate.spread)


def nearest_bodies(estimate: Array, spread: Array, bounds: LinkBounds | None = None) -> Array:
    """Return the physically consistent π (P,) nearest to an estimate π̂ (P,).

    Minimises (π - π̂)ᵀ Σ⁻¹ (π - π̂), the weighted least squares with the prior, subject to
    pseudo-inertias and rotor inertias of at least DEFINITENESS_MARGIN, and to bounds: a convex
    problem. With Σ = S Sᵀ, S = spread (P, P), the unknown is S⁻¹ (π - π̂).
    """
    change = cp.Variable(len(estimate))
    parameters = estimate + spread @ change
    joints = len(estimate) // PARAMETERS_PER_JOINT
    basis = pseudo_inertia_basis() if bounds is None else _of_size(bounds)
    bodies = [
        cp.reshape(basis.reshape(10, 16).T @ parameters[10 * k : 10 * k + 10], (4, 4), order="C")
        >> DEFINITENESS_MARGIN * np.eye(4)
        for k in range(joints)
    ]
    rotors = parameters[10 * joints :] >= DEFINITENESS_MARGIN
    limits = [] if bounds is None else _within(parameters[: 10 * joints], bounds)
    problem = cp.Problem(cp.Minimize(cp.sum_squares(change)), [*bodies, rotors, *limits])
    with warnings.catch_warnings(action="ignore", category=UserWarning):
        problem.solve(solver=cp.CLARABEL)
    if problem.status not in SOLVED:
        text = (
            "no physically consistent inertial parameters explain the torques (solver: "
            f"{problem.status}); check their units, the robot and its weight"
        )
        raise RefusalError(CauseCode.NO_BODIES, text)
    return np.asarray(parameters.value, dtype=np.float64)


def _of_size(bounds: LinkBounds) -> Array:
    """Return the pseudo-inertia basis (10, 4, 4) in units of the boxes' length and the arm's
    weight.

    It describes the same bodies, but scaled so that a solver of finite tolerance converges for
    large arms.
    """
    length = float(np.max(bounds.high - bounds.low))
    scale = np.array([LINK_LENGTH / length] * 3 + [1.0])
    return pseudo_inertia_basis() * np.outer(scale, scale) / (bounds.weight or 1.0)


def _within(links: cp.Expression, bounds: LinkBounds) -> list[cp.Constraint]:
    """Return the constraints that keep the links' parameters within their bounds."""
    weight = bounds.weight or 1.0
    table = cp.reshape(links, (len(bounds.low), 10), order="C") / weight
    moments, masses = table[:, 1:4], table[:, :1] @ np.ones((1, 3))
    limits = [
        moments >= cp.multiply(masses, bounds.low),
        moments <= cp.multiply(masses, bounds.high),
    ]
    return limits if bounds.weight is None else [*limits, cp.sum(table[:, 0]) <= 1]
