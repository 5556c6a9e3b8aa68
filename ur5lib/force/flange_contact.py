"""Whether a contact may be at the flange, by the torques alone.

A force F at a place p of link k loads joints 1 to k: τ = J_pᵀ F + e, with no torque beyond. Links
are compared by p(τ | link), the mean over places along the link and over sizes s of F ~ N(0, s² I),
e ~ N(0, S). Place and size are left open: otherwise, a contact elsewhere on the arm, or a weak one,
would be ascribed to the place that happens to explain it best. Torques barely distinguish other
links, but show well that the flange is not touched: then, joints of the wrist carry nothing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import logsumexp, softmax

from ur5lib.force.alarms import Alarm
from ur5lib.force.contact_prior import ContactPrior, wrench_covariance
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.force_input import ForceInput
from ur5lib.force.gate import TorqueVariances, diagonal, log_density
from ur5lib.force.problem import Problem
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array, Labels

# A contact at the flange is excluded if the other links have at least this probability.
MIN_PROBABILITY_ELSEWHERE = 0.95
PLACE_SPACING = 0.1  # m; neighbouring places along a link are at most this far apart
TOOL_LENGTH = 0.2  # m; link 6 may be touched this far beyond the flange
SURFACE_DISTANCE = 0.05  # m; a link's surface is this far from the line between its frames
GEAR_LOSS_STD = 0.15  # a joint's gears lose or gain this share of the contact's torque
MAX_CONTACT_SAMPLES = 20  # this many samples are used; more add no information


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


def flange_probability(
    torque: Array,
    levers: Mapping[int, Sequence[Array]],
    noise: Array,
    sizes: Sequence[float],
    loss: float = GEAR_LOSS_STD,
) -> float:
    """Return the probability that a contact is on the last link; a priori, all links are equal.

    torque: external, of the contact's samples, (n, 6) [Nm]; levers: J_g of the places of each link,
    (n, 6, 6) each, equally likely, too; noise: S (n, 6, 6) [N²m²]; sizes: s [N], equally likely;
    loss: relative error of each joint's torque from its gear's friction under the contact. All
    samples together count as one: the arm moves little, and friction errs alike in all of them.
    """
    loaded = noise + diagonal((loss * torque) ** 2)
    # a surface away from the place adds a moment
    wrenches = [wrench_covariance(size, SURFACE_DISTANCE) for size in sizes]
    # log p(τ | link), up to a constant: the mean over its places and the sizes
    evidence = []
    for places in levers.values():
        covariances = [loaded + J.mT @ wrench @ J for J in places for wrench in wrenches]
        log_densities = [log_density(torque, covariance).mean() for covariance in covariances]
        evidence.append(logsumexp(log_densities) - np.log(len(places)))
    return float(softmax(evidence)[[*levers].index(max(levers))])


def judged_by_torques(
    robot: Robot, problem: Problem, time: Array, prior: ContactPrior, raised: list[Alarm]
) -> list[Alarm]:
    """Return alarms of F̂ᵐᵃᵖ with `off_flange` set; time: (N,) [s].

    Loads, and contacts without a finite torque, count as not off the flange.
    """
    return [
        replace(own, off_flange=is_off_flange(robot, problem, time, prior, own)) for own in raised
    ]


def is_off_flange(
    robot: Robot, problem: Problem, time: Array, prior: ContactPrior, alarm: Alarm
) -> bool:
    """Return whether the torques of a contact exclude that it is on the last link or a tool."""
    run, model = problem
    rows = middle_half(run, time, alarm.start, alarm.end)
    if alarm.kind != "contact" or not len(rows):
        return False
    noise = TorqueVariances.of(run.states[rows], model, run.load_std()[rows])
    spread = diagonal(noise.spread + noise.hidden)
    frames = link_frames(robot, run.q[rows])
    levers = {
        link: [place_jacobian(*frames, link, place) for place in along]
        for link, along in places(*frames).items()
    }
    return (
        1 - flange_probability(run.torque[rows], levers, spread, prior.sizes())
        >= MIN_PROBABILITY_ELSEWHERE
    )


def middle_half(run: ForceInput, time: Array, start: float, end: float) -> Labels:
    """Return the rows with a torque in the middle half of a contact, at most about twice
    MAX_CONTACT_SAMPLES.

    start, end: [s]. The low-pass blurs its ends.
    """
    quarter = (end - start) / 4
    inside = (time >= start + quarter) & (time <= end - quarter)
    rows = np.flatnonzero(inside & finite_rows(run.torque) & finite_rows(run.q))
    return rows[:: max(1, len(rows) // MAX_CONTACT_SAMPLES)]
