"""The probability of contact: a hidden Markov model of the external torque.

Its states are: free; hunting, at rest after a touch, when stick-slip makes joints wander; and
contact of one of a few magnitudes, constant until its end. The background, the slow part of a free
arm's torque, is smoothed without the contacts. Smoothing the background and computing the
probabilities of the states alternate.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ur5lib.force.background import smooth
from ur5lib.force.contact_prior import ContactPrior, wrench_covariance
from ur5lib.force.external_torque import JointState, States, finite_rows
from ur5lib.force.force_input import ForceInput, Gears
from ur5lib.force.residual_model import ResidualModel
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.kalman import Gaussians

MIN_STATE_PROBABILITY = 1e-300  # at least; so no evidence makes all states impossible
# Factor on the background's covariance in each round: small at first, so that possible contacts do
# not become part of the background.
BACKGROUND_COVARIANCE_FACTORS = (0.0, 0.5, 1.0, 1.0, 1.0)
# Above this probability of contact, a sample has the second weight in the background.
EXCLUSION_PROBABILITY = 0.5
CONTACT_SAMPLE_WEIGHT = 1e-4
QUIET_SHARE = 0.2  # a force of this share of the fast error does not count as contact
FAST_LOAD_ERROR_SHARE = 0.3  # this share of a load's error changes within half a push


def posterior(evidence: Array, transitions: Array, start: Array) -> Array:
    """Return the probability (N, ..., K) of each state at each sample, given all samples of a run.

    evidence: (N, ..., K), log-likelihood of each sample alone; transitions: (K, K), probability of
    going from one state (row) to another (column) by the next sample; start: (K,), probability
    before the first sample. Forward-backward recursion, scaled at each sample [Rabiner 1989].
    """
    likelihood = np.exp(evidence - evidence.max(axis=-1, keepdims=True))
    # both directions at once, the second from the last sample to the first
    likelihoods = np.stack([likelihood, likelihood[::-1]], axis=1)
    steps, starts = np.stack([transitions.T, transitions]), np.stack([start, np.ones_like(start)])
    of_runs = tuple(range(1, evidence.ndim - 1))
    given = (np.expand_dims(each, of_runs) for each in (steps, starts))
    forward, backward = _weights_before(likelihoods, *given).swapaxes(0, 1)
    weight = np.maximum(forward * likelihood * backward[::-1], MIN_STATE_PROBABILITY)
    return np.asarray(weight / weight.sum(axis=-1, keepdims=True))


def _weights_before(likelihood: Array, steps: Array, start: Array) -> Array:
    """Return the weight (N, ..., K) of each state before each sample; start: (..., K), before the
    first.

    likelihood: (N, ..., K); steps: (..., K, K), from a state (column) to the next (row).
    """
    predicted = np.empty_like(likelihood)
    for t, likelihoods in enumerate(likelihood):
        predicted[t] = start
        # α_t+1(j) = Σ_i a_ij p(x_t | i) α_t(i); backwards, β_t-1(i) = Σ_j a_ij p(x_t | j) β_t(j)
        following = np.matvec(steps, likelihoods * start) / np.vecdot(likelihoods, start)[..., None]
        start = np.maximum(following, MIN_STATE_PROBABILITY)
    return predicted


def log_odds(probability: Array) -> Array:
    """Return the log-odds of probabilities (N,), finite also for 0 and 1."""
    clipped = np.clip(probability, 1e-15, 1 - 1e-15)
    return np.log(clipped) - np.log1p(-clipped)


@dataclass(frozen=True)
class TorqueVariances:
    """Variances (N, n) [N²m²] of the external torque without that of a contact.

    quick: of the fast error; spread: of background and fast error together; hidden: of the part of
    a contact that dry friction may absorb; still: (N, n), which joints rest while the whole arm
    rests. Joints count as independent: correlations learnt without contact mislead in contact.
    """

    quick: Array
    spread: Array
    hidden: Array
    still: Mask

    @classmethod
    def of(cls, states: States, model: ResidualModel, doubt: Array) -> "TorqueVariances":
        """Return the variances at samples with joint states (N, n); doubt: (N, n) [Nm], standard
        deviation of a load's torque.
        """
        still = states >= JointState.STILL
        absorbed = np.where(still, model.stiction, model.rubbing) * model.breakaway
        return cls(
            quick=model.variance(model.change, states) + FAST_LOAD_ERROR_SHARE * doubt**2,
            spread=model.variance(model.spread, states) + doubt**2,
            hidden=absorbed**2,
            still=still,
        )

    def hiding(self) -> Array:
        """Return the variances S (N, n) [N²m²] of the torque in which a contact may hide."""
        return np.where(np.all(self.still, axis=1, keepdims=True), self.hidden, self.spread)


@dataclass(frozen=True)
class Observations:
    """The samples of a part without a gap, their noise, and the prior of contacts.

    torque: external (N, n) [Nm], NaN where it or the arm's pose is unknown; jacobian: (N, 6, n), 0
    where the pose is unknown; posed: which samples have a pose (N,); states: (N, n), of `model`;
    period: [s]; gears: without friction where joints rest; frames: rotations and origins of the
    links' frames, from where contacts are assumed; None: contacts are on the last link.
    """

    torque: Array
    jacobian: Array
    posed: Mask
    states: States
    period: float
    noise: TorqueVariances
    model: ResidualModel
    prior: ContactPrior
    gears: Gears
    frames: tuple[Array, Array] | None = None

    @classmethod
    def of(
        cls, run: ForceInput, jacobian: Array, model: ResidualModel, prior: ContactPrior
    ) -> "Observations":
        """Return the observations of a run; jacobian: (N, 6, n), NaN where the pose is unknown."""
        posed = finite_rows(jacobian.reshape(len(jacobian), -1))
        gears = Gears.without_friction(run.torque) if run.gears is None else run.gears
        return cls(
            torque=np.where(posed[:, None], run.torque, np.nan),
            jacobian=np.where(posed[:, None, None], jacobian, 0.0),
            posed=posed,
            states=run.states,
            period=run.period,
            noise=TorqueVariances.of(run.states, model, run.load_std()),
            model=model,
            prior=prior,
            gears=gears.where_moving(run.states),
        )

    @property
    def worth(self) -> float:
        """Return the number of independent values per sample, at most 1."""
        return min(1.0, self.period / self.model.independent)

    @cached_property
    def quiet(self) -> Array:
        """Return the covariance (6, 6) of a wrench that does not count as contact."""
        return wrench_covariance(quiet_force(self.jacobian, self.noise.quick), self.prior.lever)

    def free_covariances(self) -> list[Array]:
        """Return the covariances (N, n, n) of a free arm's torque: undisturbed, then hunting."""
        quiet = self.jacobian.mT @ self.quiet @ self.jacobian
        hunts = self.noise.still * (self.prior.hunting * self.model.breakaway) ** 2
        return [quiet + diagonal(self.noise.quick + wandering) for wandering in (0.0, hunts)]

    def contact_covariances(self) -> Iterator[Array]:
        """Yield the covariances Jᵀ P J (N, n, n) of the torque of each kind of contact."""
        by_force, by_moment = (half.mT @ half for half in np.split(self.jacobian, 2, axis=1))
        for size in self.prior.sizes():  # isotropic, both in force and moment
            yield size**2 * (by_force + self.prior.lever**2 * by_moment)


def quiet_force(jacobian: Array, variance: Array) -> float:
    """Return the size [N] of a force that does not count as contact, such as a hose's.

    It is QUIET_SHARE times the median, over samples, of the force that is worth one standard
    deviation of the fast error. jacobian: (N, 6, n); variance: of the fast error (N, n) [N²m²].
    """
    information = (jacobian[:, :3] ** 2 / variance[:, None]).sum(axis=2).mean(axis=1)
    return float(QUIET_SHARE * np.median(information) ** -0.5)


def find_contacts(observations: Observations) -> tuple[Array, Gaussians]:
    """Return the probability (N,) of contact in a part without a gap, and mean and covariance of
    the background [Nm].
    """
    [found] = _searched(observations, [observations.torque])
    return found.contact, found.background()


def contact_probabilities(observations: Observations, torques: Array) -> list[Array]:
    """Return the probability (N,) of contact with each of some torques (R, N, n) [Nm] instead of
    the observed one.
    """
    return [one.contact for one in _searched(observations, torques)]


def _searched(observations: Observations, torques: Iterable[Array]) -> list["_Search"]:
    """Return the search for contacts in each torque (N, n) [Nm], which differ in nothing else."""
    free = observations.free_covariances()
    searches = [_Search(observations, free, torque) for torque in torques]
    chain = state_chain(len(observations.prior.sizes()), observations.period, observations.prior)
    for number, share in enumerate(BACKGROUND_COVARIANCE_FACTORS):
        evidence = [one.free_evidence(share) for one in searches]
        for contact in observations.contact_covariances():
            for one, own in zip(searches, evidence, strict=True):
                own.append(one.contact_evidence(share, contact))
        counted = [one.counted(own) for one, own in zip(searches, evidence, strict=True)]
        weights = posterior(np.stack(counted, axis=1), *chain)  # (N, R, S)
        for one, weight in zip(searches, weights.swapaxes(0, 1), strict=True):
            one.take(weight)
            if number < len(BACKGROUND_COVARIANCE_FACTORS) - 1:
                one.smooth()
    return searches


class _Search:
    """The search for contacts in one torque: their probability (N,), and the background so far."""

    def __init__(self, observations: Observations, free: list[Array], torque: Array) -> None:
        self.observations, self.free, self.torque = observations, free, torque
        measured = finite_rows(torque)[:, None]
        self.filled, self.worth = np.where(measured, torque, 0.0), observations.worth * measured
        start = np.zeros_like(torque), diagonal(observations.noise.spread)
        self.slow = self.resting = Gaussians(*start)

    def free_evidence(self, share: float) -> list[Array]:
        """Return log p(τ | state) (N,) of each state of a free arm."""
        mean, covariance = self.resting
        return [log_density(self.filled - mean, own + share * covariance) for own in self.free]

    def contact_evidence(self, share: float, contact: Array) -> Array:
        """Return log N(τ; b, S + S_hidden + P_b + Jᵀ P J) (N,); contact: Jᵀ P J (N, n, n)."""
        noise = self.observations.noise
        others = diagonal(noise.quick + noise.hidden) + share * self.slow.covariance
        return log_density(self.filled - self.slow.mean, others + contact)

    def counted(self, evidence: list[Array]) -> Array:
        """Return the evidence (N, S) as it counts: 0 where τ is unknown."""
        return np.stack(evidence, axis=1) * self.worth

    def take(self, weight: Array) -> None:
        """Set the probabilities (N, S) of the states."""
        self.weight = weight
        # p(contact) = Σ p(state | all τ) over the states in contact
        self.contact = weight[:, len(self.free) :].sum(axis=1)

    def background(self, resting: bool = False) -> Gaussians:
        """Return the background given all τ, each weighted by the probability of a free arm.

        A push at rest may renew the background: it changes what stiction carries. resting: without
        that.
        """
        seen = self.observations
        measured = measurement_noise(self.free, self.weight, self.contact) / seen.worth
        renewed = 0.0 if resting else seen.noise.still * self.contact[:, None] / seen.prior.duration
        decay = np.exp(-seen.period * (seen.model.rate[seen.states] + renewed))
        scaled = -seen.gears.friction, seen.prior.friction_std
        return smooth(self.torque, measured, seen.noise.spread, decay, *scaled)

    def smooth(self) -> None:
        """Smooth the background; free states need the one that no push renews."""
        self.slow = self.resting = self.background()
        if self.observations.noise.still.any():
            self.resting = self.background(resting=True)


def measurement_noise(
    free_covariances: Array | Sequence[Array], weight: Array, contact: Array
) -> Array:
    """Return the covariance (N, n, n) of the torque as a measurement of the background.

    It is Σ p(free state) cov / p(free); in contact, the sample counts almost nothing. weight: (N,
    K) probabilities of states, free ones first; contact: (N,).
    """
    share = weight[:, : len(free_covariances)] + 1e-12
    share = share / share.sum(axis=1, keepdims=True)
    # Σ p(k) cov_k over the free states k
    mean = sum(
        state_weight[:, None, None] * c
        for state_weight, c in zip(share.T, free_covariances, strict=True)
    )
    free_weight = np.where(
        contact > EXCLUSION_PROBABILITY,
        CONTACT_SAMPLE_WEIGHT,
        np.maximum(1 - contact, CONTACT_SAMPLE_WEIGHT),
    )
    return np.asarray(mean / free_weight[:, None, None])


def state_chain(sizes: int, period: float, prior: ContactPrior) -> tuple[Array, Array]:
    """Return transition (S, S) and start (S,) probabilities of the states.

    They are free, hunting, and contacts of some sizes; period: [s].
    free → contact → hunting → free; an arm that hunts may be touched, and a free one never hunts.
    """
    # probabilities per sample of leaving a state
    begins, ends = period / prior.pause, period / prior.duration
    settles = period / prior.settling
    steps = np.zeros((2 + sizes, 2 + sizes))
    steps[:2, 2:] = begins / sizes
    steps[0, 0] = 1 - begins
    steps[1, :2] = settles, 1 - begins - settles
    steps[2:, 2:] = np.eye(sizes) * (1 - ends)
    steps[2:, 1] = ends
    return steps, np.array([0.6, 0.3, *[0.1 / sizes] * sizes])


def diagonal(variance: Array) -> Array:
    """Return diagonal matrices (N, n, n) of variances (N, n)."""
    return variance[:, :, None] * np.eye(variance.shape[1])


def log_density(x: Array, covariance: Array) -> Array:
    """Return the log-density (N,) of a normal distribution around zero, up to a constant.

    p(x) = p(x_1) p(x_2 | x_1) ..., of all samples at once: one variable after the other is
    eliminated. x: (N, n), or (n,) of all; covariance: (N, n, n).
    """
    remainder = np.broadcast_to(x, covariance.shape[:-1]).T.copy()  # (n, N)
    within = np.moveaxis(covariance, 0, -1).copy()  # (n, n, N)
    density = np.zeros(len(covariance))
    for k, variance in enumerate(np.einsum("iin->in", within)):
        density -= (remainder[k] ** 2 / variance + np.log(variance)) / 2
        share = within[k + 1 :, k] / variance
        remainder[k + 1 :] -= share * remainder[k]
        within[k + 1 :, k + 1 :] -= share[:, None] * within[k, k + 1 :]
    return density
