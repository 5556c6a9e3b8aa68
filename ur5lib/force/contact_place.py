"""The place of contacts: wrenches moved from it to frame 6, and the place that a sensor shows."""

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.force.sensed_contact import in_contact
from ur5lib.timeseries.arrays import Array


def jacobian_at(jacobian: Array, place: Array) -> Array:
    """Return the Jacobian (N, 6, n) of a place, with the velocity v + ω × p.

    jacobian: of the origin of frame 6, (N, 6, n); place: p (N, 3) [m], from this origin, base axes.
    """
    linear, angular = jacobian[:, :3], jacobian[:, 3:]
    moved = linear + np.cross(angular, place[:, :, None], axis=1)
    return np.concatenate([moved, angular], axis=1)


def wrench_at_flange(wrench: Array, place: Array) -> Array:
    """Return a wrench (N, 6) [N, Nm] moved to the origin of frame 6, with the moment n + p × F.

    wrench: [F, n] at the place, (N, 6); place: p (N, 3) [m], from the origin of frame 6, base axes.
    """
    force, moment = wrench[:, :3], wrench[:, 3:]
    return np.hstack([force, moment + np.cross(place, force)])


def std_at_flange(std: Array, place: Array) -> Array:
    """Return the standard deviation (N, 6) of the wrench by `wrench_at_flange`; std: (N, 6), of
    independent errors.
    """
    force, moment = std[:, :3] ** 2, std[:, 3:] ** 2
    # (p × F)_x = p_y F_z - p_z F_y
    square = place**2
    lifted = square[:, [1, 2, 0]] * force[:, [2, 0, 1]] + square[:, [2, 0, 1]] * force[:, [1, 2, 0]]
    return np.sqrt(np.hstack([force, moment + lifted]))


def sensed_place(wrench: Array, rotation: Array) -> tuple[Array, float] | None:
    """Return the place (3,) [m] in frame 6 at which a sensor's forces act, and the rms of the
    moments left over the rms force [m]; None without contacts.

    n = p × F by least squares. wrench: (N, 6) [N, Nm], base axes, at the origin of frame 6;
    rotation: R_6 (N, 3, 3).
    """
    pushed = in_contact(np.linalg.norm(wrench[:, :3], axis=1)) & finite_rows(wrench)
    if not pushed.any():
        return None
    force, moment = (
        np.matvec(rotation[pushed].mT, half) for half in np.split(wrench[pushed], 2, 1)
    )
    # p × F = -[F]× p
    columns = -np.cross(force[:, :, None], np.eye(3)[None], axis=1)
    place, *_ = np.linalg.lstsq(columns.reshape(-1, 3), moment.ravel())
    left = moment - np.cross(place, force)
    return place, float(np.sqrt((left**2).sum() / (force**2).sum()))
