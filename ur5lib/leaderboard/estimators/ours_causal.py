"""F̂ᵐᵃᵖ without its gate, from past samples only.

    F̂ = Σ p(P | τ) P J (Jᵀ P J + S)⁻¹ τ,   p(P | τ) ∝ N(τ; 0, Jᵀ P J + S)

The torque is that of a causal momentum observer, less the load friction that the contact adds;
this and the noise S are those of F̂ᵐᵃᵖ. A
contact is assumed at all times, as with the other causal estimators, because a gate needs evidence:
filtered forwards, ours shows less than 63 % of a step of 15 N even after a second. Offline, F̂ᵐᵃᵖ
learns how large a contact is from all of its samples; here, each sample chooses among the typical
size and larger ones, which gives the prior the heavy tail that large forces need.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import softmax

from ur5lib.force.contact_prior import ContactPrior, wrench_covariance
from ur5lib.force.contact_wrench import ContactWrench, contact_wrench
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.gate import TorqueVariances, diagonal, log_density
from ur5lib.force.residual_model import ResidualModel
from ur5lib.leaderboard.estimator import Contender, Learned
from ur5lib.leaderboard.estimators.momentum_observer import FirstOrder
from ur5lib.leaderboard.force import breakaway_of, learned_noise
from ur5lib.leaderboard.run import Estimate, Run
from ur5lib.leaderboard.tuning import least_false
from ur5lib.timeseries.arrays import Array

OURS_CAUSAL = "F̂ᵐᵃᵖ, causal"
OBSERVER_GAINS = (20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0)  # of the observer [1/s]
PRIOR = ContactPrior()
PRIOR_COVARIANCES = [  # P: the typical contact, and larger ones
    wrench_covariance(size, PRIOR.lever) for size in PRIOR.sizes if size >= PRIOR.force
]


@dataclass(frozen=True)
class CausalMap:
    """gain: of the observer [1/s]; model: of its torque without contact."""

    gain: float
    model: ResidualModel = field(repr=False)

    def estimate(self, run: Run) -> Estimate:
        """Return the wrench and its standard deviation, NaN where the torque is unknown."""
        torque = FirstOrder(self.gain).torque(run)
        finite = finite_rows(torque) & finite_rows(run.jacobian.reshape(-1, 36))
        wrench, std = np.full_like(torque, np.nan), np.full_like(torque, np.nan)
        noise = TorqueVariances.of(
            run.states[finite], self.model, PRIOR, np.zeros_like(torque[finite])
        )
        gears = run.gears.at(finite).where_moving(run.states[finite])
        carried, _ = gears.contact_torque(torque[finite])
        mixed = mixed_wrench(carried, run.jacobian[finite], noise)
        wrench[finite], std[finite] = mixed.mean, np.sqrt(mixed.variance)
        return Estimate(wrench, std)

    def torque(self, run: Run) -> Array:
        """Return the joint torques Jᵀ F (N, 6) [Nm] that the estimate explains."""
        return (run.jacobian.mT @ self.estimate(run).wrench[..., None])[..., 0]


def mixed_wrench(torque: Array, jacobian: Array, noise: TorqueVariances) -> ContactWrench:
    """Return mean and variance (n, 6) of the wrench over the sizes of contacts, sample by sample.

    torque: (n, 6) [Nm]; jacobian: (n, 6, 6).
    """
    spread = diagonal(noise.spread + noise.hidden)
    likely = softmax(
        [log_density(torque, spread + jacobian.mT @ size @ jacobian) for size in PRIOR_COVARIANCES],
        axis=0,
    )
    # an infinite period: no sample depends on another
    of_sizes = [
        contact_wrench(torque, jacobian, spread, 1.0, np.inf, PRIOR, size)
        for size in PRIOR_COVARIANCES
    ]
    # E[F] = Σ p F̂, E[F²] = Σ p (var + F̂²)
    pairs = [*zip(likely[..., None], of_sizes, strict=True)]
    mean = sum(p * of_size.mean for p, of_size in pairs)
    square = sum(p * (of_size.variance + of_size.mean**2) for p, of_size in pairs)
    return ContactWrench(mean, square - mean**2)


def learn(runs: Sequence[Run]) -> Learned:
    """Tune the gain by the rule for all."""
    breakaway = breakaway_of(runs)
    tried = [
        CausalMap(gain, learned_noise(FirstOrder(gain).torque, runs, breakaway))
        for gain in OBSERVER_GAINS
    ]
    return least_false(tried, runs, lambda candidate: candidate.estimate)


ESTIMATORS = [Contender(OURS_CAUSAL, "ours", True, learn)]
