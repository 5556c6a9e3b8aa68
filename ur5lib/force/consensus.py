"""Which linear model most samples of a record agree with, though most may be of something else.

A record is of readings (N, 6), each of which terms (N, 6, P) times parameters (P,) should explain.
What follows is a RANSAC (Fischler, Bolles 1981) whose draws are short quiet stretches: what is
held by a hand moves more than what nothing touches.
"""

import numpy as np
from numpy.typing import NDArray

from ur5lib.timeseries.arrays import Array, Mask

STRETCH = 0.1  # s
DRAWS, TOGETHER = 600, 3  # candidates, and of how many stretches each where one is not enough
CONDITION = 1e-3  # of singular values: what the stretches hardly tell apart stays small


def agreement(parameters: Array, terms: Array, reading: Array, tolerance: Array) -> Mask:
    """Which of the samples agree with each of K candidates: (K, N).

    parameters: (K, P); terms: (N, 6, P); reading: (N, 6); tolerance: (6,) in its units.
    """
    explained = np.tensordot(parameters, terms, axes=(1, 2))
    agrees: Mask = np.all(np.abs(reading - explained) <= tolerance, axis=2)
    return agrees


def drawn(values: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """At most so many of some indices, at random, so that no period hides; the same each time."""
    if len(values) <= count:
        return values
    return np.random.default_rng(0).choice(values, count, replace=False)


def quiet_stretches(
    reading: Array, period: float, scale: Array
) -> tuple[NDArray[np.intp], Array, Array]:
    """The quieter half of a record's short stretches.

    reading: (N, 6), NaN rows allowed; period: [s]; scale: (6,), what counts as equally large.
    Returns the rows (S,) in their middle, their means (S, 6), and the median of their standard
    deviations (6,).
    """
    length = max(2, round(STRETCH / period))
    count = len(reading) // length
    parts = reading[: count * length].reshape(count, length, 6)
    std = parts.std(axis=1)
    unrest = np.square(std / scale).mean(axis=1)
    known = np.flatnonzero(np.isfinite(unrest))
    quiet = known[np.argsort(unrest[known], kind="stable")[: -(-len(known) // 2)]]
    noise = np.median(std[quiet], axis=0) if len(quiet) else np.zeros(6)
    return quiet * length + length // 2, parts[quiet].mean(axis=1), noise


def candidates(terms: Array, reading: Array, scale: Array, together: int) -> Array:
    """Parameters (K, P) that explain some of the quiet stretches, nearly or exactly.

    terms: (S, 6, P); reading: (S, 6); scale: (6,); together: how many stretches it takes to
    determine the parameters. The draws are the same each time.
    """
    stretches = np.arange(len(terms))
    if not len(terms):
        return np.zeros((0, terms.shape[2]))
    if together == 1:
        chosen = drawn(stretches, DRAWS)[:, None]
    else:
        chosen = np.random.default_rng(0).choice(stretches, (DRAWS, together))
    rows = (terms[chosen] / scale[:, None]).reshape(len(chosen), 6 * together, terms.shape[2])
    values = (reading[chosen] / scale).reshape(len(chosen), 6 * together, 1)
    return (np.linalg.pinv(rows, rcond=CONDITION) @ values)[..., 0]
