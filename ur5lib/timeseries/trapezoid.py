"""Moves with trapezoidal speed, as Universal Robots' controllers plan them."""

import numpy as np

from ur5lib.timeseries.arrays import Array


def duration(way: Array, speed: float, acceleration: float) -> tuple[float, float, float]:
    """Return the duration of the acceleration, the start of the braking, and the end [s].

    way: of the joints (6,) [rad]; speed [rad/s], acceleration [rad/s²]: of the longest way.
    """
    longest = np.abs(way).max()
    ramp = min(speed / acceleration, (longest / acceleration) ** 0.5)
    cruise = longest / (acceleration * ramp) - ramp if ramp else 0.0
    return ramp, ramp + cruise, 2 * ramp + cruise


def trapezoid(time: Array, way: Array, top: float, gain: float) -> tuple[Array, Array, Array]:
    """Return position [rad], speed and acceleration (N,) of the joint with the longest way.

    time: since the start of the move (N,) [s]; way: of the joints (6,) [rad]; top: its speed
    [rad/s]; gain: its acceleration [rad/s²].
    """
    ramp, slow, end = duration(way, top, gain)
    passed = [np.clip(time - start, 0, ramp) for start in (0.0, slow)]
    cruise = np.clip(time - ramp, 0, slow - ramp)
    speed = gain * (passed[0] - passed[1])
    place = gain * (passed[0] ** 2 / 2 + ramp * cruise + ramp * passed[1] - passed[1] ** 2 / 2)
    up, down = (time >= 0) & (time < ramp), (time >= slow) & (time < end)
    return place, speed, gain * (up.astype(float) - down)
