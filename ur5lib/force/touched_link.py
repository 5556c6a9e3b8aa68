"""Which link is touched, by the torques alone, and the force wherever that is.

A force F at a place p of link k loads joints 1 to k: τ = J_pᵀ F + e, with no torque beyond. Places
are compared by p(τ | link, place, size), with F ~ N(0, s² I) and e ~ N(0, S). The last link is
touched in LAST_LINK_SHARE of contacts, the others equally often, and each link equally along its
length; p(s) falls as 1 / s². Place and size are left open: otherwise, a contact elsewhere on the
arm, or a weak one, would be ascribed to the place that happens to explain it best.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import softmax

from ur5lib.force.contact_place import std_at_flange, wrench_at_flange
from ur5lib.force.contact_prior import ContactPrior, wrench_covariance
from ur5lib.force.contact_wrench import ContactWrench, regularised_wrench
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.gate import diagonal, log_density
from ur5lib.timeseries.arrays import Array

SIZES = 1.0, 3.0  # of contacts, in typical forces
LAST_LINK_SHARE = 0.75  # of contacts, before any torque is seen
PLACE_SPACING = 0.1  # m; neighbouring places along a link are at most this far apart
TOOL_LENGTH = 0.2  # m; link 6 may be touched this far beyond the flange
SURFACE_DISTANCE = 0.05  # m; a link's surface is this far from the line between its frames
GEAR_LOSS_STD = 0.15  # a joint's gears lose or gain this share of the contact's torque
LIKELY = 0.5  # from this probability on, a contact counts as off the flange
NEGLIGIBLE = 1e-4  # a place of a lower probability is left out of the force


class Samples(NamedTuple):
    """Samples of one contact.

    torque: Jᵀ F, of the contact alone (n, k) [Nm]; noise: of it (n, k, k) [N²m²]; rotation, origin:
    of frames 0 to k, (n, k + 1, 3, 3) and (n, k + 1, 3) [m], base axes, from where contacts are
    assumed.
    """

    torque: Array
    noise: Array
    rotation: Array
    origin: Array


class Touched(NamedTuple):
    """A contact anywhere on the arm: its wrench, its likeliest link, from 1, and the probability
    that it is not on the last one; where that is LIKELY, the link is one before the last.
    """

    wrench: ContactWrench
    link: int
    off_flange: float


def places(rotation: Array, origin: Array) -> dict[int, list[Array]]:
    """Return, by link 1 to k, places along it, and along a tool on the last: (n, 3) [m] each.

    rotation, origin: of frames 0 to k, (n, k + 1, 3, 3) and (n, k + 1, 3) [m], base axes. A link
    reaches from the frame before it to its own; the last, from the flange to the end of a tool.
    """
    last = origin.shape[1] - 1
    ends = {link: (origin[:, link - 1], origin[:, link]) for link in range(1, last)}
    ends[last] = origin[:, last], origin[:, last] + TOOL_LENGTH * rotation[:, last, :, 2]
    return {link: _part_middles(*endpoints) for link, endpoints in ends.items()}


def _part_middles(first: Array, last: Array) -> list[Array]:
    """Return the middles of equal parts of a line, each at most PLACE_SPACING long."""
    count = int(np.ceil(np.linalg.norm(last - first, axis=1).max() / PLACE_SPACING - 1e-9))
    return [first + (k + 0.5) / count * (last - first) for k in range(count)]


def place_jacobian(rotation: Array, origin: Array, link: int, point: Array) -> Array:
    """Return J_g (n, 6, k) of a point (n, 3) [m] of a link: [z × (p - o); z] of joints up to it.

    rotation, origin: as for `places`; columns of joints beyond the link are zero.
    """
    axis = rotation[:, :-1, :, 2]  # z of joints 1 to k (n, k, 3)
    columns = np.concatenate([np.cross(axis, point[:, None] - origin[:, :-1]), axis], axis=2)
    columns[:, link:] = 0.0
    return columns.mT


def place_jacobians(
    rotation: Array, origin: Array, points: Mapping[int, Sequence[Array]]
) -> dict[int, list[Array]]:
    """Return, by link, J_g (n, 6, k) of each of its `places`; the other arguments as of them."""
    return {
        link: [place_jacobian(rotation, origin, link, point) for point in along]
        for link, along in points.items()
    }


def place_probabilities(
    torque: Array,
    levers: Mapping[int, Sequence[Array]],
    noise: Array,
    sizes: Sequence[float],
    loss: float = GEAR_LOSS_STD,
) -> dict[int, Array]:
    """Return, by link, the probability (places, sizes) of a contact at each place of each size.

    torque: of the contact's samples, (n, k) [Nm]; levers: J_g of the places of each link, (n, 6, k)
    each; noise: S (n, k, k) [N²m²]; sizes: s [N]; loss: relative error of each joint's torque from
    its gear's friction under the contact. All samples together count as one: the arm moves little,
    and friction errs alike in all of them.
    """
    loaded = noise + diagonal((loss * torque) ** 2)

    def evidence(J: Array, size: float) -> float:
        covariance = loaded + J.mT @ wrench_on_surface(size) @ J
        return float(log_density(torque, covariance).mean()) - 2 * np.log(size)

    shares = dict.fromkeys(levers, (1 - LAST_LINK_SHARE) / max(1, len(levers) - 1))
    shares[max(levers)] = LAST_LINK_SHARE
    # log p(τ | place, size) + log p(place) + log p(size), up to a constant
    found = [
        [evidence(J, size) + np.log(shares[link] / len(own)) for size in sizes]
        for link, own in levers.items()
        for J in own
    ]
    ends = np.cumsum([len(own) for own in levers.values()])[:-1]
    return dict(zip(levers, np.split(softmax(found), ends), strict=True))


def wrench_on_surface(size: float) -> Array:
    """Return the covariance (6, 6) of a contact's wrench; size: of its force [N]. A surface away
    from the place adds a moment.
    """
    return wrench_covariance(size, SURFACE_DISTANCE)


def off_flange(probability: Mapping[int, Array]) -> float:
    """Return the probability that a contact is not on the last link; by `place_probabilities`."""
    return float(1 - probability[max(probability)].sum())


def touched(samples: Samples, at_flange: ContactWrench, prior: ContactPrior) -> Touched | None:
    """Return the wrench of a contact that may be anywhere on the arm; None where nothing of its
    middle half is known. The low-pass blurs its ends.

    at_flange: the wrench of these samples if the contact is on the last link, which is stated as
    long as that is likely; otherwise, the mean over links and places, its variance within and
    between them.
    """
    count = len(samples.torque)
    known = finite_rows(samples.torque) & np.isfinite(samples.origin).all(axis=(1, 2))
    middle = np.flatnonzero(known[count // 4 : count - count // 4]) + count // 4
    if not len(middle):
        return None
    frames = samples.rotation, samples.origin
    points = places(*frames)
    levers = place_jacobians(*frames, points)
    there = {before: [J[middle] for J in own] for before, own in levers.items()}
    seen = samples.torque[middle], there, samples.noise[middle]
    sizes = sizes_of(prior)
    probability = place_probabilities(*seen, sizes)
    elsewhere = off_flange(probability)
    candidates = [own for own in probability if elsewhere < LIKELY or own < max(probability)]
    link = max(candidates, key=lambda own: float(probability[own].sum()))
    if elsewhere < LIKELY:
        return Touched(at_flange, link, elsewhere)
    wrenches, weights = [at_flange], [1 - elsewhere]
    for before in range(1, max(levers)):
        for J, point, shares in zip(
            levers[before], points[before], probability[before], strict=True
        ):
            for size, weight in zip(sizes, shares, strict=True):
                if weight > NEGLIGIBLE:
                    wrenches.append(_wrench_at(J, point, samples, size))
                    weights.append(weight)
    return Touched(mixture(wrenches, np.array(weights) / sum(weights)), link, elsewhere)


def sizes_of(prior: ContactPrior) -> list[float]:
    """Return the sizes [N] of contacts among which places are compared."""
    return [share * prior.force for share in SIZES]


def _wrench_at(J: Array, point: Array, samples: Samples, size: float) -> ContactWrench:
    """Return the wrench of a contact of a size [N] at a point (n, 3) [m] with J_g (n, 6, k)."""
    noise = samples.noise + diagonal((GEAR_LOSS_STD * np.nan_to_num(samples.torque)) ** 2)
    mean, covariance, _ = regularised_wrench(samples.torque, J, noise, wrench_on_surface(size))
    std = std_at_flange(np.sqrt(np.linalg.diagonal(covariance)), point)
    return ContactWrench(wrench_at_flange(mean, point), std**2)


def mixture(wrenches: Sequence[ContactWrench], weights: Array) -> ContactWrench:
    """Return mean and variance of a mixture: E[F] = Σ w F̂, var F = Σ w (var + F̂²) - E[F]²."""
    means, variances = (np.array(part) for part in zip(*wrenches, strict=True))
    mean = np.tensordot(weights, means, 1)
    square = np.tensordot(weights, variances + means**2, 1)
    return ContactWrench(mean, np.maximum(square - mean**2, 0.0))
