"""The torque that the environment puts on the joints, and in which state each joint is."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

Array = NDArray[np.float64]
States = NDArray[np.int64]
Mask = NDArray[np.bool_]

MOVING, TURNING, RESTING = range(3)
STATES = 3
SLOW = 0.03  # rad/s, where Coulomb friction changes its side (width of the fitted tanh)
SETTLING = 1.0  # s, how long a joint's friction goes on relaxing after a stop


def external_torque(torque_constant: Array, current: Array, modelled: Array) -> Array:
    """tau_ext = J^T F = k (i_modelled - i): what the motors need less of, the environment gives.

    torque_constant: (6,) [Nm/A]; current, modelled: (N, 6) [A], measured and as a contact-free
    model has it. Returns (N, 6) [Nm], the environment acting on the arm. The thesis's Equation 6.8
    has the opposite sign: the arm acting on its environment.
    """
    return torque_constant * (modelled - current)


def finite_rows(values: Array) -> Mask:
    """(N,) where no number of a row (N, M) is missing."""
    return np.asarray(np.isfinite(values).all(axis=1))


def unbroken(segment: NDArray[np.int64]) -> list[slice]:
    """The stretches of a recording (N,) that no gap divides."""
    bounds = [0, *(1 + np.flatnonzero(np.diff(segment))), len(segment)]
    return [slice(first, last) for first, last in pairwise(bounds)]


def without_edges(values: Array, segment: NDArray[np.int64], samples: int) -> Array:
    """NaN for the first and last samples of each stretch: there a low-pass knows one side only."""
    result = values.copy()
    for stretch in unbroken(segment):
        part = result[stretch]
        part[:samples] = np.nan
        part[max(0, len(part) - samples) :] = np.nan
    return result


def joint_states(qd: Array, segment: NDArray[np.int64], period: float) -> States:
    """MOVING, TURNING (slow, or at rest for less than a second) or RESTING, each joint by itself.

    qd: (N, 6) [rad/s]; period: [s]. Returns (N, 6).
    """
    states = np.empty(qd.shape, np.int64)
    window = 2 * round(SETTLING / period) + 1
    for stretch in unbroken(segment):
        moving = np.abs(qd[stretch]) >= SLOW
        near = maximum_filter1d(moving.astype(np.int64), window, axis=0, mode="nearest") > 0
        states[stretch] = np.where(moving, MOVING, np.where(near, TURNING, RESTING))
    return states


def at_rest(states: States) -> Mask:
    """(N,) where all joints rest."""
    return np.asarray((states == RESTING).all(axis=1))
