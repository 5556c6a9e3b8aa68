"""Which place of the arm a force acts on, by the torques alone; or that they cannot tell.

A force F without a moment at a place p leaves τ = J_pᵀ F + e in the joints. With F ~ N(0, s² I) of
an unknown size s and e ~ N(0, S), p(τ | place) = Σ_s p(s) N(0, S + s² J_pᵀ J_p), and places are
compared by this likelihood. The size is left open: otherwise, weak contacts anywhere would be
ascribed to the place whose forces do least in the joints. Joints beyond the touched link carry
nothing; where two places explain the torques as well, none is named.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import logsumexp, softmax

from ur5lib.force.gate import log_density
from ur5lib.timeseries.arrays import Array

SURE = 0.95  # least probability of a link that is named


def place_probabilities(
    torque: Array, jacobians: Mapping[str, Array], noise: Array, sizes: Sequence[float]
) -> dict[str, float]:
    """Return the probability that one contact is at each of the places, equal beforehand.

    torque: external, of the contact's samples, (n, 6) [Nm]; jacobians: J_v of the places, base
    axes, (n, 3, 6) each; noise: S (n, 6, 6) [Nm²]; sizes: s [N], equally likely beforehand. All
    samples together count as one: the arm hardly moves on, and friction errs alike in all of them.
    """
    evidence = [
        logsumexp([_mean_log_density(torque, noise, lever, size) for size in sizes])
        for lever in jacobians.values()
    ]
    return dict(zip(jacobians, np.asarray(softmax(evidence)).tolist(), strict=True))


def _mean_log_density(torque: Array, noise: Array, lever: Array, size: float) -> float:
    return float(log_density(torque, noise + size**2 * lever.mT @ lever).mean())


def link_probabilities(
    probability: Mapping[str, float], links: Mapping[str, int]
) -> dict[int, float]:
    """Return the probability of each link; links: on which link each place is."""
    return {
        link: sum(p for place, p in probability.items() if links[place] == link)
        for link in sorted({*links.values()})
    }


def touched_link(probability: Mapping[int, float]) -> int | None:
    """Return the link of a contact, None where the torques cannot tell; probability: of links."""
    best = max(probability, key=probability.__getitem__)
    return best if probability[best] >= SURE else None
