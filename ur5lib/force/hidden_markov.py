"""Hidden Markov model: probabilities of the states at each sample."""

import numpy as np

from ur5lib.timeseries.arrays import Array


def posterior(evidence: Array, transitions: Array, start: Array) -> Array:
    """Return the probability (N, K) of each state at each sample, given all samples.

    evidence: (N, K), log-likelihood of each sample alone; transitions: (K, K), probability of going
    from one state (row) to another (column) by the next sample; start: (K,), before the first.
    Forward-backward recursion [Rabiner 1989] in logarithms, which neither under- nor overflow.
    """
    steps = _logarithm(transitions)
    forward, backward = filtered(evidence, transitions, start), np.zeros_like(evidence)
    for t in range(len(evidence) - 2, -1, -1):
        # β_t(i) = Σ_j a_ij p(x_t+1 | j) β_t+1(j), scaled
        backward[t] = _log_sum(steps + (evidence[t + 1] + backward[t + 1]), axis=1)
        backward[t] -= backward[t].max()
    return _normalised(forward + backward)


def filtered(evidence: Array, transitions: Array, start: Array) -> Array:
    """Return the log-probability (N, K) of each state given past samples; arguments as above."""
    steps, forward = _logarithm(transitions), np.empty_like(evidence)
    before = _logarithm(start)
    for t in range(len(evidence)):
        # α_t(j) = p(x_t | j) Σ_i α_t-1(i) a_ij, normalised
        forward[t] = before + evidence[t]
        forward[t] -= _log_sum(forward[t], axis=0)
        before = _log_sum(forward[t][:, None] + steps, axis=0)
    return forward


def log_odds(probability: Array) -> Array:
    """Return the log-odds of probabilities (N,), finite also for 0 and 1."""
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
