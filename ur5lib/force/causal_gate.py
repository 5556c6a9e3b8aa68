"""The probability of contact from past samples only: what an alarm during the motion can know.

The hidden Markov model and the background are those of `gate`. There, all samples smooth both; here
one pass filters them: the background is corrected by what each sample is worth if the arm is free.
"""

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.force_input import ForceInput
from ur5lib.force.gate import (
    MIN_STATE_PROBABILITY,
    Observations,
    chain,
    diagonal,
    log_density,
    log_odds,
    measurement_noise,
)
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.wrench_estimate import thinning, used_rows
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import starts


def causal_log_odds(
    run: ForceInput, jacobian: Array, model: ResidualModel, prior: ContactPrior
) -> Array:
    """Return the log-odds (N,) of contact at each sample, from it and the samples before.

    run: with a torque that was low-passed causally, and states by `past_states`; jacobian:
    (M, 6, n), at `used_rows`, NaN where the arm's pose is unknown; model: of such torques.
    """
    rows = used_rows(run.segment, run.period)
    seen = Observations.of(run.thinned(thinning(run.period), rows), jacobian, model, prior)
    probability = _filtered(seen, starts(run.segment[rows]))
    # between two samples that are used, the odds stay
    latest = np.searchsorted(rows, np.arange(len(run.segment)), side="right") - 1
    return log_odds(probability)[latest]


def _filtered(seen: Observations, fresh: Mask) -> Array:
    """Return the probability (n,) of contact; fresh: (n,), where a stretch starts."""
    torque, jacobian, noise, worth = seen.torque, seen.jacobian, seen.noise, seen.worth
    known = finite_rows(torque)
    free, bank = np.stack(seen.free_covariances()), np.stack(seen.prior.bank())
    touched = diagonal(
        noise.quick + noise.hidden
    )  # of the torque in contact, beside the contact's own
    transitions, start = chain(len(free), len(bank), seen.period, seen.prior)
    decay = np.exp(-seen.period * seen.model.rate[seen.states])
    contact = np.empty(len(torque))
    for t in range(len(torque)):
        if fresh[t]:
            weight, b, P = start, np.zeros_like(torque[t]), np.diag(noise.spread[t])
        # prediction: p⁻ = Aᵀ p;  b⁻ = a b, P⁻ = a P a + (1 - a²) Q
        weight = weight @ transitions
        a = decay[t]
        b, P = a * b, a[:, None] * P * a + np.diag((1 - a**2) * noise.spread[t])
        if known[t]:
            innovation = torque[t] - b
            # p ∝ p⁻ N(τ - b⁻; 0, S + P⁻), in contact S + S_hidden + P⁻ + Jᵀ P_F J
            during = touched[t] + jacobian[t].T @ bank @ jacobian[t]
            evidence = worth * log_density(innovation, np.concatenate([free[:, t], during]) + P)
            weight = np.maximum(weight * np.exp(evidence - evidence.max()), MIN_STATE_PROBABILITY)
            weight /= weight.sum()
            # correction: V = P⁻ + cov v, b = b⁻ + P⁻ V⁻¹ (τ - b⁻), P = P⁻ - P⁻ V⁻¹ P⁻
            own = measurement_noise(
                free[:, t, None], weight[None], weight[None, len(free) :].sum(1)
            )
            gain = np.linalg.solve(P + own[0] / worth, P)
            b, P = b + innovation @ gain, P - P @ gain
        contact[t] = weight[len(free) :].sum()
    return contact
