"""From what a force sensor reads to the wrench on the arm."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def bias(reading: Array, time: Array, window: float) -> Array:
    """Mean reading over the first `window` seconds, which must be free of contact.

    reading: (N, 6), sensor frame; time: (N,) [s]. Returns (6,) [N, Nm]: the sensor's own bias
    and the weight of what is mounted on it, as far as the orientation stays the same.
    """
    measured = np.isfinite(reading).all(axis=1)
    first = time[measured].min()
    return reading[measured & (time <= first + window)].mean(axis=0)


def wrench_on_arm(reading: Array, rotation: Array) -> Array:
    """Wrench of the environment on the arm, base axes, at the sensor's origin (Equation 6.11).

    reading: (N, 6) [N, Nm], sensor frame, the arm acting on the hand: hence the minus sign
    (erratum 7); rotation: (N, 3, 3), R_6. Returns (N, 6).
    """
    halves = [rotation @ half[:, :, None] for half in (reading[:, :3], reading[:, 3:])]
    return -np.concatenate(halves, axis=1)[..., 0]


def move_to_frame_6(wrench: Array, rotation: Array, position: Array) -> Array:
    """The same wrench at the origin of frame 6: n_6 = n + r x F.

    wrench: (N, 6) at the sensor's origin, base axes; rotation: (N, 3, 3), R_6;
    position: (3,) [m], the sensor's origin in frame 6 (Equation 6.10).
    """
    lever = rotation @ position
    force, moment = wrench[:, :3], wrench[:, 3:]
    return np.concatenate([force, moment + np.cross(lever, force)], axis=1)
