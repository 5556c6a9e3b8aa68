"""Which of several states a recording is in at each sample, as a hidden Markov chain."""

import numpy as np

from ur5lib.timeseries.arrays import Array


def posterior(evidence: Array, transitions: Array, start: Array) -> Array:
    """Probability (N, K) of each state at each sample, given all samples.

    evidence: (N, K), log-likelihood of each sample alone; transitions: (K, K), probability to go
    from one state (row) to another (column) by the next sample; start: (K,), before the first.
    Forward-backward recursion [Rabiner 1989], in logarithms: they neither under- nor overflow.
    """
    steps = _logarithm(transitions)
    forward, backward = filtered(evidence, transitions, start), np.zeros_like(evidence)
    for t in range(len(evidence) - 2, -1, -1):
        backward[t] = _log_sum(steps + (evidence[t + 1] + backward[t + 1]), axis=1)
        backward[t] -= backward[t].max()
    return _normalised(forward + backward)


def filtered(evidence: Array, transitions: Array, start: Array) -> Array:
    """Log-probability (N, K) of each state, given the samples up to each; arguments as above."""
    steps, forward = _logarithm(transitions), np.empty_like(evidence)
    before = _logarithm(start)
    for t in range(len(evidence)):
        forward[t] = before + evidence[t]
        forward[t] -= _log_sum(forward[t], axis=0)
        before = _log_sum(forward[t][:, None] + steps, axis=0)
    return forward


def log_odds(probability: Array) -> Array:
    """Log-odds of probabilities (N,), finite."""
    known = np.clip(probability, 1e-15, 1 - 1e-15)
    return np.log(known) - np.log1p(-known)


def _logarithm(probability: Array) -> Array:
    return np.log(np.maximum(probability, 1e-300))


def _log_sum(values: Array, axis: int) -> Array:
    largest = values.max(axis=axis, keepdims=True)
    total = np.log(np.exp(values - largest).sum(axis=axis))
    return np.asarray(total + largest.squeeze(axis))


def _normalised(values: Array) -> Array:
    weight = np.exp(values - values.max(axis=1, keepdims=True))
    return np.asarray(weight / weight.sum(axis=1, keepdims=True))
