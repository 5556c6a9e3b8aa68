"""The most probable wrench of a contact: with a fixed prior, with a learnt one, or without."""

from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_prior import ContactPrior, wrench_covariance
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.gate import diagonal
from ur5lib.timeseries.arrays import Array, Mask

# The static wrench of a resting arm.
STATIC_SPEED = 0.05  # rad/s; below it, the torques of motion are far below friction
# Breakaway torque over a motor's largest; Coulomb friction of UR5 and UR10e is 0.04 to 0.06.
BREAKAWAY_SHARE = 0.1
MIN_CONSTANT_ERROR = 0.3  # relative error of a torque constant that nothing was fitted for
STATIC_FORCE = 7.0  # prior standard deviation, in typical forces
STATIC_LEVER = 0.1  # m; the prior's moment is its force at this lever
# The wrench of a contact.
# The typical covariance, times this, counts as one sample: with 1, small changes decide.
TYPICAL_SIZE_WEIGHT = 2.0
EM_ROUNDS = 15  # expectation-maximisation has this many rounds; most contacts converge in ten
# Of the deviation that the prior leaves where torques show a force: its learnt size contains their
# error.
PRIOR_SHARE = 0.8
UNRESOLVED_LEVER = 0.05  # m; stated moments err by the force times this lever


class Posterior(NamedTuple):
    """The posterior of a wrench: mean (N, 6), covariance (N, 6, 6), and gain (N, 6, n), with mean =
    gain τ of n joints.
    """

    mean: Array
    covariance: Array
    gain: Array


def regularised_wrench(torque: Array, jacobian: Array, noise: Array, prior: Array) -> Posterior:
    """Return argmin |tau - J^T F|²_S + |F|²_P = P J (J^T P J + S)^-1 tau, and its covariance.

    torque: external, (N, n) [Nm]; jacobian: (N, 6, n); noise: S, (N, n, n) [N²m²]; prior: P,
    (6, 6) or (N, 6, 6), zero moments for "force only". At a singularity, the unobservable
    direction keeps its prior. For a row of NaN, the mean is 0 and the covariance P.
    """
    measured = finite_rows(torque)
    # K = P J (Jᵀ P J + S)⁻¹, F = K τ, cov F = P - K Jᵀ P
    lever = prior @ jacobian  # P J (N, 6, n)
    transposed = np.linalg.solve(jacobian.mT @ lever + noise, lever.mT)
    gain = np.asarray(transposed, np.float64).mT * measured[:, None, None]
    mean = (gain @ np.where(measured[:, None], torque, 0.0)[..., None])[..., 0]
    return Posterior(mean, prior - gain @ lever.mT, gain)


def at_rest(qd: Array) -> Mask:
    """Return the samples (N,) of joints slower than `STATIC_SPEED`; qd: (N, 6) [rad/s]."""
    return np.asarray((np.abs(qd) < STATIC_SPEED).all(axis=1))


def torque_std(motor_torque: Array, constant_error: Array, torque_max: Array) -> Array:
    """Return the standard deviation (N, 6) [Nm] of the external torque of a resting arm.

    motor_torque: (N, 6) [Nm], by constants with the relative errors constant_error, (6,);
    torque_max: of the motors (6,) [Nm]. Friction lies anywhere within ± the breakaway torque.
    """
    # ± b, uniform: b / √3
    friction = BREAKAWAY_SHARE * torque_max / np.sqrt(3)  # of a uniform distribution
    return np.hypot(constant_error * motor_torque, friction)


def static_wrench(
    torque: Array, std: Array, jacobian: Array, typical_force: float
) -> tuple[Array, Array]:
    """Return the most probable wrench [F, n] of a resting arm and its standard deviation, (N, 6)
    [N, Nm].

    torque: external (N, joints) [Nm], J^T F, NaN where unknown; std: of it; jacobian:
    (N, 6, joints); typical_force: of contacts [N]. The prior has mean zero; the force deviates by
    STATIC_FORCE times the typical one, the moment by that at the lever STATIC_LEVER.
    """
    prior = wrench_covariance(STATIC_FORCE * typical_force, STATIC_LEVER)
    estimate = regularised_wrench(torque, jacobian, diagonal(std**2), prior)
    error = np.sqrt(np.linalg.diagonal(estimate.covariance))
    finite = (finite_rows(torque) & finite_rows(error))[:, None]
    return np.where(finite, estimate.mean, np.nan), np.where(finite, error, np.nan)


class ContactWrench(NamedTuple):
    """Mean (n, 6) [N, Nm] and variance (n, 6) of the wrench at each sample of a contact."""

    mean: Array
    variance: Array


def contact_wrench(
    torque: Array, jacobian: Array, noise: Array, worth: float, prior: ContactPrior
) -> ContactWrench:
    """Return F̂ᵐᵃᵖ of one contact and its variance.

    torque: Jᵀ F, of the contact alone, (n, m) [Nm] of m joints; where it is NaN, the wrench is zero
    with the prior's variance; jacobian: (n, 6, m); noise: S (n, m, m) [N²m²]; worth: independent
    values per sample, at most 1.
    """
    size = learned_size(torque, jacobian, noise, worth, prior)
    # F = P J (Jᵀ P J + S)⁻¹ τ
    estimate = regularised_wrench(torque, jacobian, noise, size)
    # torque noise, what the prior leaves, load friction, and a moment that is taken for a force
    noisy = np.linalg.diagonal(estimate.gain @ noise @ estimate.gain.mT)
    left = np.linalg.diagonal(estimate.covariance) - noisy
    unseen = left / np.diagonal(size)  # 1 along an axis that no torque shows
    variance = noisy + (PRIOR_SHARE**2 + (1 - PRIOR_SHARE**2) * unseen) * left
    variance = variance + _lever_variance(estimate, jacobian, prior)
    variance = variance + _load_friction_variance(estimate, jacobian, prior)
    # torques barely distinguish a moment from a force
    force = np.linalg.norm(estimate.mean[:, :3], axis=1)
    variance[:, 3:] += (UNRESOLVED_LEVER * force[:, None]) ** 2
    return ContactWrench(estimate.mean, variance)


def learned_size(
    torque: Array, jacobian: Array, noise: Array, worth: float, prior: ContactPrior
) -> Array:
    """Return the covariance P (6, 6) of a contact's wrench, learnt from its own samples; arguments
    as of `contact_wrench`.

    P maximises the evidence by expectation-maximisation, a contact of twice the typical covariance
    counting as one independent sample: P = (Σ w E[F Fᵀ] + 2 P_usual) / (w n + 1). Near a
    singularity, the torques lack a component, and P alone decides its size. The force part is a
    full matrix; the moment part is isotropic and tied to the force by the prior's lever, with the
    weight `lever_weight`. Otherwise a moment would explain the torque that friction took from a
    short contact, and a small change of the prior would give another force.
    """
    measured = finite_rows(torque)
    torque, jacobian, noise = torque[measured], jacobian[measured], noise[measured]
    size, count = prior.unknown(), worth * len(torque)
    for _ in range(EM_ROUNDS):
        # expectation: Σ E[F Fᵀ] = Σ (F̂ F̂ᵀ + cov F)
        estimate = regularised_wrench(torque, jacobian, noise, size)
        square = estimate.mean.T @ estimate.mean + estimate.covariance.sum(axis=0)  # (6, 6)
        # maximisation: P = (w Σ E[F Fᵀ] + 2 P_usual) / (w n + 1)
        square = (worth * square + TYPICAL_SIZE_WEIGHT * prior.usual()) / (count + 1)
        size = np.zeros((6, 6))
        size[:3, :3] = square[:3, :3]
        usual_moment, moment = prior.lever**2 * np.trace(square[:3, :3]), np.trace(square[3:, 3:])
        moment = (prior.lever_weight * usual_moment + count * moment) / (prior.lever_weight + count)
        size[3:, 3:] = np.eye(3) * moment / 3
    return size


def least_squares_wrench(torque: Array, jacobian: Array, noise: Array) -> ContactWrench:
    """Return a force without moment by least squares, without prior, and its variance: F = (J_v S⁻¹
    J_vᵀ)⁻¹ J_v S⁻¹ τ.

    Arguments as of `contact_wrench`; NaN where the torque is unknown. F̂ᵐᵃᵖ is compared with it in
    the same contacts.
    """
    linear = jacobian[:, :3]  # J_v (n, 3, m)
    # J_v S⁻¹, then cov F = (J_v S⁻¹ J_vᵀ)⁻¹
    weighted = np.linalg.solve(noise, linear.mT).mT  # (n, 3, m)
    covariance = np.asarray(np.linalg.pinv(weighted @ linear.mT, hermitian=True), np.float64)
    force = (covariance @ weighted @ torque[..., None])[..., 0]  # (n, 3)
    nothing = np.zeros_like(force)
    return ContactWrench(
        np.concatenate([force, nothing], axis=1),
        np.concatenate([np.linalg.diagonal(covariance), nothing], axis=1),
    )


def _load_friction_variance(estimate: Posterior, jacobian: Array, prior: ContactPrior) -> Array:
    """Return the variance (n, 6) of the wrench due to each joint's friction under this contact's
    load.
    """
    # cov τ_lost = diag((c Jᵀ F)²), c of each joint, propagated by the gain: K cov τ_lost Kᵀ
    carried = (jacobian.mT @ estimate.mean[..., None])[..., 0]  # Jᵀ F (n, m)
    lost = diagonal((prior.load_friction * carried) ** 2)
    return np.linalg.diagonal(estimate.gain @ lost @ estimate.gain.mT)


def _lever_variance(estimate: Posterior, jacobian: Array, prior: ContactPrior) -> Array:
    """Return the variance (n, 6) of the wrench due to an unknown moment of |F| times the lever."""
    # K J_wᵀ cov n J_w Kᵀ, cov n = (lever |F|)² I
    moment = prior.lever * np.linalg.norm(estimate.mean[:, :3], axis=1)
    spread = estimate.gain @ jacobian[:, 3:].mT * moment[:, None, None]  # (n, 6, 3)
    return np.asarray((spread**2).sum(axis=2))
