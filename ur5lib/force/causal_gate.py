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
    diagonal,
    log_density,
    log_odds,
    measurement_noise,
    state_chain,
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
    observations = Observations.of(run.thinned(thinning(run.period), rows), jacobian, model, prior)
    probability = _filtered_probability(observations, starts(run.segment[rows]))
    # between two samples that are used, the odds stay
    latest = np.searchsorted(rows, np.arange(len(run.segment)), side="right") - 1
    return log_odds(probability)[latest]


def _filtered_probability(observations: Observations, starts_stretch: Mask) -> Array:
    """Return the probability (n,) of contact; starts_stretch: (n,), where a stretch starts."""
    torque = observations.torque
    jacobian = observations.jacobian
    noise = observations.noise
    worth = observations.worth
    measured = finite_rows(torque)
    free_covariances = np.stack(observations.free_covariances())
    bank = np.stack(observations.prior.bank())
    # of the torque in contact, beside the contact's own
    touched = diagonal(noise.quick + noise.hidden)
    transitions, start = state_chain(
        len(free_covariances), len(bank), observations.period, observations.prior
    )
    decay = np.exp(-observations.period * observations.model.rate[observations.states])
    contact = np.empty(len(torque))
    for t in range(len(torque)):
        if starts_stretch[t]:
            weight, b, P = start, np.zeros_like(torque[t]), np.diag(noise.spread[t])
        # prediction: p⁻ = Aᵀ p;  b⁻ = a b, P⁻ = a P a + (1 - a²) Q
        weight = weight @ transitions
        a = decay[t]
        b, P = a * b, a[:, None] * P * a + np.diag((1 - a**2) * noise.spread[t])
        if measured[t]:
            innovation = torque[t] - b
            # p ∝ p⁻ N(τ - b⁻; 0, S + P⁻), in contact S + S_hidden + P⁻ + Jᵀ P_F J
            contact_covariances = touched[t] + jacobian[t].T @ bank @ jacobian[t]
            evidence = worth * log_density(
                innovation, np.concatenate([free_covariances[:, t], contact_covariances]) + P
            )
            weight = np.maximum(weight * np.exp(evidence - evidence.max()), MIN_STATE_PROBABILITY)
            weight /= weight.sum()
            # correction: V = P⁻ + cov v, b = b⁻ + P⁻ V⁻¹ (τ - b⁻), P = P⁻ - P⁻ V⁻¹ P⁻
            noise_covariance = measurement_noise(
                free_covariances[:, t, None],
                weight[None],
                weight[None, len(free_covariances) :].sum(1),
            )
            gain = np.linalg.solve(P + noise_covariance[0] / worth, P)
            b, P = b + innovation @ gain, P - P @ gain
        contact[t] = weight[len(free_covariances) :].sum()
    return contact
