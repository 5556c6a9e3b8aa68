"""The order of the joints, the unit and the arm that explain the efforts by gravity.

A joint's effort is gravity, by a slope that the unit bounds, and friction and inertia. What is left
of each joint's effort, with a variance of its own, gives the likelihood of an order and an arm.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.channels import MAX_SPEED_RATIO
from ur5lib.checks.currents import MAX_CONSTANT, MIN_CONSTANT
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.timeseries.arrays import Array, Labels

Order = tuple[int, ...]  # the column of each joint, from 0
Units = Mapping[str, tuple[float, float]]  # bounds of effort per Nm, by unit

ELBOW_FIRST = (2, 1, 0, 3, 4, 5)  # elbow, shoulder lift, shoulder pan, wrists: by the alphabet
SLOPE_BOUNDS = {  # effort per Nm
    "A": (1 / MAX_CONSTANT, 1 / MIN_CONSTANT),
    "Nm": (0.8, 1.25),
    "mA": (1e3 / MAX_CONSTANT, 1e3 / MIN_CONSTANT),
}
SLOPE_BOUNDS_OR_NONE = SLOPE_BOUNDS | {"neither": (0.0, 0.0)}  # or a torque without gravity
OWN_FACTORS = "own factors"  # each joint has one, as a share of its rated torque, or counts
ALL_SLOPE_BOUNDS = SLOPE_BOUNDS_OR_NONE | {OWN_FACTORS: (0.0, math.inf)}
EFFORT_NOISE = 2e-3  # A, Nm; no mean over a block of an effort is more precise
SPREAD_OF_CONSTANTS = 0.2  # torque constants spread by this around those of the joints' sizes
CLEAR_LEAD = 8.0  # from this difference of log-likelihoods on, a reading is proven
MAX_RANGE_RATIO = 1.05  # a joint stays within its range times this, which a controller enforces
IMPOSSIBLE_MOTION_PENALTY = 100.0  # an arm that cannot move like this loses this log-likelihood
MIN_TORQUE_FOR_CONSTANT = 0.5  # Nm; gravity below this root mean square shows no torque constant


def in_order(arm: Robot) -> Order:
    """Return the columns of an arm's joints in their own order, 0 to n - 1."""
    return tuple(range(len(arm.joints)))


def usual_orders(joints: int) -> list[Order]:
    """Return the orders in which logs list joints: base to wrist, elbow first, wrist to base."""
    base_to_wrist = tuple(range(joints))
    elbow_first = [ELBOW_FIRST] if joints == len(ELBOW_FIRST) else []
    return [base_to_wrist, *elbow_first, base_to_wrist[::-1]]


def exchanged_order(order: Order, j: int, k: int) -> Order:
    """Return an order in which two joints, from 0, have each other's columns."""
    return tuple(order[{j: k, k: j}.get(joint, joint)] for joint in range(len(order)))


class Reading(NamedTuple):
    """A reading of efforts by an arm, an order of its joints and a unit of each effort; score: its
    log-likelihood.
    """

    arm: str
    order: Order
    units: tuple[str, ...]
    score: float


def readings(
    means: BlockMeans, arms: Sequence[Robot], orders: Sequence[Order], units: Units = SLOPE_BOUNDS
) -> list[Reading]:
    """Return the readings by each arm and order, the likeliest first, with the likeliest unit of
    each effort.

    means: with the efforts in `currents`, columns as in the file; units: bounds of effort per Nm of
    the possible ones.
    """
    columns, speed = np.array(orders), np.abs(means.qd).max(axis=0)
    lowest, highest = means.q.min(axis=0), means.q.max(axis=0)
    motion = _motion_bases(means)
    free = [_without_motion(motion, effort) for effort in means.currents.values()]
    candidates = []
    for arm in arms:
        postures = means.q[:, columns].swapaxes(0, 1)  # (orders, M, n)
        torque = gravity_torque(arm, arm.chosen_model, postures.reshape(-1, len(arm.joints)))
        torque = torque.reshape(postures.shape)
        constants = arm.maker_torque_constants()
        scores = [
            _scores(means, motion, effort, torque, columns, constants, units) for effort in free
        ]
        total = sum((np.max([*score.values()], axis=0) for score in scores), np.zeros(len(orders)))
        beyond = speed[columns] > MAX_SPEED_RATIO * np.array(arm.velocity_limits())
        low, high = np.transpose(arm.position_limits())
        slack = (MAX_RANGE_RATIO - 1) / 2 * (high - low)
        beyond |= (lowest[columns] < low - slack) | (highest[columns] > high + slack)
        total -= IMPOSSIBLE_MOTION_PENALTY * beyond.any(axis=1)
        for place, order in enumerate(orders):
            likely = tuple(max(score, key=lambda u: score[u][place]) for score in scores)
            candidates.append(Reading(arm.name, order, likely, float(total[place])))
    return sorted(candidates, key=lambda reading: -reading.score)


class UnitScores(NamedTuple):
    """How well gravity explains an effort.

    by_unit: log-likelihood of each unit, of "neither", a torque without gravity, and of
    OWN_FACTORS, one factor per joint; by_makers: the same where currents have the arm's torque
    constants; beside_motion: share of the squares that friction and inertia do not explain, on the
    joint whose gravity changes most.
    """

    by_unit: dict[str, float]
    by_makers: dict[str, float]
    beside_motion: float


def unit_scores(means: BlockMeans, effort: str, arm: Robot) -> UnitScores:
    """Return how well gravity explains an effort by its name in `means`, in the order of the
    joints.
    """
    motion, columns = _motion_bases(means), np.array([in_order(arm)])
    free, gravity = _without_motion(motion, means.currents[effort]), means.gravity(arm)
    scores = [
        _scores(means, motion, free, gravity[None], columns, constants, ALL_SLOPE_BOUNDS)
        for constants in ([math.nan] * len(arm.joints), arm.maker_torque_constants())
    ]
    by_unit, by_makers = ({unit: float(one[0]) for unit, one in own.items()} for own in scores)
    joint = int(np.argmax(np.ptp(gravity, axis=0)))
    own, left = means.currents[effort][:, joint], free[:, joint]
    beside = float(left @ left / (((own - own.mean()) ** 2).sum() + 1e-12))
    return UnitScores(by_unit, by_makers, beside)


def _motion_bases(means: BlockMeans) -> list[Array]:
    """Return orthonormal bases (M, n) of each joint's friction, inertia and offset."""
    bases = []
    for column in range(means.q.shape[1]):
        terms = means.without_gravity(column, means.qdd)
        basis, size, _ = np.linalg.svd(terms, full_matrices=False)
        bases.append(basis[:, size > 1e-8 * size[0]])
    return bases


def _project(basis: Array, values: Array) -> Array:
    """Return the part of values (..., M) that a basis (M, n) does not span."""
    return values - (values @ basis) @ basis.T


def _without_motion(motion: Sequence[Array], effort: Array) -> Array:
    """Return efforts (M, n) without friction and inertia; motion: their bases."""
    return np.stack([_project(basis, effort[:, k]) for k, basis in enumerate(motion)], axis=1)


def _scores(
    means: BlockMeans,
    motion: Sequence[Array],
    effort: Array,
    torque: Array,
    columns: Labels,
    constants: Sequence[float],
    units: Units,
) -> dict[str, Array]:
    """Return, by unit, the log-likelihoods (K,) of orders of the joints.

    motion: bases of friction and inertia; effort: (M, n) without these; torque: (K, M, n) of
    gravity; columns: (K, n), the orders; constants: Nm/A that the joints should have, NaN where
    unknown.
    """
    total = {unit: np.zeros(len(columns)) for unit in units}
    for column, basis in enumerate(motion):
        for joint in np.flatnonzero((columns == column).any(axis=0)).tolist():
            rows = columns[:, joint] == column
            gravity = _project(basis, torque[rows, :, joint])
            slope = gravity @ effort[:, column] / ((gravity**2).sum(axis=1) + 1e-12)
            expected = {"A": constants[joint], "mA": constants[joint] / 1e3, "Nm": 1.0}
            for unit, (low, high) in units.items():
                bounded = np.clip(slope, low, high)
                residual = ((effort[:, column] - bounded[:, None] * gravity) ** 2).mean(axis=1)
                total[unit][rows] += means.log_likelihood(residual + EFFORT_NOISE**2)
                total[unit][rows] -= _surprise(bounded, expected.get(unit, math.nan), gravity)
    return total


def _surprise(slope: Array, constant: float, torque: Array) -> Array:
    """Return what slopes (K,) lose of their log-likelihood as far as they are from a torque
    constant [Nm/A]; zero where gravity is small.
    """
    if math.isnan(constant):
        return np.zeros(len(slope))
    loaded = np.linalg.norm(torque, axis=1) > MIN_TORQUE_FOR_CONSTANT * math.sqrt(torque.shape[1])
    return np.where(loaded, (np.log(slope * constant) / SPREAD_OF_CONSTANTS) ** 2 / 2, 0.0)
