"""Finite Fourier series, and those among them that begin and end at rest (Swevers 1997)."""

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


def resting_series(period: float, harmonics: int) -> Array:
    """Return a basis (2 H, 2 H - 3) of the coefficients of all series that begin and end at rest.

    Higher harmonics are smaller, in proportion to 1/k, so that all columns have similar velocities.
    """
    from scipy.linalg import null_space  # not needed where a plan is only checked

    falling = 1 / np.tile(np.arange(1, harmonics + 1), 2)
    basis: Array = null_space(rest_conditions(period, harmonics) * falling)
    return falling[:, None] * basis
