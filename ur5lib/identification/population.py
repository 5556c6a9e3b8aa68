"""What the joints of all measured arms have in common, as a prior of one more arm.

Each trait y of a joint (the logarithm of a positive one) is y = x β + a + j + e: a trend over the
motor's largest torque, and deviations of the arm and of the joint, with errors e of known size.
β and both spreads come from their marginal likelihood (empirical Bayes), given which y of a
further arm is normal, and correlated among its joints.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ur5lib.robots.description import Robot, joint_sizes
from ur5lib.robots.population import Measured, Trait, read_measured
from ur5lib.timeseries.arrays import Array

USUAL_TORQUE = 54.0  # Nm, where a trend has the value of its constant
GRID = np.geomspace(0.01, 1.0, 20)  # of spreads
TAIL = 4.0  # degrees of freedom of the joints' deviations, so that a strange joint counts less
ROUNDS = 5


@dataclass(frozen=True)
class Kind:
    """How a trait is compared between joints.

    logarithm: whether its logarithm is; trend: whether it grows with a power of the largest torque;
    centred: whether its mean is zero; unit_of: the trait whose trend is its unit, if any; widest:
    scale of the half-normal priors of its spreads, since few arms hardly show how arms differ.
    """

    logarithm: bool = True
    trend: bool = False
    centred: bool = False
    unit_of: str = ""
    widest: float = 0.15

    def columns(self, torque_max: Array) -> Array:
        """Return x (n, P) of joints with these largest torques (n,) [Nm]."""
        power = np.log(torque_max / USUAL_TORQUE)
        columns = [] if self.centred else [np.ones_like(power), *([power] if self.trend else [])]
        return np.array(columns).reshape(-1, len(power)).T


KINDS: dict[Trait, Kind] = {
    "torque_constant": Kind(centred=True),  # relative to the motor's of that size
    "coulomb": Kind(trend=True),
    "viscous": Kind(trend=True),
    "load": Kind(logarithm=False, widest=0.03),
    # its sign depends on the joint's positive direction
    "offset": Kind(logarithm=False, centred=True, unit_of="coulomb"),
}


@dataclass(frozen=True)
class Spread:
    """Mean and spread of one trait: trend β (P,) with covariance (P, P); standard deviations of
    arms and of joints; joints, arms: how many were measured.
    """

    kind: Kind
    trend: Array
    covariance: Array
    arm: float
    joint: float
    joints: int
    arms: int

    def of_arm(self, torque_max: Array) -> tuple[Array, Array]:
        """Return mean (n,) and covariance (n, n) of y of one more arm's joints."""
        columns = self.kind.columns(torque_max)
        doubt = columns @ self.covariance @ columns.T
        return columns @ self.trend, doubt + self.arm**2 + self.joint**2 * np.eye(len(torque_max))


@dataclass(frozen=True)
class Typical:
    """A trait of an arm's joints before any recording: mean (n,) and covariance (n, n), SI units.

    Of the torque constant, it is relative to the family's. arms: how many were measured.
    """

    mean: Array
    covariance: Array
    arms: int = 0


Population = Mapping[str, Spread]


def population_of(files: Sequence[str], study: str) -> Population | None:
    """Return what other studies' arms have in common; files: of measured arms, at most one.

    Raises InputError where a file is no such file.
    """
    measured = [read_measured(Path(path)).without(study) for path in files]
    return fit_population(measured[0]) if measured else None


def fit_population(measured: Measured) -> Population:
    """Return mean and spread of each trait that was measured on any arm."""
    spreads: dict[str, Spread] = {}
    for name, kind in KINDS.items():
        rows = [
            (*own.values[name], own.torque_max, own.family_constant or np.nan, label)
            for label, arm in enumerate(measured.arms)
            for own in arm.joints.values()
            if name in own.values and (own.family_constant or name != "torque_constant")
        ]
        if rows:
            value, error, torque_max, constant, arm = np.array(rows, dtype=float).T
            relative = name == "torque_constant"  # to the family's
            unit = constant if relative else _trend(spreads, kind.unit_of, torque_max)
            value, error = value / unit, error / unit
            if kind.logarithm:
                value, error = np.log(value), error / value
            spreads[name] = _fit(kind, value, error, torque_max, arm)
    return spreads


def typical_of(robot: Robot, population: Population | None) -> dict[str, Typical]:
    """Return the traits of an arm's joints, none where they have no motor of the measured sizes."""
    if population is None or not {*robot.joints} <= {*joint_sizes()}:
        return {}
    return typical_arm(population, np.array(robot.torque_limits()))


def typical_arm(population: Population, torque_max: Array) -> dict[str, Typical]:
    """Return the traits of one more arm's joints; torque_max: (n,) [Nm]."""
    found = {}
    for name, spread in population.items():
        mean, covariance = spread.of_arm(torque_max)
        # of a logarithm, to first order
        scale = _trend(population, spread.kind.unit_of, torque_max)
        if spread.kind.logarithm:
            mean = scale = np.exp(mean)
        else:
            mean = scale * mean
        found[name] = Typical(mean, covariance * np.outer(scale, scale), spread.arms)
    return found


def _trend(spreads: Mapping[str, Spread], name: str, torque_max: Array) -> Array:
    """Return the trend (n,) of a trait in its unit, 1 for no trait."""
    if not name:
        return np.ones_like(torque_max)
    own = spreads[name]
    return np.exp(own.kind.columns(torque_max) @ own.trend)


def _fit(kind: Kind, value: Array, error: Array, torque_max: Array, arm: Array) -> Spread:
    """Fit trend and spreads; value, error: y and its standard error, arm: labels, (n,) each.

    The spreads are averaged over a grid by their likelihood, since few arms hardly determine them.
    """
    columns, of_arm = kind.columns(torque_max), np.equal.outer(arm, np.unique(arm)).astype(float)
    arms, joints = (grid.ravel() ** 2 for grid in np.meshgrid(GRID, GRID))  # (G,), variances
    tails = np.ones_like(value)
    for _ in range(ROUNDS):
        own = joints[:, None] * tails + error**2  # (G, n)
        trends, doubts, likelihood = _generalised_least_squares(columns, value, own, arms, of_arm)
        # posterior of the spreads, under half-normal priors; steps of the grid grow with them
        log_weight = likelihood - (arms + joints) / (2 * kind.widest**2)
        weight = np.exp(log_weight - log_weight.max()) * np.sqrt(arms * joints)
        weight /= weight.sum()
        trend, of_arms, of_joints = (weight @ each for each in (trends, arms, joints))
        # Student's t as a mixture of normals: the expected variance of each joint's deviation
        residual = value - columns @ trend
        mean_of_arm = of_arm @ ((residual @ of_arm) / of_arm.sum(axis=0))  # (n,)
        squared = (residual - mean_of_arm) ** 2
        tails = (TAIL + (squared - error**2).clip(0) / of_joints) / (TAIL + 1)
    spread = trends - trend
    doubt = np.einsum("g,gij->ij", weight, doubts + spread[:, :, None] * spread[:, None])
    heavy = of_joints * tails.mean()
    counts = len(value), of_arm.shape[1]
    return Spread(kind, trend, doubt, float(np.sqrt(of_arms)), float(np.sqrt(heavy)), *counts)


def _generalised_least_squares(
    columns: Array, value: Array, own: Array, arms: Array, of_arm: Array
) -> tuple[Array, Array, Array]:
    """Solve for each of G covariances diag(own) + arms E Eᵀ of the values (n,).

    columns: X (n, P); own: (G, n); arms: (G,); of_arm: E (n, A). Its inverse is, with W = 1 / own,
    W - W E (1 / arms + Eᵀ W E)⁻¹ Eᵀ W (Woodbury). Returns the trend (G, P), its covariance, and
    the restricted log-likelihood (G,).
    """
    sides = np.column_stack([columns, value])  # X, y
    weighted = sides.T[None] / own[:, None, :]  # (G, P + 1, n)
    sums = weighted @ of_arm  # (G, P + 1, A)
    within = 1 / arms[:, None] + (1 / own) @ of_arm  # (G, A)
    products = weighted @ sides - np.einsum("gpa,gqa->gpq", sums / within[:, None], sums)
    information, right, squares = products[:, :-1, :-1], products[:, :-1, -1], products[:, -1, -1]
    doubt = np.asarray(np.linalg.inv(information), dtype=np.float64)
    trend = np.einsum("gij,gj->gi", doubt, right)
    explained = np.einsum("gi,gi->g", trend, right)
    determinants = np.log(own).sum(axis=1) + np.log(arms[:, None] * within).sum(axis=1)
    determinants += np.linalg.slogdet(information)[1]
    return trend, doubt, (explained - squares - determinants) / 2
