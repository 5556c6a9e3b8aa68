"""The motion of a tool on the flange, as a force sensor before it feels it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ur5lib.signals.end_effector import point_acceleration
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.chunks import in_chunks
from ur5lib.timeseries.segments import by_segment

NARROWEST = 0.1  # samples; a Gaussian below changes nothing


@dataclass(frozen=True)
class ToolMotion:
    """Weight and acceleration of what is fixed to frame 6, in its axes, (N, 3) each.

    pull: R_6ᵀ (g - a) [m/s²], what pulls on each kilogram at the origin; rate: ω [rad/s]; spin: its
    derivative α [rad/s²].
    """

    pull: Array
    rate: Array
    spin: Array

    def pull_at(self, point: Array) -> Array:
        """Return p - α × r - ω × (ω × r) (N, 3) [m/s²] at a point r (3,) [m] of frame 6."""
        centripetal = np.cross(self.rate, np.cross(self.rate, point))
        return self.pull - np.cross(self.spin, point) - centripetal

    def gyration(self, inertia: Sequence[float]) -> Array:
        """Return I α + ω × I ω (N, 3) [Nm].

        inertia: xx yy zz xy xz yz [kg m²] about the centre of mass, axes of frame 6.
        """
        xx, yy, zz, xy, xz, yz = inertia
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return self.spin @ tensor + np.cross(self.rate, self.rate @ tensor)


def tool_motion(
    rotation: Array, jacobian: Array, qd: Array, qdd: Array, gravity: Array
) -> ToolMotion:
    """Return the motion of frame 6 in its own axes.

    rotation: R_6 (N, 3, 3); jacobian: J_g (N, 6, 6); qd [rad/s], qdd [rad/s²]: (N, 6); gravity:
    (3,) [m/s²], base frame.
    """

    def felt(rotation: Array, jacobian: Array, qd: Array, qdd: Array) -> Array:
        moved = point_acceleration(rotation, jacobian, qd, qdd, np.zeros(3))
        rate = np.matvec(jacobian[:, 3:], qd)
        parts = np.stack([gravity - moved[:, :3], rate, moved[:, 3:]], axis=1)
        return parts @ rotation  # each row times R_6, that is R_6ᵀ v

    return ToolMotion(*in_chunks(felt, rotation, jacobian, qd, qdd).swapaxes(0, 1))


def expected(values: Array, segment: Labels, period: float, clock_std: float) -> Array:
    """Return the mean of values (N, M) at times that are known to a standard error [s].

    For a normal error of the clock this is a Gaussian filter. What moves faster than the clock is
    known, such as a vibration, has a mean of zero: subtracting it unfiltered would add noise.
    """
    width = clock_std / period
    if width < NARROWEST:
        return values
    return by_segment(
        partial(gaussian_filter1d, sigma=width, axis=0, mode="nearest"), values, segment
    )
