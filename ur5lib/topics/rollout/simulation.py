"""Arms that their motors' torques move, many at once: the equations of motion with friction, step
by step.

D q̈ + C q̇ + g + f = τ. A step is implicit in the friction f, which may be stiff: dry friction
reverses over a tenth of a milliradian, and a wrist without a rotor weighs next to nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ur5lib.dynamics.many_arms import ManyArms
from ur5lib.robots.friction import PRESLIDING_DISTANCE, JointMotion, friction_columns
from ur5lib.timeseries.arrays import Array

STEP = 0.005  # s
ITERATIONS = 2  # of a step's friction
SHORTEST_CHORD = 1e-6  # rad/s
FASTEST = 100.0  # rad/s; a joint that gets as fast is lost, and gets no faster


class State(NamedTuple):
    """States of M arms, (M, n) each: q [rad], qd [rad/s], and the direction of dry friction."""

    q: Array
    qd: Array
    direction: Array


@dataclass(frozen=True)
class ManyFrictions:
    """The friction of M arms of n joints, by the terms of `robots/friction.py`.

    coefficients: (M, n, P) [Nm, ...], of the terms' columns; balanced: (n,), 1 of joints on which
    a spring or a counterbalance acts, else 0; distance: over which dry friction reverses [rad].
    """

    terms: Sequence[str]
    coefficients: Array
    balanced: Array
    distance: float = PRESLIDING_DISTANCE

    def torque(self, state: State, carried: Array) -> Array:
        """Return the torque (M, n) [Nm] against the motion; carried: by the gears (M, n) [Nm]."""
        q, qd, direction, torque = (own.ravel() for own in (*state, carried))
        balanced = np.broadcast_to(self.balanced, state.q.shape).ravel()
        motion = JointMotion(q, qd, torque, direction, balanced=balanced)
        columns = friction_columns(motion, self.terms).reshape(self.coefficients.shape)
        return np.vecdot(columns, self.coefficients)

    def turned(self, direction: Array, moved: Array) -> tuple[Array, Array]:
        """Return the direction (M, n) of dry friction while joints move by (M, n) [rad], its mean
        over the way and that at its end (`friction_direction`).
        """
        way = np.maximum(np.abs(moved) / self.distance, 1e-9)
        lost, ahead = -np.expm1(-way), np.sign(moved)
        return ahead + (direction - ahead) * lost / way, ahead + (direction - ahead) * (1 - lost)


def simulated(arms: ManyArms, friction: ManyFrictions, start: State, torque: Array) -> Array:
    """Return the angles (M, S, n) [rad] of arms after each of S steps of STEP seconds.

    start: of each arm; torque: of the motors (M, S, n) [Nm], mean of each step.
    """
    state, acceleration, angles = start, np.zeros_like(start.q), np.empty_like(torque)
    for k in range(torque.shape[1]):
        state, acceleration = _step(arms, friction, state, acceleration, torque[:, k])
        angles[:, k] = state.q
    return angles


def _step(
    arms: ManyArms, friction: ManyFrictions, state: State, acceleration: Array, torque: Array
) -> tuple[State, Array]:
    """Return the states after a step, and the accelerations (M, n) [rad/s²] in it.

    acceleration: in the step before, by which D and h of the step's middle are found.
    """
    q, qd, direction = state
    joints, half = np.arange(q.shape[1]), STEP / 2
    inertia, bias = arms.equation_of_motion(q + half * qd, qd + half * acceleration)
    impulse = np.matvec(inertia, qd) + half * (torque - bias)
    velocity = qd + half * acceleration
    for _ in range(ITERATIONS):
        # D (v - q̇) = (τ - h - f(v)) STEP / 2 for v in the middle, f by a chord from rest
        carried = np.matvec(inertia, velocity - qd) / half + bias
        along = friction.turned(direction, STEP * velocity)[0]
        resting = friction.torque(State(q, np.zeros_like(qd), direction), carried)
        moving = friction.torque(State(q, velocity, along), carried)
        chord = np.copysign(np.maximum(np.abs(velocity), SHORTEST_CHORD), velocity)
        slope = np.maximum((moving - resting) / chord, 0.0)
        stiff = inertia.copy()
        stiff[:, joints, joints] += half * slope
        driven = impulse - half * (moving - slope * velocity)
        velocity = np.linalg.solve(stiff, driven[..., None])[..., 0]
    velocity = np.clip(velocity, -FASTEST, FASTEST)
    ended, moved = np.clip(2 * velocity - qd, -FASTEST, FASTEST), STEP * velocity
    return State(q + moved, ended, friction.turned(direction, moved)[1]), (ended - qd) / STEP
