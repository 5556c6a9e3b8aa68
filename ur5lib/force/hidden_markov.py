"""Hidden Markov model: probabilities of the states at each sample."""

import numpy as np

from ur5lib.timeseries.arrays import Array

LEAST = 1e-300  # of a state's probability, so that no evidence makes all of them vanish


def posterior(evidence: Array, transitions: Array, start: Array) -> Array:
    """Return the probability (N, K) of each state at each sample, given all samples.

    evidence: (N, K), log-likelihood of each sample alone; transitions: (K, K), probability of going
    from one state (row) to another (column) by the next sample; start: (K,), before the first.
    Forward-backward recursion, scaled at each sample [Rabiner 1989].
    """
    likelihood, backward = _scaled(evidence), np.ones_like(evidence)
    for t in range(len(evidence) - 2, -1, -1):
        # β_t(i) = Σ_j a_ij p(x_t+1 | j) β_t+1(j)
        after = np.maximum(transitions @ (likelihood[t + 1] * backward[t + 1]), LEAST)
        backward[t] = after / after.max()
    weight = np.maximum(filtered(evidence, transitions, start) * backward, LEAST)
    return np.asarray(weight / weight.sum(axis=1, keepdims=True))


def filtered(evidence: Array, transitions: Array, start: Array) -> Array:
    """Return the probability (N, K) of each state given past samples; arguments as above."""
    likelihood, forward = _scaled(evidence), np.empty_like(evidence)
    before = start
    for t in range(len(evidence)):
        # α_t(j) = p(x_t | j) Σ_i α_t-1(i) a_ij
        now = np.maximum(likelihood[t] * before, LEAST)
        forward[t] = now / now.sum()
        before = forward[t] @ transitions
    return forward


def log_odds(probability: Array) -> Array:
    """Return the log-odds of probabilities (N,), finite also for 0 and 1."""
    known = np.clip(probability, 1e-15, 1 - 1e-15)
    return np.log(known) - np.log1p(-known)


def _scaled(evidence: Array) -> Array:
    """Return the likelihood (N, K), 1 for the most likely state of each sample."""
    return np.exp(evidence - evidence.max(axis=1, keepdims=True))
