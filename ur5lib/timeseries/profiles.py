"""Profiles of motions: Fourier series that may begin and end at rest (Swevers 1997), trapezoids."""

import numpy as np

from ur5lib.timeseries.arrays import Array


def fourier_terms(period: float, harmonics: int, time: Array) -> list[Array]:
    """Return sines, then cosines, of all harmonics of 1/period, and their first three derivatives.

    period: [s]; time: (N,) [s]. Four arrays (N, 2 H): 1, 1/s, 1/s², 1/s³.
    """
    omega = 2 * np.pi / period * np.arange(1, harmonics + 1)
    sin, cos = np.sin(np.outer(time, omega)), np.cos(np.outer(time, omega))
    return [
        np.hstack([sin, cos]),
        np.hstack([omega * cos, -omega * sin]),
        np.hstack([-(omega**2) * sin, -(omega**2) * cos]),
        np.hstack([-(omega**3) * cos, omega**3 * sin]),
    ]


def rest_conditions(period: float, harmonics: int) -> Array:
    """Return C (3, 2 H), rows of length one: a series with C a = 0 begins at zero and at rest.

    Value, velocity and acceleration vanish at the start and, the series being periodic, at the end.
    """
    start = np.concatenate(fourier_terms(period, harmonics, np.zeros(1))[:3])
    return np.asarray(start / np.linalg.norm(start, axis=1, keepdims=True))


def duration(way: Array, speed: float, acceleration: float) -> tuple[float, float, float]:
    """Return the duration of the acceleration, the start of the braking, and the end [s] of a move.

    way: of the joints (6,) [rad]; speed [rad/s], acceleration [rad/s²]: of the joint with the
    longest way.
    """
    longest = np.abs(way).max()
    # without cruising where the way is too short to reach the speed
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
