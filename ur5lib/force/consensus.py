"""Robust linear regression by consensus: RANSAC (Fischler and Bolles 1981).

The model is reading (N, 6) = terms (N, 6, P) times parameters (P,). Candidates are fitted to short
quiet stretches, because a tool that a hand holds moves more than one that nothing touches. So the
outliers may be the majority.
"""

import numpy as np
from numpy.typing import NDArray

from ur5lib.timeseries.arrays import Array, Mask

STRETCH = 0.1  # s
DRAWS, TOGETHER = 600, 3  # candidates; stretches for each where one does not determine it
CONDITION = 1e-3  # of singular values: poorly determined combinations of parameters stay small


def agreement(parameters: Array, terms: Array, reading: Array, tolerance: Array) -> Mask:
    """Return which of the samples agree with each of K candidates: (K, N).

    parameters: (K, P); terms: (N, 6, P); reading: (N, 6); tolerance: (6,) in the reading's units.
    """
    explained = np.tensordot(parameters, terms, axes=(1, 2))
    agrees: Mask = np.all(np.abs(reading - explained) <= tolerance, axis=2)
    return agrees


def drawn(values: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Return at most `count` of the indices, drawn at random from a fixed seed.

    A regular choice could coincide with a period of the signal.
    """
    if len(values) <= count:
        return values
    return np.random.default_rng(0).choice(values, count, replace=False)


def quiet_stretches(
    reading: Array, period: float, scale: Array
) -> tuple[NDArray[np.intp], Array, Array]:
    """Find the quieter half of a record's short stretches.

    reading: (N, 6), NaN rows allowed; period: [s]; scale: (6,), units in which components are
    compared. Returns the stretches' middle rows (S,), their means (S, 6), and the median of their
    standard deviations (6,).
    """
    length = max(2, round(STRETCH / period))
    count = len(reading) // length
    parts = reading[: count * length].reshape(count, length, 6)
    std = parts.std(axis=1)
    unrest = np.square(std / scale).mean(axis=1)
    # the quieter half, rounded up, of the stretches without NaN
    known = np.flatnonzero(np.isfinite(unrest))
    order = np.argsort(unrest[known], kind="stable")
    quiet = known[order[: -(-len(known) // 2)]]
    noise = np.median(std[quiet], axis=0) if len(quiet) else np.zeros(6)
    return quiet * length + length // 2, parts[quiet].mean(axis=1), noise


def candidates(terms: Array, reading: Array, scale: Array, together: int) -> Array:
    """Return candidate parameters (K, P), each fitted to a few of the quiet stretches.

    terms: (S, 6, P); reading: (S, 6); scale: (6,); together: number of stretches that determine
    the parameters. The draws come from a fixed seed.
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
