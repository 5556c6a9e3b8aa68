"""Contact or not, as a hidden Markov chain of two states."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def log_odds(evidence: Array, start: float, stop: float) -> Array:
    """Log-odds of "contact" against "free" at each sample, given all samples.

    evidence: (N,), log-likelihood ratio contact : free of each sample alone; start, stop:
    probability that a contact starts, or stops, from one sample to the next. Forward-backward
    recursion [Rabiner 1989], written in log-odds: they neither under- nor overflow.
    """
    forward, backward = np.empty_like(evidence), np.zeros_like(evidence)
    starts, stops, pauses, lasts = np.log([start, stop, 1 - start, 1 - stop])
    forward[0] = np.log(start / stop) + evidence[0]
    for t in range(1, len(evidence)):
        forward[t] = evidence[t] + _mixed(forward[t - 1], starts, lasts, pauses, stops)
    for t in range(len(evidence) - 2, -1, -1):
        later = evidence[t + 1] + backward[t + 1]
        backward[t] = _mixed(later, stops, lasts, pauses, starts)
    return forward + backward


def _mixed(odds: float, a: float, b: float, c: float, d: float) -> float:
    """log (a + b e^odds) / (c + d e^odds), of the logarithms of a to d."""
    return float(np.logaddexp(a, odds + b) - np.logaddexp(c, odds + d))


def probability(odds: Array) -> Array:
    """Of log-odds."""
    return 1 / (1 + np.exp(-np.clip(odds, -50, 50)))
