"""What friction of real joints does from run to run, from stop to stop, and during a rest.

A joint that stops holds a torque of its motor against friction, another at each stop, which relaxes
and drifts; loaded gears rub more in some places than in others. Motor and friction change alike, so
that the arm moves as without it. With these sizes, the residual torque of a free arm lies among
those of real arms: `python -m benchmarks.stand_and_arms`.
"""

import numpy as np
from scipy.signal import lfilter

from ur5lib.stand.drive import motion_share
from ur5lib.stand.friction import FrictionParameters
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import runs

RUN_STD = 0.05  # of each joint's friction from recording to recording
# In breakaway torques, as a joint stops; a second later two thirds of that, in the end a third.
HELD_STD = 0.5
RELAXING_SHARE, RELAXATION_TIME = 0.65, 1.5  # of the held torque, s
DRIFT_STD, DRIFT_TIME = 0.15, 10.0  # in breakaway torques, s
PLACE_SHARE = 0.02  # Nm per Nm of load
PLACE_PERIODS = 3  # per turn of a joint
STOP_SPEED = 0.01  # rad/s; a slower joint has stopped


def run_factors(joints: int, random: np.random.Generator) -> Array:
    """Return the factors (n,) of the joints' friction in one recording."""
    return np.exp(RUN_STD * random.normal(size=joints))


def varied_torque(
    q: Array,
    qd: Array,
    load: Array,
    friction: FrictionParameters,
    step: float,
    random: np.random.Generator,
) -> Array:
    """Return what motors and friction have in addition (N, n) [Nm].

    q, qd: (N, n) [rad, rad/s]; load: (N, n) [Nm], which the gears transmit; step: [s].
    """
    held = HELD_STD * held_at_stops(np.abs(qd) < STOP_SPEED, step, random)
    held += drift(q.shape, step, random)
    place = PLACE_SHARE * np.abs(load) * np.cos(PLACE_PERIODS * q + friction.phase)
    return (1 - motion_share(qd)) * friction.stiction * friction.coulomb * held + place


def held_at_stops(stopped: Mask, step: float, random: np.random.Generator) -> Array:
    """Return the torque (N, n) that stopped joints hold, of standard deviation 1 as they stop."""
    held = np.zeros(stopped.shape)
    for own, joint in zip(held.T, stopped.T, strict=True):
        for first, last in runs(joint):
            since = step * np.arange(last - first)
            relaxed = RELAXING_SHARE * (1 - np.exp(-since / RELAXATION_TIME))
            own[first:last] = random.normal() * (1 - relaxed)
    return held


def drift(shape: tuple[int, ...], step: float, random: np.random.Generator) -> Array:
    """Return an Ornstein-Uhlenbeck process (N, n) from zero, with DRIFT_STD and DRIFT_TIME."""
    white = DRIFT_STD * np.sqrt(2 * step / DRIFT_TIME) * random.normal(size=shape)
    return np.asarray(lfilter([1.0], [1.0, step / DRIFT_TIME - 1], white, axis=0))
