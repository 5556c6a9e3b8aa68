"""The simplest estimate of the contact wrench, which others have to beat."""

import numpy as np

from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import in_chunks


def plain_least_squares(torque: Array, jacobian: Array, min_singular_value: float) -> Array:
    """Return the wrench (N, 6) [N, Nm] by least squares of the torques at all samples, in contact
    or not.

    torque: external (N, n) [Nm]; jacobian: (N, 6, n); min_singular_value: directions with smaller
    singular values are left out.
    """

    def solved(torque: Array, jacobian: Array) -> Array:
        left, size, right = np.linalg.svd(jacobian.mT, full_matrices=False)
        inverse = np.where(size > min_singular_value, 1 / size, 0.0)
        wrench: Array = np.matvec(right.mT, inverse * np.matvec(left.mT, torque))
        return wrench

    return in_chunks(solved, torque, jacobian)
