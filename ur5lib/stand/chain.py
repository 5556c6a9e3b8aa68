"""The UR5's measured values, for the joints of any arm."""

import numpy as np

from ur5lib.timeseries.arrays import Array


def along_chain(values: Array, joints: int) -> Array:
    """Return values of the UR5's joints, from base to wrist (6,), for an arm's joints (joints,)."""
    places = np.linspace(0, len(values) - 1, joints)
    return np.asarray(np.interp(places, np.arange(len(values)), values))
