"""Covariances of joint torques from Gaussian processes of energies [Giacomuzzo et al. 2024].

Kinetic and potential energy, T and U, are independent processes with covariances k_T and k_U. The
torques are linear in them, by Lagrange's operator G = d/dt ∂/∂q̇ - ∂/∂q of T - U, and therefore also
a process, with covariances G G' (k_T + k_U), where G' acts on the second motion. With
p_k = 1 - w_k (1 - cos(q_k - q'_k)) of a revolute joint,

    k_T = Σ_l (q̇ᵀ S_l q̇')² Π_k≤l p_lk²   (S_l diagonal: the joints up to l move link l)
    k_U = s² Π_k p_k

These covariances describe the energies of any arm, which are polynomials: squares of speeds times
cosines and sines of the joints, at most squared in T, linear in U.
"""

from typing import NamedTuple

import torch
from torch import Tensor

from ur5lib.timeseries.arrays import Array


class Motion(NamedTuple):
    """The motion of n joints at N samples: q, q̇, q̈, (n, N) each [rad, rad/s, rad/s²]."""

    q: Tensor
    qd: Tensor
    qdd: Tensor

    @classmethod
    def of(cls, columns: Array) -> "Motion":
        """Return motions from q, q̇, q̈ side by side (N, 3 n)."""
        return cls(*torch.as_tensor(columns).T.chunk(3))

    def of_joints(self, count: int) -> "Motion":
        """Return the motion of the first joints."""
        return Motion(*(values[:count] for values in self))


class Energies(NamedTuple):
    """The constants of the covariances of an arm's kinetic and potential energy.

    speeds: S, a row for each link (n, n) [kg m²]; turns: w of k_T (n, n); size: s [J]; postures: w
    of k_U (n,).
    """

    speeds: Tensor
    turns: Tensor
    size: Tensor
    postures: Tensor


class Polynomial(NamedTuple):
    """The product P = Π_k p_k^d between N and M postures, with its derivatives.

    value: P (N, M); slope: r = ∂ ln P/∂q (n, N, M); bend: the diagonal ∂² ln P/∂q² (n, N, M).
    """

    value: Tensor
    slope: Tensor
    bend: Tensor

    def second(self, vectors: Tensor) -> Tensor:
        """Return H v of H = ∂²P/∂q² = P (r rᵀ + diag(bend)); v: (..., n, N or 1, M or 1)."""
        along = (self.slope * vectors).sum(-3, keepdim=True)
        return self.value * (self.slope * along + self.bend * vectors)


def polynomial(first: Tensor, second: Tensor, share: Tensor, degree: int) -> Polynomial:
    """Return P of postures (n, N) and (n, M) [rad]; share: w (n,), within (0, 1)."""
    turned, share = first[:, :, None] - second[:, None], share[:, None, None]
    factor = 1 - share * (1 - turned.cos())
    slope, bend = -share * turned.sin() / factor, -share * turned.cos() / factor
    return Polynomial((factor**degree).prod(0), degree * slope, degree * (bend - slope**2))


def torque_covariance(first: Motion, second: Motion, energies: Energies, right: Tensor) -> Tensor:
    """Return the covariances (C, n, N, M) [N²m²] of torques at N motions with those at M others.

    right: (C, n, M), coefficients of C linear combinations of the second motion's torques;
    `each_torque` for the torques themselves.
    """
    right = right[:, :, None]
    postures = polynomial(first.q, second.q, energies.postures, 1)
    result = -(energies.size**2) * postures.second(right)
    for count, (speed, turn) in enumerate(zip(energies.speeds, energies.turns, strict=True), 1):
        motions = first.of_joints(count), second.of_joints(count)
        result[:, :count] += kinetic(*motions, speed[:count], turn[:count], right[:, :count])
    return result


def kinetic(first: Motion, second: Motion, speed: Tensor, turn: Tensor, right: Tensor) -> Tensor:
    """Return G G' (q̇ᵀ S q̇')² P of a link, as `torque_covariance`; speed, turn: S, w (n,).

    As P depends on q - q', ∂P/∂q' = -∂P/∂q.
    """
    (v, a), (w, b) = (  # q̇ᵀ S q̇', q̇ᵀ S q̈'; q̈ᵀ S q̇', q̈ᵀ S q̈'
        ((speed[:, None] * rate).T @ second.qd, (speed[:, None] * rate).T @ second.qdd)
        for rate in (first.qd, first.qdd)
    )
    P = polynomial(first.q, second.q, turn, 2)
    qd, qdd = first.qd[:, :, None], first.qdd[:, :, None]
    other_qd, other_qdd, speed = second.qd[:, None], second.qdd[:, None], speed[:, None, None]
    gradient, bent = P.value * P.slope, P.second(qd)
    # derivatives of P along the first motion, the second, and both
    ahead, back = (gradient * qd).sum(0), -(gradient * other_qd).sum(0)
    both = -(bent * other_qd).sum(0)

    def combined(vectors: Tensor) -> Tensor:
        return (vectors * right).sum(1, keepdim=True)

    by_acceleration = combined(speed * (P.value * qdd + ahead * qd))
    by_speed = combined(speed * (back * qdd + both * qd) + w * gradient + v * bent)
    alone = (b * P.value + a * ahead + w * back + v * both) * right
    rates = speed * (other_qdd * by_acceleration + other_qd * by_speed + alone)
    slopes = (a * gradient - v * P.second(other_qd)) * combined(speed * qd)
    return 2 * (rates - slopes) - v**2 * P.second(right)


def each_torque(motions: Motion) -> Tensor:
    """Return the coefficients (n, n, M) with which `torque_covariance` returns the covariances of
    each torque of M motions.
    """
    joints, samples = motions.q.shape
    return torch.eye(joints, dtype=motions.q.dtype)[:, :, None].expand(-1, -1, samples)
