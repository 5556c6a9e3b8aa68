"""The share of the expected friction that currents show: about 1, or less where a hand leads the
arm.
"""

import numpy as np

from ur5lib.force.external_torque import JointState, finite_rows
from ur5lib.force.force_input import ForceInput
from ur5lib.timeseries.arrays import Array

# The motors of a UR3, a UR5 and a UR10e showed 0.84 to 1.31 of usual friction in 31 recordings;
# where a hand led a UR5e, or pushed it all the way, four recordings showed 0.51 to 0.60.
MIN_SHARE = 0.7
MIN_MOTION = 1.0  # s; one joint moves at least this long


def shown_friction(run: ForceInput, breakaway: Array) -> float:
    """Return the share of the expected friction that the currents show in motion.

    It is found by least squares over all joints; breakaway: torques (n,) [Nm], in which they are
    compared. NaN where no joint moves for MIN_MOTION, or its friction is unknown.
    """
    if run.gears is None:
        return np.nan
    known = finite_rows(run.torque) & finite_rows(run.gears.friction)
    moves = known[:, None] & (run.states == JointState.MOVING)
    if not (moves.sum(axis=0) * run.period > MIN_MOTION).any():
        return np.nan
    expected = np.where(moves, run.gears.friction / breakaway, 0.0)
    missing = np.where(moves, run.torque / breakaway, 0.0)  # τ_ext = expected - measured
    return float(1 - (expected * missing).sum() / (expected**2).sum())
