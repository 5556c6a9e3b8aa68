"""Which order of the joints, which unit and which arm explain the efforts: by gravity.

A joint's effort is gravity, by a slope that the unit bounds, and friction and inertia. Every order
of the joints is tried; what is left of each joint's effort, with a variance of its own, gives the
order's likelihood.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np

from ur5lib.recordings.block_means import BlockMeans, combination
from ur5lib.recordings.current_checks import CONSTANTS
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.timeseries.arrays import Array, Labels

Order = tuple[int, ...]  # the column of joints 1 to 6, from 0
Units = Mapping[str, tuple[float, float]]  # bounds of effort per Nm, by unit

ALL_ORDERS: Sequence[Order] = [*permutations(range(6))]
IN_ORDER = ALL_ORDERS[0]
# gravity does not distinguish orders that exchange joints 1 and 6
ORDERS_BY_GRAVITY = [order for order in ALL_ORDERS if order[0] < order[5]]
SLOPES = {"A": (1 / CONSTANTS[1], 1 / CONSTANTS[0]), "Nm": (0.8, 1.25)}  # effort per Nm
SLOPES["mA"] = (1e3 / CONSTANTS[1], 1e3 / CONSTANTS[0])
OR_FREE = SLOPES | {"neither": (0.0, 0.0)}  # or a torque without gravity
NOISE = 2e-3  # A, Nm; no mean over a block of an effort is more precise
KNOWN = 0.2  # spread of torque constants around those of the joints' sizes
MOST = 40  # blocks that are looked at
SURE = 8.0  # difference of log-likelihoods from which on a reading is proven
CLOSE = 40.0  # difference of log-likelihoods on few blocks up to which all blocks are looked at
LEVEL = 1e-4  # of the mean square of all efforts; no joint's is explained better
FASTER = 1.25  # times the largest speed of a joint; a UR5 exceeded its own by 6 %
FARTHER = 1.05  # times the range of a joint, which a controller enforces
UNABLE = 100.0  # by which the log-likelihood of an arm falls that cannot move so
HEAVIER = 2.5  # the base's rotor, seen through an effort, is at least this many times a wrist's


def in_order(arm: Robot) -> Order:
    """Return the columns of an arm's joints in their order."""
    return tuple(range(len(arm.joints)))


def exchanged(order: Order, j: int, k: int) -> Order:
    """Return an order in which two joints, from 0, have each other's columns."""
    return tuple(order[{j: k, k: j}.get(joint, joint)] for joint in range(len(order)))


class Reading(NamedTuple):
    """An arm, an order of the joints and a unit of each effort, and their log-likelihood."""

    arm: str
    order: Order
    units: tuple[str, ...]
    score: float


def _thinned(means: BlockMeans) -> BlockMeans:
    """Return the blocks in which the arm's postures differ most."""
    chosen, away = [0], np.full(len(means.q), np.inf)
    while len(chosen) < min(MOST, len(means.q)):
        away = np.minimum(away, np.abs(means.q - means.q[chosen[-1]]).sum(axis=1))
        chosen.append(int(np.argmax(away)))
    return means.part(rows=np.unique(chosen))


def readings(
    means: BlockMeans, arms: Sequence[Robot], orders: Sequence[Order], units: Units = SLOPES
) -> list[Reading]:
    """Return the readings of some arms and orders, the likeliest first, with each effort's unit.

    means: `currents` holds the efforts, columns as in the file; units: possible ones.
    """
    columns, speed = np.array(orders), np.abs(means.qd).max(axis=0)
    lowest, highest = means.q.min(axis=0), means.q.max(axis=0)
    free = [_without_motion(means, effort) for effort in means.currents.values()]
    found = []
    for arm in arms:
        postures = means.q[:, columns].swapaxes(0, 1)  # (orders, M, 6)
        torque = gravity_torque(arm, arm.chosen_model, postures.reshape(-1, len(arm.joints)))
        torque = torque.reshape(postures.shape)
        constants = arm.maker_torque_constants()
        scores = [_scores(means, effort, torque, columns, constants, units) for effort in free]
        total = sum((np.max([*score.values()], axis=0) for score in scores), np.zeros(len(orders)))
        beyond = speed[columns] > FASTER * np.array(arm.velocity_limits())
        low, high = np.transpose(arm.position_limits())
        slack = (FARTHER - 1) / 2 * (high - low)
        beyond |= (lowest[columns] < low - slack) | (highest[columns] > high + slack)
        total -= UNABLE * beyond.any(axis=1)
        for place, order in enumerate(orders):
            likely = tuple(max(score, key=lambda u: score[u][place]) for score in scores)
            found.append(Reading(arm.name, order, likely, float(total[place])))
    return sorted(found, key=lambda reading: -reading.score)


def likeliest(means: BlockMeans, arms: Sequence[Robot], units: Units = SLOPES) -> list[Reading]:
    """Return the likeliest readings of all orders that gravity distinguishes, the best first.

    All are tried on few blocks, and those that explain these on all blocks.
    """
    first = readings(_thinned(means), arms, ORDERS_BY_GRAVITY, units)
    close = [one for one in first if first[0].score - one.score < CLOSE]
    by_arm = {arm.name: [one.order for one in close if one.arm == arm.name] for arm in arms}
    again = [readings(means, [a], by_arm[a.name], units) for a in arms if by_arm[a.name]]
    return sorted((one for few in again for one in few), key=lambda one: -one.score)


def slope(means: BlockMeans, effort: str, arm: Robot, joint: int) -> float:
    """Return effort per torque of gravity of a joint [1/unit]; NaN where gravity is nil."""
    own = _project(_motion(means, joint), means.gravity(arm)[:, joint])
    if np.linalg.norm(own) <= 1e-3 * len(own):
        return math.nan
    free = _without_motion(means, means.currents[effort])[:, joint]
    return float(own @ free / (own @ own))


def unit_scores(means: BlockMeans, effort: str, arm: Robot) -> dict[str, float]:
    """Return the log-likelihood of each unit of an effort, and that it holds no gravity.

    means: with the joints in order.
    """
    free, columns = _without_motion(means, means.currents[effort]), np.array([in_order(arm)])
    unknown = [math.nan] * len(arm.joints)
    scores = _scores(means, free, means.gravity(arm)[None], columns, unknown, OR_FREE)
    return {unit: float(score[0]) for unit, score in scores.items()}


def own_order(means: BlockMeans, effort: str, arm: Robot) -> float:
    """Return how much likelier an effort's columns have the positions' order than any other.

    A difference of log-likelihoods; negative where another order explains the effort better.
    means: with the joints in order.
    """
    torque, values = means.gravity(arm), means.currents[effort]
    floor = NOISE**2 + LEVEL * (values**2).mean()
    every = np.array(ALL_ORDERS)
    margins = []
    for low, high in SLOPES.values():
        left = [_left(means, values, torque[:, j], j, low, high) for j in IN_ORDER]
        scores = means.log_likelihood(np.array(left) + floor)
        margins.append(scores[np.arange(6), every].sum(axis=1))
    own, *others = np.max(margins, axis=0)  # in order first
    return float(own - max(others))


def _left(
    means: BlockMeans, values: Array, gravity: Array, column: int, low: float, high: float
) -> Array:
    """Return the mean squares (6,) that gravity and motion of one joint leave of all efforts."""
    basis, _ = np.linalg.qr(means.without_gravity(column, means.qdd[:, column]))
    own, free = _project(basis, gravity), _project(basis, values.T)
    slope = np.clip(free @ own / (own @ own + 1e-12), low, high)
    return np.asarray(((free - slope[:, None] * own) ** 2).mean(axis=1))


def base_first(means: BlockMeans, order: Order) -> bool | None:
    """Return whether joints 1 and 6 of an order are so, and not exchanged; None: undetermined.

    By their rotors: the base's inertia, seen through an effort, is a multiple of a wrist's.
    """
    votes = {_heavier(means, effort, order) for effort in means.currents.values()} - {None}
    return votes.pop() if len(votes) == 1 else None


def _heavier(means: BlockMeans, effort: Array, order: Order) -> bool | None:
    first, last = (_inertia(means, effort, order[joint]) for joint in (0, 5))
    for (one, its), (other, error), is_base in ((first, last, True), (last, first, False)):
        if one - 3 * its > HEAVIER * max(other + 3 * error, 0.0):
            return is_base
    return None


def _inertia(means: BlockMeans, effort: Array, column: int) -> tuple[float, float]:
    """Return effort per acceleration of a joint's own, and its standard error."""
    own = np.column_stack([means.qdd[:, column], means.friction(column), np.ones(len(effort))])
    return combination(own, effort[:, column], [1.0])


def _motion(means: BlockMeans, column: int) -> Array:
    """Return an orthonormal basis (M, n) of a joint's friction, inertia and offset."""
    terms = means.without_gravity(column, means.qdd)
    basis, size, _ = np.linalg.svd(terms, full_matrices=False)
    return basis[:, size > 1e-8 * size[0]]


def _project(basis: Array, values: Array) -> Array:
    """Return the part of values (..., M) that a basis (M, n) does not span."""
    return values - (values @ basis) @ basis.T


def _without_motion(means: BlockMeans, effort: Array) -> Array:
    """Return efforts (M, 6) without friction and inertia."""
    columns = [_project(_motion(means, k), effort[:, k]) for k in range(effort.shape[1])]
    return np.stack(columns, axis=1)


def _scores(
    means: BlockMeans,
    effort: Array,
    torque: Array,
    columns: Labels,
    constants: Sequence[float],
    units: Units,
) -> dict[str, Array]:
    """Return the log-likelihood of each order (K,) by unit.

    torque: (K, M, 6) of gravity; constants: Nm/A that the joints should have, NaN where unknown.
    """
    total = {unit: np.zeros(len(columns)) for unit in units}
    for column in range(effort.shape[1]):
        basis = _motion(means, column)
        for joint in range(columns.shape[1]):
            rows = columns[:, joint] == column
            own = _project(basis, torque[rows, :, joint])
            slope = own @ effort[:, column] / ((own**2).sum(axis=1) + 1e-12)
            known = {"A": constants[joint], "mA": constants[joint] / 1e3, "Nm": 1.0}
            for unit, (low, high) in units.items():
                bounded = np.clip(slope, low, high)
                left = ((effort[:, column] - bounded[:, None] * own) ** 2).mean(axis=1)
                total[unit][rows] += means.log_likelihood(left + NOISE**2)
                total[unit][rows] -= _surprise(bounded, known.get(unit, math.nan), own)
    return total


def _surprise(slope: Array, constant: float, torque: Array) -> Array:
    """Return how unlikely slopes (K,) are for a torque constant [Nm/A], where gravity is large."""
    if math.isnan(constant):
        return np.zeros(len(slope))
    loaded = np.linalg.norm(torque, axis=1) > 0.5 * math.sqrt(torque.shape[1])  # Nm
    return np.where(loaded, (np.log(slope * constant) / KNOWN) ** 2 / 2, 0.0)
