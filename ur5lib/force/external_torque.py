"""The external torque on the joints, and the state of motion of each joint."""

from enum import IntEnum

import numpy as np
import scipy  # loads scipy.ndimage at its first use
from numpy.typing import NDArray

from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import unbroken
from ur5lib.timeseries.trajectories import REST_SPEED

States = NDArray[np.int8]

MIN_STOP_DURATION = 0.4  # s; a joint that is slow for a shorter time reverses
RELAXATION_TIME = 1.0  # s; friction relaxes for this long after a stop
REACH_IN_PERIODS = 0.5  # a low-pass spreads the friction of a reversal over this many periods


class JointState(IntEnum):
    """The state of motion of a joint, on which the uncertainty of its friction depends."""

    MOVING = 0
    REVERSING = 1  # near a change of direction
    SETTLING = 2  # stopped for less than RELAXATION_TIME, or about to start
    RESTING = 3  # at rest while another joint moves
    STILL = 4  # all joints rest
    TARED = 5  # as STILL, after a tare that still applies


FITTED_STATE_COUNT = len(JointState) - 1  # all but TARED, which follows from STILL


def external_torque(torque_constant: Array, current: Array, modelled: Array) -> Array:
    """Return tau_ext = J^T F = k (i_modelled - i), the environment acting on the arm.

    torque_constant: (6,) [Nm/A]; current, modelled: (N, 6) [A], measured, and predicted for the
    same motion without contact. Returns (N, 6) [Nm]. The thesis's Equation 6.8 has the opposite
    sign: the arm acting on its environment.
    """
    return torque_constant * (modelled - current)


def finite_rows(values: Array) -> Mask:
    """Return which rows (N,) of values (N, M) are finite in all columns."""
    return np.asarray(np.isfinite(values).all(axis=1))


def joint_states(qd: Array, segment: Labels, period: float, cutoff: float) -> States:
    """Return the `JointState` (N, 6) of each joint.

    qd: (N, 6) [rad/s]; period: [s]; cutoff: of the torque's low-pass [Hz], which blurs reversals.
    """
    reach = REACH_IN_PERIODS / cutoff
    states = np.full(qd.shape, JointState.MOVING, np.int8)
    for rows in unbroken(segment):
        slow, stretch = np.abs(qd[rows]) < REST_SPEED, states[rows]
        # a joint that is slow only for a moment has not stopped
        stop_rows = max(1, round(MIN_STOP_DURATION / period))
        stopped = scipy.ndimage.binary_opening(slow, np.ones((stop_rows, 1), np.bool_))
        relaxing = stopped & _within_reach(~stopped, RELAXATION_TIME, period)
        stretch[_within_reach(slow & ~stopped, reach, period)] = JointState.REVERSING
        stretch[_within_reach(relaxing, reach, period)] = JointState.SETTLING
        stretch[stopped & ~relaxing] = JointState.RESTING
        stretch[(stretch == JointState.RESTING).all(axis=1)] = JointState.STILL
    return states


def _within_reach(where: Mask, seconds: float, period: float) -> Mask:
    """Return a mask (N, n) that is also true within some seconds before and after."""
    return scipy.ndimage.maximum_filter1d(
        where, 2 * round(seconds / period) + 1, axis=0, mode="nearest"
    )


def is_still(states: States) -> Mask:
    """Return the samples (N,) in which all joints are STILL, none TARED."""
    return np.asarray((states == JointState.STILL).all(axis=1))
