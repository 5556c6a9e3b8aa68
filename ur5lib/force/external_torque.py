"""The torque that the environment puts on the joints, and in which state each joint is."""

import numpy as np
from scipy.ndimage import binary_opening, maximum_filter1d

from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import unbroken

States = Labels

MOVING, REVERSING, SETTLING, RESTING, STILL = range(5)
STATES = 5
SLOW = 0.03  # rad/s, where Coulomb friction changes its side
STOP = 0.4  # s; a joint that is slow for less than this only turns round
RELAXING = 1.0  # s, how long a joint's friction goes on relaxing after a stop
REACH = 0.25  # s, how far a low-pass at 2 Hz carries what friction does at a reversal


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


def without_edges(values: Array, segment: Labels, samples: int) -> Array:
    """NaN for the first and last samples of each stretch: there a low-pass knows one side only."""
    result = values.copy()
    for stretch in unbroken(segment):
        part = result[stretch]
        part[:samples] = np.nan
        part[max(0, len(part) - samples) :] = np.nan
    return result


def joint_states(qd: Array, segment: Labels, period: float) -> States:
    """The state (N, 6) of each joint, by which its friction is known well or badly.

    MOVING; REVERSING, near a change of direction; SETTLING, stopped for less than a second or about
    to start; RESTING while another joint moves; STILL, when all joints rest. qd: (N, 6) [rad/s];
    period: [s].
    """
    states = np.empty(qd.shape, np.int64)
    for rows in unbroken(segment):
        states[rows] = _stretch_states(np.abs(qd[rows]) < SLOW, period)
    return states


def _stretch_states(slow: Mask, period: float) -> States:
    stopped = binary_opening(slow, np.ones((max(1, round(STOP / period)), 1)))
    relaxing = stopped & _near(~stopped, RELAXING, period)
    states = np.full(slow.shape, MOVING)
    states[_near(slow & ~stopped, REACH, period)] = REVERSING
    states[_near(relaxing, REACH, period)] = SETTLING
    states[stopped & ~relaxing] = RESTING
    states[(states == RESTING).all(axis=1)] = STILL
    return states


def _near(where: Mask, seconds: float, period: float) -> Mask:
    """Samples at most so many seconds from one where it holds."""
    window = 2 * round(seconds / period) + 1
    near = maximum_filter1d(where.astype(np.uint8), window, axis=0, mode="nearest")
    return np.asarray(near > 0)


def is_still(states: States) -> Mask:
    """(N,) where no joint moves."""
    return np.asarray((states % STATES == STILL).all(axis=1))
