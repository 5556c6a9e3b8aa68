"""A hidden Markov chain, by Bayes' rule over all of its histories."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.gate import log_density, log_odds, measurement_noise, posterior, state_chain

SAMPLES, STATES = 6, 3
CERTAIN = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # states in turn


def problem(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Evidence, transitions and start."""
    random = np.random.default_rng(seed)
    steps = random.dirichlet(np.ones(STATES), STATES)
    return random.normal(0, 2, (SAMPLES, STATES)), steps, random.dirichlet(np.ones(STATES))


def enumerated(evidence: np.ndarray, steps: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Probability of each state at each sample, by the weight of every possible history."""
    total = np.zeros(evidence.shape)
    samples = np.arange(len(evidence))
    for history in np.ndindex(*([evidence.shape[1]] * len(evidence))):
        states = np.array(history)
        weight = start[states[0]] * steps[states[:-1], states[1:]].prod()
        total[samples, states] += weight * np.exp(evidence[samples, states].sum())
    return total / total.sum(axis=1, keepdims=True)


@pytest.mark.parametrize("seed", range(5))
def test_smoothing_is_bayes_rule_over_all_histories(seed: int) -> None:
    given = problem(seed)
    np.testing.assert_allclose(posterior(*given), enumerated(*given), atol=1e-12)


def test_what_cannot_be_is_not() -> None:
    """Whatever single samples say, states that follow in turn do so."""
    evidence = np.random.default_rng(1).normal(0, 20, (9, STATES))
    found = posterior(evidence, CERTAIN, np.array([1.0, 0, 0]))
    np.testing.assert_array_equal(found.argmax(axis=1), [0, 1, 2] * 3)


def test_ten_thousand_certain_samples_neither_overflow_nor_underflow() -> None:
    evidence = np.zeros((10000, 2))
    evidence[:, 1] = np.where(np.arange(10000) < 5000, -1e4, 1e4)
    steps = np.array([[0.99, 0.01], [0.1, 0.9]])
    probability = posterior(evidence, steps, np.array([0.5, 0.5]))
    np.testing.assert_allclose(probability[:, 1], np.arange(10000) >= 5000, atol=1e-9)
    assert np.isfinite(log_odds(probability[:, 1])).all()


def test_the_density_is_that_of_the_normal_distribution() -> None:
    random = np.random.default_rng(2)
    x, root = random.normal(size=(20, 6)), random.normal(size=(20, 6, 6))
    covariance = root @ root.mT + 1e-3 * np.eye(6)
    pairs = zip(x, covariance, strict=True)
    expected = [multivariate_normal(cov=own).logpdf(row) for row, own in pairs]
    found = log_density(x, covariance) - 3 * np.log(2 * np.pi)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_log_odds_are_those_of_the_probability() -> None:
    probability = np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    odds = log_odds(probability)
    np.testing.assert_allclose(1 / (1 + np.exp(-odds)), probability, atol=1e-12)
    assert (np.diff(odds) > 0).all()


def test_the_gates_chain_goes_from_free_to_contact_to_hunting_to_free() -> None:
    """Each at its rate; shared evenly by the sizes of contacts."""
    prior = ContactPrior(15.0, pause=20.0, duration=2.0, settling=5.0)
    transitions, start = state_chain(6, 0.01, prior)
    np.testing.assert_allclose(transitions.sum(axis=1), 1)
    rates = transitions / 0.01
    np.testing.assert_allclose(rates[:2, 2:], 1 / 20 / 6)
    np.testing.assert_array_equal(rates[0, 1], 0)
    np.testing.assert_allclose(rates[1, 0], 1 / 5)
    np.testing.assert_allclose(rates[2:, 1], 1 / 2)
    block = transitions[2:, 2:]  # no size becomes another
    np.testing.assert_array_equal(block, np.diag(np.diag(block)))
    np.testing.assert_array_equal(transitions[2:, 0], 0)
    np.testing.assert_allclose(start, [0.6, 0.3, *[0.1 / 6] * 6])


def test_a_likely_contact_makes_a_sample_count_less() -> None:
    """cov / p(free): by the sample's own covariance where the arm is surely free."""
    covariance = np.array([[2.0, 0.5], [0.5, 1.0]])
    contact = np.array([0.0, 0.1, 0.3, 1.0])
    free = (1 - contact)[:, None] * [0.25, 0.75]
    noise = measurement_noise([covariance, covariance], np.c_[free, contact], contact)
    np.testing.assert_allclose(noise[0], covariance)
    np.testing.assert_allclose(noise[:3] * (1 - contact)[:3, None, None], noise[[0, 0, 0]])
    assert (noise[3] > 100 * covariance).all()
