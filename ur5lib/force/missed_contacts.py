"""Contacts that the gate misses: how probable one is while the gate is shut, and how large.

A contact along one axis, F ~ N(0, P), is missed with probability exp(-z² / 2 κ²), z² = xᵀ S⁻¹ x:
its torque x = Jᵀ F in standard deviations of what hides it, S, which is dry friction at rest and
the background in motion. Then the missed contacts are N(0, C), 1 / C = 1 / P + (J S⁻¹ Jᵀ) / κ² on
that axis, and they are a share sqrt(C / P) of all.
"""

import numpy as np
from scipy.special import erfc

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import NORMAL95

MISSED_DEVIATIONS = 2.0  # κ: deviations up to which most contacts are missed
BISECTION_STEPS = 30  # halvings of an interval that contains a quantile


def missed_contacts(jacobian: Array, hidden: Array, prior: ContactPrior) -> tuple[Array, Array]:
    """Return, by axis, the share (N, 6) of usual contacts that the gate misses, and the variance
    (N, 6) [N², N²m²] of the missed ones.

    jacobian: (N, 6, n); hidden: κ² S (N, n) [N²m²], of the torque that hides a contact.
    """
    usual = np.diag(prior.usual())
    # diagonal of J S⁻¹ Jᵀ / κ²
    information = (jacobian**2 / hidden[:, None]).sum(axis=2)
    variance = 1 / (1 / usual + information)
    return np.sqrt(variance / usual), variance


def probability_while_shut(
    missed: Array, in_contact: Mask, period: float, prior: ContactPrior
) -> Array:
    """Return the probability (N, 6) of a missed contact along each axis while the gate is shut: c m
    / (c m + 1 - c).

    missed: m (N, 6), shares of contacts that are missed; in_contact: (N,), samples in contacts;
    period: [s]. c is the share of time in contact in the run plus one usual contact and pause: the
    more contacts are found, the more are missed. Each axis assumes contacts along it alone, since
    no direction is given.
    """
    contact = prior.unseen_duration / period
    cycle = contact + prior.pause / period
    # c = (s + n) / (d + m): s samples in contact, d detectable on average, n and m of one cycle
    detectable = (1 - missed[:, :3]).mean(axis=1).sum()
    share = min(1.0, float((in_contact.sum() + contact) / (detectable + cycle)))
    return share * missed / (share * missed + 1 - share)


def mixture_std(probability: Array, missed_variance: Array, free_variance: Array) -> Array:
    """Return σ (N, K), with which ± 1.96 σ is the 95 % band of a mixture.

    With a probability (N, K) the value is that of a missed contact, otherwise that of a free arm;
    missed_variance, free_variance: variances (N, K) and (K,) of both, about zero.
    """
    missed_std, free_std = (
        np.sqrt(missed_variance),
        np.broadcast_to(np.sqrt(free_variance), missed_variance.shape),
    )
    low = NORMAL95 * np.minimum(missed_std, free_std)
    high = NORMAL95 * np.maximum(missed_std, free_std)
    for _ in range(BISECTION_STEPS):
        middle = (low + high) / 2
        # P(|x| > middle) of both
        outside = probability * erfc(middle / missed_std / np.sqrt(2))
        outside += (1 - probability) * erfc(middle / free_std / np.sqrt(2))
        low, high = np.where(outside > 0.05, middle, low), np.where(outside > 0.05, high, middle)
    return high / NORMAL95
