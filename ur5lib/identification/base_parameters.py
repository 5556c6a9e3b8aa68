"""Inertial parameters of an arm from torques: base parameters, their estimate, and its model."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ur5lib.errors import RefusalError
from ur5lib.records.codes import CauseCode
from ur5lib.robots.description import Model, Robot
from ur5lib.robots.inertia import link_tail, shift_inertia, tensor
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import mean_absolute_error

Blocks = Iterable[tuple[Array, Array]]

LINK_PARAMETERS = ("m", "m c_x", "m c_y", "m c_z", "I_xx", "I_xy", "I_yy", "I_xz", "I_yz", "I_zz")
# A joint has the parameters of its link, and the rotor inertia.
PARAMETERS_PER_JOINT = len(LINK_PARAMETERS) + 1
# Standard deviations of the prior around the published model.
MASS_WIDTH = 0.5  # kg
MOMENT_WIDTH = 0.1  # kg m
INERTIA_WIDTH = 0.05  # kg m²
ROTOR_WIDTH = 2.0  # kg m²
# This rank tolerance, relative to the largest column, lies between rounding and independent
# columns.
RANK_TOLERANCE = 1e-9
MAX_BLOCKS = 100
TORQUE_DIGIT = 1e-6  # Nm: the last digit of a logged torque
# A determined parameter has at most this share of the prior's variance: a tenth of its width.
MAX_PRIOR_VARIANCE_SHARE = 0.01


@dataclass(frozen=True)
class BaseParameters:
    """The combinations β = groups π of the parameters π on which torques depend.

    columns: (B,), number of the parameter that names each combination and has the coefficient 1;
    groups: (B, P).
    """

    columns: NDArray[np.intp]
    groups: Array

    @cached_property
    def parameters(self) -> list[str]:
        """Return the names of π (P,)."""
        return parameter_names(self.groups.shape[1])

    def names(self) -> list[str]:
        """Return the name of each base parameter: that of its own parameter, and of those grouped
        with it.

        The names contain no coefficients, whose last digits differ between processors.
        """
        rows, of = zip(self.groups, self.columns, strict=True), self.parameters
        grouped = ((of[k], [of[i] for i in np.flatnonzero(row) if i != k]) for row, k in rows)
        return [f"{own} with {', '.join(others)}" if others else own for own, others in grouped]


@dataclass(frozen=True)
class Stack:
    """The rows [Y τ] of a linear fit to an arm of n joints, kept as triangular factors of their QR
    decomposition.

    factors: (B, n, P + 1, P + 1), of each block and joint; samples: (B,), rows per block.
    """

    factors: Array
    samples: NDArray[np.intp]


@dataclass(frozen=True)
class InertialEstimate:
    """The estimate of π from data and prior.

    parameters: (P,); scatter: (K, P), V of the covariance Vᵀ V from the jackknife over blocks;
    spread: (P, P), S of the covariance S Sᵀ for independent errors of all rows; rounding: (P, P),
    the same for errors of half the last digit of torques; width: (P,), standard deviations of the
    prior; noise: (n,) [Nm], of each joint's torque.
    """

    parameters: Array
    scatter: Array
    spread: Array
    rounding: Array
    width: Array
    noise: Array

    def standard_errors(self, groups: Array) -> Array:
        """Return the standard errors (B,) of groups π, at least those of the torques' rounding;
        groups: (B, P).

        Rounding repeats itself where an arm rests or passes again: the blocks of the jackknife
        agree on it, and more samples do not average it.
        """
        scattered = np.linalg.norm(groups @ self.scatter.T, axis=1)
        return np.maximum(scattered, np.linalg.norm(groups @ self.rounding, axis=1))

    def determined(self, groups: Array) -> Mask:
        """Return which of groups π (B,) the data determine: those with a small error that does not
        come from the prior.
        """
        prior_std = np.linalg.norm(groups * self.width, axis=1)
        share = prior_share(groups, self.spread, self.width)
        narrow = self.standard_errors(groups) <= np.sqrt(MAX_PRIOR_VARIANCE_SHARE) * prior_std
        return narrow & (share <= MAX_PRIOR_VARIANCE_SHARE)


def base_parameters(regressor: Array) -> BaseParameters:
    """Return the base parameters of an arm by a rank test (Gautier 1991).

    regressor: (N, n, P), Y of τ = Y π at some hundred random states. A parameter is grouped with
    earlier ones if its column depends linearly on theirs. Links are taken from the base outwards,
    as Khalil does, which keeps the groups short.
    """
    rows = _triangle(regressor.reshape(-1, regressor.shape[2]))
    tolerance = RANK_TOLERANCE * np.linalg.norm(rows, axis=0).max()
    # a column is kept if it raises the rank
    independent: list[int] = []
    for column in range(rows.shape[1]):
        if np.linalg.matrix_rank(rows[:, [*independent, column]], tol=tolerance) > len(independent):
            independent.append(column)
    # Y = Y_kept groups
    groups = np.linalg.lstsq(rows[:, independent], rows, rcond=None)[0].astype(np.float64)  # (B, P)
    groups[np.abs(groups) < RANK_TOLERANCE] = 0.0
    return BaseParameters(np.array(independent), groups)


def parameter_names(count: int) -> list[str]:
    """Return the names of the `count` parameters π: those of the links, then the rotor inertias."""
    joints = range(1, count // PARAMETERS_PER_JOINT + 1)
    links = [f"{name} of link {k}" for k in joints for name in LINK_PARAMETERS]
    return [*links, *(f"rotor inertia of joint {k}" for k in joints)]


def prior_width(count: int) -> Array:
    """Return the standard deviations of the prior of the `count` parameters π."""
    link = [MASS_WIDTH, *[MOMENT_WIDTH] * 3, *[INERTIA_WIDTH] * 6]
    joints = count // PARAMETERS_PER_JOINT
    return np.array([*link * joints, *[ROTOR_WIDTH] * joints])


def stack(blocks: Blocks) -> Stack:
    """Return regressors (N, n, P) and torques (N, n) [Nm] of all blocks as a Stack.

    Errors within a block may be correlated, those of different blocks count as independent: one or
    two seconds per block suffice. Rows with NaN are excluded. Memory is bounded: beyond MAX_BLOCKS
    blocks, the shortest neighbours are merged. Raises RefusalError if no row remains.
    """
    factors: list[Array] = []
    samples: list[int] = []
    for regressor, torque in blocks:
        rows = np.concatenate([regressor, torque[..., None]], axis=2)
        rows = rows[np.isfinite(rows).all(axis=(1, 2))]
        if len(rows):
            by_joint = rows.swapaxes(0, 1)
            # a full factor of short blocks, too
            full = np.zeros((len(by_joint), *by_joint.shape[2:] * 2))
            factors.append(_triangle(np.concatenate([full, by_joint], axis=1)))
            samples.append(len(rows))
        if len(samples) > MAX_BLOCKS:
            i = int(np.argmin(np.add(samples[:-1], samples[1:])))
            factors[i : i + 2] = [_triangle(np.concatenate(factors[i : i + 2], axis=1))]
            samples[i : i + 2] = [sum(samples[i : i + 2])]
    if not samples:
        text = "no recording has both a complete motion and target_moment"
        raise RefusalError(CauseCode.NO_KNOWN_TORQUE, text)
    return Stack(np.stack(factors), np.array(samples))


def _triangle(rows: Array) -> Array:
    """Return R (..., M, M) of the QR decomposition of rows (..., N, M)."""
    return np.asarray(np.linalg.qr(rows, mode="r"), dtype=np.float64)


def total_factors(data: Stack) -> Array:
    """Return the triangular factors (n, P + 1, P + 1) of all rows of each joint."""
    rows = data.factors.swapaxes(0, 1)
    return _triangle(rows.reshape(len(rows), -1, rows.shape[-1]))


def identify(data: Stack, prior: Array, width: Array) -> InertialEstimate:
    """Return π fitted by weighted least squares with ridge regression towards a prior.

    prior, width: (P,), mean and standard deviation of π before the data. The weights are the
    inverse squares of each joint's noise, which is estimated from the residuals. Raises
    RefusalError for a single block, which determines no standard errors.
    """
    if len(data.samples) < 2:
        text = (
            "standard errors need two blocks of samples or more; record a longer motion with "
            "target_moment"
        )
        raise RefusalError(CauseCode.ONE_BLOCK, text)
    rows, count = total_factors(data), data.samples.sum()
    # alternate π and the noise of each joint, n - tr(S Sᵀ Yᵀ Y) / σ² degrees of freedom
    noise = _noise(rows, prior, np.full(len(rows), count))
    for _ in range(10):
        parameters, spread = solve(rows, noise, prior, width)
        spent = (np.linalg.norm(rows[..., :-1] @ spread, axis=(1, 2)) / noise) ** 2
        noise = _noise(rows, parameters, count - spent)
    parameters, spread = solve(rows, noise, prior, width)
    scatter = _jackknife_changes(data.factors / noise[:, None, None], parameters, spread, width)
    # of n samples rounded by up to half a digit, |Σ g_k ε_k| <= √n |g| TORQUE_DIGIT / 2; this is
    # the standard deviation of an error that is anywhere between these bounds
    _, rounding = solve(rows, np.full(len(rows), np.sqrt(count / 12) * TORQUE_DIGIT), prior, width)
    return InertialEstimate(parameters, scatter, spread, rounding, width, noise)


def torque_error(blocks: Blocks, parameters: Array) -> Array:
    """Return the MAE (n,) [Nm] of the torques Y π over blocks (Y, τ); parameters: π (P,)."""
    torques = [(regressor @ parameters, torque) for regressor, torque in blocks]
    estimate, reference = map(np.concatenate, zip(*torques, strict=True))
    return mean_absolute_error(estimate, reference)


def solve(rows: Array, noise: Array, prior: Array, width: Array) -> tuple[Array, Array]:
    """Return π (P,) and the root S (P, P) of its covariance S Sᵀ, from the factors of all rows and
    the prior.

    rows: (n, P + 1, P + 1); noise: (n,) [Nm]; prior, width: (P,). QR of [Y τ; 1 π₀] / [σ; width].
    """
    # ridge: rows of a prior as if they were measured
    weighted = (rows / noise[:, None, None]).reshape(-1, rows.shape[-1])
    ridge = np.column_stack([np.diag(1 / width), prior / width])
    factor = _triangle(np.concatenate([weighted, ridge]))[:-1]
    spread = solve_triangular(factor[:, :-1], np.eye(len(prior)))
    return spread @ factor[:, -1], spread


def prior_share(groups: Array, spread: Array, width: Array) -> Array:
    """Return which share of the variance of groups π (B,) comes from the prior, 0 to 1; spread: S
    (P, P) of the covariance S Sᵀ.
    """
    root = groups @ spread
    from_prior = root @ (spread / width[:, None]).T
    return np.sum(from_prior**2, axis=1) / np.sum(root**2, axis=1)


def _noise(rows: Array, parameters: Array, freedom: Array) -> Array:
    """Return the standard deviation (n,) of the residuals, with degrees of freedom (n,)."""
    residual = np.linalg.norm(rows @ np.append(-parameters, 1.0), axis=1)
    return np.maximum(residual / np.sqrt(np.maximum(freedom, 1.0)), TORQUE_DIGIT)


def _jackknife_changes(factors: Array, parameters: Array, spread: Array, width: Array) -> Array:
    """Return how the estimate changes without each block (jackknife), and the prior's part of its
    scatter, (K, P).

    With A = rows of a block times S, and e its residuals, the change is S (1 - AᵀA)⁻¹ Aᵀ e.
    """
    rows = factors.reshape(len(factors), -1, factors.shape[-1])
    block = rows[..., :-1] @ spread  # A
    residual = (rows @ np.append(-parameters, 1.0))[..., None]  # e
    gradient = block.mT @ residual  # Aᵀ e
    remaining = np.eye(len(spread)) - block.mT @ block  # 1 - AᵀA
    changes = np.linalg.solve(remaining, gradient)[..., 0] @ spread.T
    from_prior = spread / width[:, None] @ spread.T
    return np.concatenate([changes * np.sqrt(1 - 1 / len(changes)), from_prior])


def identified_model(robot: Robot, parameters: Array, description: str) -> Model:
    """Return the model of an arm with inertial parameters π = parameters (P,).

    π as in `ur5lib.robots.inertia.inertial_parameters`, in the URDF's frames link_k; a payload
    belongs to the last link. Raises ValueError if a mass or a rotor inertia is negative.
    """
    masses, centers, inertias = [], [], []
    poses = robot.link_poses()
    links, rotors = np.split(parameters, [10 * len(poses)])
    for link, pose in zip(links.reshape(-1, 10), poses, strict=True):
        mass, center = link[0], link[1:4] / link[0]
        rotation, translation = link_tail(pose)
        about_origin = tensor(link[[4, 6, 9, 5, 7, 8]].tolist())
        inertia = rotation.T @ shift_inertia(about_origin, -mass, center) @ rotation
        masses.append(float(mass))
        centers.append(tuple((rotation.T @ (center - translation)).tolist()))
        inertias.append(tuple(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist()))
    return Model.model_validate(
        {
            "description": description,
            "masses": tuple(masses),
            "centers_of_mass": tuple(centers),
            "inertias": tuple(inertias),
            "rotor_inertias": tuple(rotors.tolist()),
        }
    )
