"""The wrench of one contact: by a prior that its own samples choose, and without any."""

from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.gate import diagonal
from ur5lib.force.map_estimate import Posterior, regularised_wrench
from ur5lib.timeseries.arrays import Array, Mask

ROUNDS = 30  # of learning a contact's size; most settle in ten
WEIGHT = 1.0  # of the usual contact, in independent samples


class Wrench(NamedTuple):
    """Mean (n, 6) [N, Nm] and variance (n, 6) of the wrench at each sample of a contact."""

    mean: Array
    variance: Array


def contact_wrench(
    torque: Array,
    jacobian: Array,
    noise: Array,
    worth: float,
    period: float,
    prior: ContactPrior,
    size: Array | None = None,
) -> Wrench:
    """F̂ᵐᵃᵖ of one contact, and how far it may be off.

    torque: external, less its background, (n, 6) [Nm], rows of NaN where it is unknown: there the
    wrench is zero with the contact's size as its variance; jacobian: (n, 6, 6); noise: (n, 6, 6)
    [Nm²]; worth: of an independent value, that each sample has; period: [s]; size: covariance
    (6, 6) of the wrench, None to learn it.
    """
    if size is None:
        size = learned_size(torque, jacobian, noise, worth, prior)
    estimate = regularised_wrench(torque, jacobian, noise, size)
    wrench = estimate.mean / prior.efficiency
    variance = _diagonal(estimate.covariance) + _lost(estimate, jacobian, prior)
    variance = variance / prior.efficiency**2 + (prior.efficiency_std * wrench) ** 2
    change = _change(wrench, finite_rows(torque), period)
    variance = variance + (prior.resolution * change) ** 2
    # Torques hardly part a moment from a force: a lever of some centimetres may go unnoticed.
    force = np.linalg.norm(wrench[:, :3], axis=1)
    variance[:, 3:] += (prior.levers[1] * force[:, None]) ** 2
    return Wrench(wrench, variance)


def learned_size(
    torque: Array, jacobian: Array, noise: Array, worth: float, prior: ContactPrior
) -> Array:
    """Covariance P (6, 6) of a contact's wrench, by its own samples; arguments as above.

    P maximises the evidence by expectation-maximisation, the usual contact counting as one
    independent sample: P = (Σ w E[F Fᵀ] + P_usual) / (w n + 1). Forces have a direction, moments
    only a size: they take up what a force at the origin of frame 6 cannot explain.
    """
    known = finite_rows(torque)
    torque, jacobian, noise = torque[known], jacobian[known], noise[known]
    size, count = prior.unknown(), worth * len(torque)
    for _ in range(ROUNDS):
        estimate = regularised_wrench(torque, jacobian, noise, size)
        square = estimate.mean.T @ estimate.mean + estimate.covariance.sum(axis=0)
        square = (worth * square + WEIGHT * prior.usual()) / (count + WEIGHT)
        size = np.zeros((6, 6))
        size[:3, :3] = square[:3, :3]
        size[3:, 3:] = np.eye(3) * np.trace(square[3:, 3:]) / 3
    return size


def least_squares_wrench(torque: Array, jacobian: Array, noise: Array) -> Wrench:
    """Prior-free rival of F̂ᵐᵃᵖ: F = (J_v S⁻¹ J_vᵀ)⁻¹ J_v S⁻¹ τ, a force without moment.

    Arguments as above; NaN where the torque is unknown. The baseline that a prior has to beat once
    a contact is known.
    """
    linear = jacobian[:, :3]
    weighted = np.linalg.solve(noise, linear.mT).mT
    covariance = np.asarray(np.linalg.pinv(weighted @ linear.mT, hermitian=True), np.float64)
    force = (covariance @ weighted @ torque[..., None])[..., 0]
    nothing = np.zeros_like(force)
    return Wrench(
        np.concatenate([force, nothing], axis=1),
        np.concatenate([_diagonal(covariance), nothing], axis=1),
    )


def _lost(estimate: Posterior, jacobian: Array, prior: ContactPrior) -> Array:
    """Variance (n, 6) by what each joint's load friction takes up or gives of this contact."""
    carried = (jacobian.mT @ estimate.mean[..., None])[..., 0]
    lost = diagonal((prior.load_friction * carried) ** 2)
    return _diagonal(estimate.gain @ lost @ estimate.gain.mT)


def _change(wrench: Array, known: Mask, period: float) -> Array:
    change = np.zeros_like(wrench)
    if known.sum() > 1:
        change[known] = np.gradient(wrench[known], period, axis=0)
    return change


def _diagonal(matrices: Array) -> Array:
    return np.diagonal(matrices, axis1=1, axis2=2)
