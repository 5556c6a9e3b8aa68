"""Inertial parameters of an arm from torques along its motion: what they tell, and how well."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import mean_absolute_error

Blocks = Iterable[tuple[Array, Array]]

LINK = ("m", "m c_x", "m c_y", "m c_z", "I_xx", "I_xy", "I_yy", "I_xz", "I_yz", "I_zz")
FRICTION = ("Coulomb friction", "viscous friction", "torque offset")
NAMES = (
    *(f"{name} of link {k}" for k in range(1, 7) for name in LINK),
    *(f"rotor inertia of joint {k}" for k in range(1, 7)),
    *(f"{name} of joint {k}" for name in FRICTION for k in range(1, 7)),
)
# How far an arm may be from its published model: one standard deviation of the prior.
MASS_WIDTH, MOMENT_WIDTH, INERTIA_WIDTH, ROTOR_WIDTH = 0.5, 0.1, 0.05, 2.0  # kg, kg m, kg m²
FRICTION_WIDTHS = (20.0, 20.0, 20.0)  # Nm, Nm s/rad, Nm
DEPENDENT = 1e-9  # of the largest column: rounding leaves 1e-15 of it, a column of its own a tenth
MOST_BLOCKS = 100
FINEST = 1e-6  # Nm: the last digit of a logged torque
LARGEST_SHARE = 0.01  # of a variance from the prior: it stands for a tenth of the prior's width


@dataclass(frozen=True)
class BaseParameters:
    """β = groups π: the combinations of the parameters π that torques depend on.

    columns: (B,) which parameter gives each its name, with coefficient 1;
    groups: (B, P).
    """

    columns: NDArray[np.intp]
    groups: Array

    def names(self) -> list[str]:
        """Each base parameter as the sum that it is: its own parameter, and those it hides."""
        return [_sum(row, column) for row, column in zip(self.groups, self.columns, strict=True)]


@dataclass(frozen=True)
class Stack:
    """All that a linear fit needs of the rows [Y τ]: the triangular factors of their QR.

    factors: (B, 6, P + 1, P + 1) of each block and joint; samples: (B,).
    """

    factors: Array
    samples: NDArray[np.intp]


@dataclass(frozen=True)
class Estimate:
    """What data and prior say of π.

    parameters: (P,); scatter: (K, P), V of the covariance Vᵀ V, by how the blocks scatter;
    spread: (P, P), S of the covariance S Sᵀ that independent errors of each row would give;
    width: (P,), standard deviations of the prior; noise: (6,) [Nm] of each joint's torque.
    """

    parameters: Array
    scatter: Array
    spread: Array
    width: Array
    noise: Array

    def standard_errors(self, groups: Array) -> Array:
        """Of groups π; groups: (B, P)."""
        return np.asarray(np.linalg.norm(groups @ self.scatter.T, axis=1), dtype=np.float64)

    def determined(self, groups: Array) -> Mask:
        """Which of groups π the data tell, (B,): they, not the prior, give it a small error."""
        before = np.linalg.norm(groups * self.width, axis=1)
        share = prior_share(groups, self.spread, self.width)
        narrow = self.standard_errors(groups) <= np.sqrt(LARGEST_SHARE) * before
        return narrow & (share <= LARGEST_SHARE)


def base_parameters(regressor: Array) -> BaseParameters:
    """The base parameters of an arm (Gautier 1991), of links near the base first.

    regressor: (N, 6, P), Y of τ = Y π at some hundred random states. A parameter whose column
    depends on those before is hidden in their groups. Links are taken from the base outwards, as
    Khalil does: so the groups stay short.
    """
    rows = _triangle(regressor.reshape(-1, regressor.shape[2]))
    tolerance = DEPENDENT * np.linalg.norm(rows, axis=0).max()
    kept: list[int] = []
    for column in range(rows.shape[1]):
        if np.linalg.matrix_rank(rows[:, [*kept, column]], tol=tolerance) > len(kept):
            kept.append(column)
    groups = np.linalg.lstsq(rows[:, kept], rows, rcond=None)[0].astype(np.float64)
    groups[np.abs(groups) < DEPENDENT] = 0.0
    return BaseParameters(np.array(kept), groups)


def _sum(row: Array, column: int) -> str:
    hidden = [f"{row[i]:+.3g} {NAMES[i]}" for i in np.flatnonzero(row) if i != column]
    return " ".join([NAMES[column], *hidden])


def friction_columns(qd: Array, dead_zone: float) -> Array:
    """Regressor (N, 6, 18) of Coulomb friction, viscous friction and offset of each joint.

    qd: (N, 6) [rad/s]; there is no Coulomb friction up to dead_zone [rad/s] (Equation 3.12).
    """
    direction = np.where(np.abs(qd) > dead_zone, np.sign(qd), 0.0)
    terms = np.stack([direction, qd, np.ones_like(qd)], axis=1)
    return np.einsum("nkj,ji->njki", terms, np.eye(6)).reshape(len(qd), 6, 18)


def prior_width(count: int = 66) -> Array:
    """Standard deviations of the prior for π (66,), or for π and friction (84,)."""
    link = [MASS_WIDTH, *[MOMENT_WIDTH] * 3, *[INERTIA_WIDTH] * 6]
    return np.array([*link * 6, *[ROTOR_WIDTH] * 6, *np.repeat(FRICTION_WIDTHS, 6)])[:count]


def stack(blocks: Blocks) -> Stack:
    """Accumulate regressors (N, 6, P) and torques (N, 6) [Nm], block by block.

    Errors within a block may be correlated, those of different blocks are taken as independent:
    one or two seconds each do. Rows with NaN are left out. Memory does not grow with the
    recordings: from MOST_BLOCKS on, the shortest neighbours become one.
    Raises ValueError where no row is left.
    """
    factors: list[Array] = []
    samples: list[int] = []
    for regressor, torque in blocks:
        rows = np.concatenate([regressor, torque[..., None]], axis=2)
        rows = rows[np.isfinite(rows).all(axis=(1, 2))]
        if len(rows):
            full = np.zeros((6, *rows.shape[2:] * 2))  # so that short blocks fill one as well
            factors.append(_triangle(np.concatenate([full, rows.swapaxes(0, 1)], axis=1)))
            samples.append(len(rows))
        if len(samples) > MOST_BLOCKS:
            i = int(np.argmin(np.add(samples[:-1], samples[1:])))
            factors[i : i + 2] = [_triangle(np.concatenate(factors[i : i + 2], axis=1))]
            samples[i : i + 2] = [sum(samples[i : i + 2])]
    if not samples:
        raise ValueError("no recording has both a complete motion and target_moment")
    return Stack(np.stack(factors), np.array(samples))


def _triangle(rows: Array) -> Array:
    """R of the QR of rows (..., N, M)."""
    return np.asarray(np.linalg.qr(rows, mode="r"), dtype=np.float64)


def total(data: Stack) -> Array:
    """Triangular factors (6, P + 1, P + 1) of all rows of each joint."""
    rows = data.factors.swapaxes(0, 1)
    return _triangle(rows.reshape(6, -1, rows.shape[-1]))


def identify(data: Stack, prior: Array, width: Array) -> Estimate:
    """Weighted least squares with a ridge towards a prior.

    prior, width: (P,), mean and standard deviation of π before the data. The noise of each joint,
    whose inverse squares are the weights, is what the fit leaves.
    Raises ValueError for a single block, whose scatter cannot be told.
    """
    if len(data.samples) < 2:
        raise ValueError(
            "standard errors need two blocks of samples or more; "
            "record a longer motion with target_moment"
        )
    rows, count = total(data), data.samples.sum()
    noise = _noise(rows, prior, np.full(6, count))
    for _ in range(10):
        parameters, spread = solve(rows, noise, prior, width)
        spent = (np.linalg.norm(rows[..., :-1] @ spread, axis=(1, 2)) / noise) ** 2
        noise = _noise(rows, parameters, count - spent)
    parameters, spread = solve(rows, noise, prior, width)
    scatter = _scatter(data.factors / noise[:, None, None], parameters, spread, width)
    return Estimate(parameters, scatter, spread, width, noise)


def torque_error(blocks: Blocks, parameters: Array) -> Array:
    """MAE (6,) [Nm] of the torques Y π of other blocks; parameters: (P,)."""
    torques = [(regressor @ parameters, torque) for regressor, torque in blocks]
    estimate, reference = map(np.concatenate, zip(*torques, strict=True))
    return mean_absolute_error(estimate, reference)


def solve(rows: Array, noise: Array, prior: Array, width: Array) -> tuple[Array, Array]:
    """π (P,) and S (P, P), covariance S Sᵀ, from the factors of all rows and the prior."""
    weighted = (rows / noise[:, None, None]).reshape(-1, rows.shape[-1])
    ridge = np.column_stack([np.diag(1 / width), prior / width])
    factor = _triangle(np.concatenate([weighted, ridge]))[:-1]
    spread = solve_triangular(factor[:, :-1], np.eye(len(prior)))
    return spread @ factor[:, -1], spread


def prior_share(groups: Array, spread: Array, width: Array) -> Array:
    """How much of the variance of groups π (B,) comes from the prior, not from the rows: 0 to 1."""
    root = groups @ spread
    from_prior = root @ (spread / width[:, None]).T
    return np.sum(from_prior**2, axis=1) / np.sum(root**2, axis=1)


def _noise(rows: Array, parameters: Array, freedom: Array) -> Array:
    """Standard deviation (6,) of what a fit leaves, with degrees of freedom (6,)."""
    left = np.linalg.norm(rows @ np.append(-parameters, 1.0), axis=1)
    return np.maximum(left / np.sqrt(np.maximum(freedom, 1.0)), FINEST)


def _scatter(factors: Array, parameters: Array, spread: Array, width: Array) -> Array:
    """By the jackknife: how the estimate changes when any one block is missing; and the prior's.

    With A the rows of a block times S, and e what the fit leaves of them, it changes by
    S (1 - AᵀA)⁻¹ Aᵀ e.
    """
    rows = factors.reshape(len(factors), -1, factors.shape[-1])
    seen = rows[..., :-1] @ spread
    gradient = seen.mT @ (rows @ np.append(-parameters, 1.0))[..., None]
    missing = np.eye(len(spread)) - seen.mT @ seen
    changes = np.linalg.solve(missing, gradient)[..., 0] @ spread.T
    from_prior = spread / width[:, None] @ spread.T
    return np.concatenate([changes * np.sqrt(1 - 1 / len(changes)), from_prior])
