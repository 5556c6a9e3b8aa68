"""Trajectories of a design: Fourier series that begin and end at rest, limits and margins."""

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from scipy.linalg import null_space

from ur5lab.collisions import Capsules, Surroundings
from ur5lib.dynamics.arm import PullBack
from ur5lib.dynamics.flange import differentiable_singular_value, independent_twists, singular_value
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import MIN_SINGULAR_VALUE
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.profiles import fourier_terms, rest_conditions

# Shares of the arm's limits that a trajectory may use.
POSITION_SHARE = 0.95
VELOCITY_SHARE = 0.5
ACCELERATION_SHARE = 0.5
TORQUE_SHARE = 0.8
MAX_JERK = 200.0  # rad/s³; no description states a limit
ENDLESS_RANGE = 2 * np.pi  # rad; range of a joint without limits, to either side
MIN_CLEARANCE = 0.03  # m; between capsules
DISTANCE_REACH = 0.1  # m; largest measured distance
JOINT_LIMITS = ("position", "velocity", "acceleration", "jerk", "torque")


class States(NamedTuple):
    """States along a path, (N, n) each [rad, rad/s, rad/s², rad/s³]."""

    q: Array
    qd: Array
    qdd: Array
    jerk: Array


@dataclass(frozen=True)
class Path:
    """A path as a Fourier series: q(t) = posture + Σ_k a_k sin(2πkt/T) + b_k cos(2πkt/T), with T
    the duration.

    posture: (n,) [rad], at which it begins and ends; coefficients: (2 H, n) [rad], of the sines,
    then of the cosines; seconds: T.
    """

    posture: Array
    coefficients: Array
    seconds: float

    def at(self, time: Array) -> States:
        """Return the states at times (N,) [s]."""
        terms = fourier_terms(self.seconds, len(self.coefficients) // 2, time)
        q, qd, qdd, jerk = (term @ self.coefficients for term in terms)
        return States(q + self.posture, qd, qdd, jerk)

    def sampled(self, rate: float) -> tuple[Array, States]:
        """Return times (N,) [s] from beginning to end at a rate [Hz], and the states there."""
        time = np.linspace(0, self.seconds, 1 + round(self.seconds * rate))
        return time, self.at(time)

    def shrunk(self, share: float | Array) -> "Path":
        """Return the path scaled about its posture; share: one factor, or one per joint (n,)."""
        return replace(self, coefficients=self.coefficients * share)


@dataclass(frozen=True)
class Limits:
    """The limits of a trajectory; those of joints apply to both signs.

    position, velocity, acceleration, jerk, torque: (n,) [rad, rad/s, rad/s², rad/s³, Nm], position
    from the middle of a joint's range; clearance: smallest allowed distance between parts [m];
    singular_value: least allowed value of the Jacobian's smallest singular value.
    """

    position: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    torque: Array
    clearance: float = MIN_CLEARANCE
    singular_value: float = MIN_SINGULAR_VALUE

    def of_joints(self) -> list[Array]:
        """Return the limits of q, q̇, q̈, jerk and torque, (n,) each."""
        return [self.position, self.velocity, self.acceleration, self.jerk, self.torque]


@dataclass(frozen=True)
class Margins:
    """How much of its limits a trajectory uses; it keeps them all if `broken` returns nothing.

    used: by name of a limit, the largest share of it that each joint uses, (n,); clearance:
    smallest distance between parts [m], at most DISTANCE_REACH; nearest: the names of these parts,
    empty beyond DISTANCE_REACH; singular_value: smallest one of the Jacobian along the trajectory.
    """

    limits: Limits
    used: dict[str, Array]
    clearance: float
    nearest: str
    singular_value: float

    def broken(self) -> list[str]:
        """Return, for each limit that is exceeded, a phrase that says by how much."""
        over = [
            f"{name} of joint {joint + 1} is {share:.0%} of its limit"
            for name, shares in self.used.items()
            for joint, share in enumerate(shares)
            if not share <= 1  # also finds NaN
        ]
        if self.clearance < self.limits.clearance:
            over.append(
                f"{self.nearest} come within {self.clearance:.3f} m, nearer than "
                f"{self.limits.clearance:g} m"
            )
        if not self.singular_value >= self.limits.singular_value:
            over.append(
                f"the smallest singular value {self.singular_value:.3f} is below "
                f"{self.limits.singular_value:g}"
            )
        return over

    def lines(self) -> list[str]:
        """Return the margins as lines of text."""
        shares = [
            f"{name + ', share of its limit by joint':<42}"
            + "".join(f"{share:>7.0%}" for share in shares)
            for name, shares in self.used.items()
        ]
        distance = (
            f"{self.clearance:.3f} m ({self.nearest})"
            if self.nearest
            else f"over {DISTANCE_REACH} m"
        )
        return [
            *shares,
            f"least distance between parts: {distance}, allowed {self.limits.clearance:g} m",
            f"smallest singular value: {self.singular_value:.3f}, "
            f"allowed {self.limits.singular_value:g}",
        ]


@dataclass(frozen=True)
class WorkCell:
    """An arm in its surroundings, with all limits on a trajectory.

    middle: of the joints' ranges (n,) [rad]; twists: the flange's degrees of freedom, at most 6.
    """

    robot: Robot
    model: LinkModel
    limits: Limits
    capsules: Capsules
    middle: Array
    twists: int

    @classmethod
    def around(cls, robot: Robot, surroundings: Surroundings) -> Self:
        """Return an arm, with its fullest link model, in its surroundings.

        Its limits are shares of those in its description.
        """
        ranges = np.nan_to_num(robot.position_limits(), posinf=ENDLESS_RANGE, neginf=-ENDLESS_RANGE)
        limits = Limits(
            POSITION_SHARE * np.ptp(ranges, axis=1) / 2,
            VELOCITY_SHARE * np.array(robot.velocity_limits()),
            ACCELERATION_SHARE * np.array(robot.acceleration_limits()),
            np.full(len(ranges), MAX_JERK),
            TORQUE_SHARE * np.array(robot.torque_limits()),
        )
        return cls(
            robot,
            LinkModel(robot, robot.fullest_model()),
            limits,
            Capsules(robot, surroundings, DISTANCE_REACH),
            ranges.mean(axis=1),
            independent_twists(robot),
        )

    def limited(self, states: States) -> States:
        """Return states with positions counted from the middle of the joints' ranges, so that
        limits apply to both signs.
        """
        return states._replace(q=states.q - self.middle)

    def singular_value(self, q: Array) -> Array:
        """Return the smallest singular value (N,) of the Jacobian J_g along a path q (N, n)
        [rad].
        """
        return singular_value(self.model.arm, q, self.twists)

    def differentiable_singular_value(self, q: Array) -> tuple[Array, PullBack]:
        """Return `singular_value`, and the pull-back of its derivative to q."""
        return differentiable_singular_value(self.model.arm, q, self.twists)

    def margins(self, states: States) -> Margins:
        """Return how much of the limits a trajectory uses."""
        torque = self.model.inverse_dynamics(states.q, states.qd, states.qdd)
        parts = [*self.limited(states), torque]
        limited = zip(JOINT_LIMITS, parts, self.limits.of_joints(), strict=True)
        used = {name: np.abs(part).max(axis=0) / limit for name, part, limit in limited}
        clearances = self.capsules.near(states.q)
        nearest = int(np.argmin(clearances.distance)) if len(clearances.distance) else None
        return Margins(
            self.limits,
            used,
            DISTANCE_REACH if nearest is None else float(clearances.distance[nearest]),
            "" if nearest is None else " and ".join(clearances.pairs[nearest]),
            float(self.singular_value(states.q).min()),
        )


def resting_series(period: float, harmonics: int) -> Array:
    """Return a basis (2 H, 2 H - 3) of the coefficients of all Fourier series that begin and end at
    rest.

    Higher harmonics are smaller, in proportion to 1/k, so that all columns have similar velocities.
    """
    falling = 1 / np.tile(np.arange(1, harmonics + 1), 2)
    basis: Array = null_space(rest_conditions(period, harmonics) * falling)
    return falling[:, None] * basis
