"""Contacts that the gate misses: how probable one is while the gate is shut, and how large.

A contact along one axis, F ~ N(0, P), is missed with probability exp(-z² / 2 κ²), z² = xᵀ S⁻¹ x,
which compares its torque x = Jᵀ F with the covariance S of what hides it: dry friction at rest, the
background in motion. Then the missed contacts are N(0, C), 1 / C = 1 / P + (J S⁻¹ Jᵀ) / κ² on that
axis, and they are a share sqrt(C / P) of all. κ is learnt from trial contacts.
"""

import numpy as np
from scipy.special import erfc

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import NORMAL95

KNOWN_TO = 0.5  # standard deviation of log κ without trial contacts
HALVINGS = 30  # of an interval that contains a quantile


def missed_contacts(jacobian: Array, hidden: Array, prior: ContactPrior) -> tuple[Array, Array]:
    """Return the share (N, 6) of contacts along or about each axis alone that are missed, and
    their variance (N, 6), for contacts of the usual size.

    jacobian: (N, 6, 6); hidden: κ² S (N, 6, 6) [Nm²].
    """
    usual = np.diag(prior.usual())
    # diagonal of J S⁻¹ Jᵀ / κ²
    information = np.einsum("nij,nji->ni", jacobian, np.linalg.solve(hidden, jacobian.mT))
    variance = 1 / (1 / usual + information)
    return np.sqrt(variance / usual), variance


def probability_while_shut(missed: Array, found: Mask, period: float, prior: ContactPrior) -> Array:
    """Return the probability (N, 6) of a contact along each axis at samples of a shut gate.

    It is c m / (c m + 1 - c). missed: m (N, 6), shares of contacts that are missed; found: (N,),
    samples in contacts; period: [s]. The share c of time in contact is that of the run together
    with one usual contact and pause: where some contacts are found, more are missed. Each axis
    reckons with contacts along it alone, since no direction is known.
    """
    contact, whole = prior.duration / period, (prior.duration + prior.pause) / period
    seen = (1 - missed[:, :3]).mean(axis=1).sum()
    share = min(1.0, float((found.sum() + contact) / (seen + whole)))
    return share * missed / (share * missed + 1 - share)


def mixture_std(probability: Array, missed: Array, free: Array) -> Array:
    """Return the standard deviation (N, K) whose ± 1.96 is the 95 % band of a mixture.

    With a probability (N, K) the value is that of a missed contact, otherwise that of a free arm;
    missed, free: variances (N, K) and (K,) of both, whose means are zero.
    """
    contact, rest = np.sqrt(missed), np.broadcast_to(np.sqrt(free), missed.shape)
    low, high = NORMAL95 * np.minimum(contact, rest), NORMAL95 * np.maximum(contact, rest)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        # P(|x| > middle) of both
        outside = probability * erfc(middle / contact / np.sqrt(2))
        outside += (1 - probability) * erfc(middle / rest / np.sqrt(2))
        low, high = np.where(outside > 0.05, middle, low), np.where(outside > 0.05, high, middle)
    return high / NORMAL95


def largest_missed(size: Array, missed: Mask, weight: float, usual: float) -> float:
    """Return κ, the size at which a contact is missed with probability exp(-1/2).

    size: z (M,), of samples in trial contacts; missed: (M,); weight: of one sample, in independent
    trials; usual: κ without any trial. The most probable κ, log κ ~ N(log usual, 0.5²).
    """
    from scipy.optimize import minimize_scalar  # slow to import; most steps need none

    def cost(log_kappa: float) -> float:
        # -log p(missed) = z² / 2 κ²
        hidden = np.maximum(size**2 * np.exp(-2 * log_kappa) / 2, 1e-9)
        likelihood = np.where(missed, hidden, -np.log(-np.expm1(-hidden))).sum()
        return float(weight * likelihood + ((log_kappa - np.log(usual)) / KNOWN_TO) ** 2 / 2)

    return float(np.exp(minimize_scalar(cost, bounds=(-3, 6), method="bounded").x))
