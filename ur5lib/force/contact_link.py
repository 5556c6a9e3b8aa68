"""Which place of the arm a force acts on, by the torques alone; or that they cannot tell.

A force F without a moment at a place p leaves τ = J_pᵀ F + e in the joints. With F ~ N(0, P) and
e ~ N(0, S), p(τ | place) = N(0, S + J_pᵀ P J_p), and places are compared by this likelihood. Joints
beyond the touched link carry nothing; where two places explain the torques as well, none is named.
"""

from collections.abc import Mapping

import numpy as np
from scipy.special import softmax

from ur5lib.force.gate import log_density
from ur5lib.timeseries.arrays import Array

SURE = 0.95  # least probability of a link that is named


def place_probabilities(
    torque: Array, jacobians: Mapping[str, Array], noise: Array, force: Array, worth: float
) -> dict[str, float]:
    """Return the probability that one contact is at each of the places, equal beforehand.

    torque: external, of the contact's samples, (n, 6) [Nm]; jacobians: J_v of the places, base
    axes, (n, 3, 6) each; noise: S (n, 6, 6) [Nm²]; force: P (3, 3) [N²]; worth: independent values
    per sample, at most 1.
    """
    evidence = [
        worth * log_density(torque, noise + lever.mT @ force @ lever).sum()
        for lever in jacobians.values()
    ]
    return dict(zip(jacobians, softmax(evidence).tolist(), strict=True))


def touched_link(probability: Mapping[str, float], links: Mapping[str, int]) -> int | None:
    """Return the link of a contact, None where the torques cannot tell.

    probability: of places; links: on which link each place is.
    """
    of_link = {
        link: sum(p for place, p in probability.items() if links[place] == link)
        for link in {*links.values()}
    }
    best = max(of_link, key=of_link.__getitem__)
    return best if of_link[best] >= SURE else None


def force_covariance(size: float) -> Array:
    """Return P (3, 3) [N²] of a force of a size [N] in any direction."""
    return size**2 * np.eye(3)
