"""Friction of joints at steady velocities under a load, the sum of all terms of a fit."""

from collections.abc import Iterator, Sequence

import numpy as np

from ur5lib.identification.estimation import physical_values
from ur5lib.identification.regression import half_width, spread
from ur5lib.identification.samples import CurrentSamples, Smooth, joint_samples
from ur5lib.records.friction import (
    MAX_PRIOR_SHARE,
    TOTAL,
    CoefficientEstimate,
    CurrentFit,
    JointFit,
    Parameter,
)
from ur5lib.robots.friction import JointMotion, friction_columns
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

# Totals are stated at these velocities, in positive direction; 0: as the joint begins to move.
STATED_VELOCITIES = np.array([0.0, 0.1, 0.5, 1.0])  # rad/s


def mean_load(records: Sequence[CurrentSamples], smooth: Smooth, terms: Sequence[str]) -> Array:
    """Return the mean size (n,) [Nm] of the links' torque on each joint in motion; terms: of the
    fit.

    NaN for a joint that does not move.
    """
    return np.array(
        [
            np.abs(own.columns[own.moving, 0]).mean() if own.moving.any() else np.nan
            for own in joint_samples(records, smooth, terms)
        ]
    )


def fastest(records: Sequence[CurrentSamples]) -> Array:
    """Return the largest speed (n,) [rad/s] of each joint."""
    speeds: Array = np.max([np.nanmax(np.abs(record.qd), axis=0) for record in records], axis=0)
    return speeds


def friction_curve(model: JointFit, qd: Array, load: float) -> Array:
    """Return a joint's friction (N,) [Nm] at steady velocities (N,) [rad/s], by its parameters.

    load: size of the torque that its gear transmits [Nm].
    """
    columns = steady_columns(model.terms, qd, np.sign(qd), load)
    curve: Array = columns @ physical_values(model.estimate.coefficients)[2:]
    return curve


def steady_columns(terms: Sequence[str], qd: Array, direction: Array, load: float | Array) -> Array:
    """Return the columns (N, M) of friction at steady velocities (N,) [rad/s]; see `JointMotion`.

    direction: (N,), of dry friction, which a joint has as it begins to move, too.
    """
    steady = JointMotion(np.zeros_like(qd), qd, np.full_like(qd, load), direction)
    return friction_columns(steady, terms)


def total_friction(fit: CurrentFit, load: Array) -> list[Parameter]:
    """Return the friction [Nm] of each joint at STATED_VELOCITIES, in positive direction.

    load: (n,) [Nm], as of `mean_load`; a joint with NaN has no total. A total is determined where
    the data contribute more to it than other arms do, and show its sign.
    """
    return [
        total
        for joint, (model, size) in enumerate(zip(fit.joints, load.tolist(), strict=True), start=1)
        if np.isfinite(size)
        for total in _totals(joint, model, size, fit.units)
    ]


def steady_friction(model: JointFit, qd: Array, load: float | Array) -> tuple[Array, Array]:
    """Return a joint's friction (V,) [Nm] at steady velocities (V,) [rad/s], and its standard
    error, which includes the deviation between days.

    At 0, it is the friction at which the joint begins to move forwards; load: size of the torque
    [Nm] that its gear transmits, of all or each.
    """
    columns = steady_columns(model.terms, qd, np.where(qd < 0, -1.0, 1.0), load)
    value, error, unseen = _sums(model, columns)
    return value, np.hypot(error, unseen)


def _sums(model: JointFit, columns: Array) -> tuple[Array, Array, Array]:
    """Return sums (V,) of friction's parameters, their standard errors, and their standard
    deviation between days.

    columns: (V, M), factors of the parameters in each sum.
    """
    friction = physical_values(model.estimate.coefficients)[2:]
    # a day or recording differs by a share of friction, in all terms alike
    unseen = np.abs(columns @ (np.sign(friction) * model.unseen[2:]))
    return columns @ friction, _std_error(model.estimate, columns), unseen


def _totals(joint: int, model: JointFit, load: float, units: int) -> Iterator[Parameter]:
    """Yield the total friction of a joint, from 1, at each of STATED_VELOCITIES; units: number of
    the bootstrap's units.
    """
    qd, estimate = STATED_VELOCITIES, model.estimate
    columns = steady_columns(model.terms, qd, np.ones_like(qd), load)
    (value, error, unseen), shares = _sums(model, columns), _shares(estimate, columns)
    half = np.hypot(half_width(error, units, shares[0]), NORMAL95 * unseen)
    rows = np.stack([value, np.hypot(error, unseen), value - half, value + half, *shares], axis=1)
    for velocity, row in zip(qd.tolist(), rows.tolist(), strict=True):
        number, std, low, high, prior, arm, day, run = row
        name, is_determined = f"{TOTAL}{velocity:g}", prior < MAX_PRIOR_SHARE and low > 0
        shares_of_it = prior, arm, day, run
        yield Parameter(joint, name, number, std, (low, high), *shares_of_it, is_determined)


def _std_error(estimate: CoefficientEstimate, columns: Array) -> Array:
    """Return the standard errors √(J Σ Jᵀ) (V,) of the sums J p of friction's parameters p.

    columns: J (V, M). Σ has the standard errors of p, and the correlations of the bootstrap's
    replicates, scaled so that each parameter spreads by its standard error.
    """
    drawn = physical_values(estimate.replicates)[:, 2:]
    error, own = estimate.std_error[2:], spread(drawn)
    scale = np.divide(error, own, out=np.zeros_like(error), where=own > 0)
    return spread((drawn * scale) @ columns.T)


def _shares(estimate: CoefficientEstimate, columns: Array) -> Array:
    """Return the shares (4, V) of the information on sums of parameters, see `shares_of_knowledge`;
    columns: (V, M).

    Each parameter's shares are weighted by the square of its error in the sum.
    """
    squares = (columns * estimate.std_error[2:]) ** 2 + np.finfo(float).tiny
    shares: Array = estimate.shares[:, 2:] @ (squares / squares.sum(axis=1, keepdims=True)).T
    return shares
