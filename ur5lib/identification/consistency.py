"""Physically consistent inertial parameters: positive definite pseudo-inertias."""

from functools import cache

import cvxpy as cp
import numpy as np

from ur5lib.errors import RefusalError
from ur5lib.identification.base_parameters import PARAMETERS_PER_JOINT, InertialEstimate
from ur5lib.timeseries.arrays import Array

LINK_LENGTH = 0.1  # m, which scales masses, moments and inertias alike
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
    """Return the pseudo-inertias (n, 4, 4) [kg] of π = parameters (P,), lengths in LINK_LENGTH."""
    joints = len(parameters) // PARAMETERS_PER_JOINT
    return np.einsum(
        "ki,imn->kmn", parameters[:-joints].reshape(joints, -1), pseudo_inertia_basis()
    )


def smallest_eigenvalues(parameters: Array) -> Array:
    """Return the pseudo-inertias' least eigenvalues (n,) [kg], positive for bodies (Wensing)."""
    return np.linalg.eigvalsh(pseudo_inertias(parameters))[:, 0].astype(np.float64)


def consistent_parameters(estimate: InertialEstimate) -> Array:
    """Return the physically consistent π (P,) nearest to an estimate, in the metric of its errors.

    Minimises (π - π̂)ᵀ Σ⁻¹ (π - π̂), the weighted least squares with the prior, subject to
    pseudo-inertias and rotor inertias of at least DEFINITENESS_MARGIN: a convex problem. With Σ = S
    Sᵀ, the unknown is S⁻¹ (π - π̂). Its standard errors are those of the estimate. Raises
    RefusalError if no bodies explain the torques.
    """
    change = cp.Variable(len(estimate.parameters))
    parameters = estimate.parameters + estimate.spread @ change
    bodies = [
        cp.reshape(
            pseudo_inertia_basis().reshape(10, 16).T @ parameters[10 * k : 10 * k + 10],
            (4, 4),
            order="C",
        )
        >> DEFINITENESS_MARGIN * np.eye(4)
        for k in range(len(estimate.noise))
    ]
    rotors = parameters[10 * len(bodies) :] >= DEFINITENESS_MARGIN
    problem = cp.Problem(cp.Minimize(cp.sum_squares(change)), [*bodies, rotors])
    problem.solve(solver=cp.CLARABEL)
    if problem.status != cp.OPTIMAL:
        raise RefusalError("no bodies", solver=problem.status)
    return np.asarray(parameters.value, dtype=np.float64)
