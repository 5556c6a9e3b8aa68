"""The processes that estimators of the benchmark learn torques by, on arms that are known."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor
from torch.func import jacfwd, jvp

from ur5lib.timeseries.arrays import Array
from ur5rivals import regime_process
from ur5rivals.estimators import lagrangian_process
from ur5rivals.estimators.variance_aware_kalman_filter import VarianceAware
from ur5rivals.lagrangian_kernel import Energies, Motion, each_torque, torque_covariance
from ur5rivals.learned_residual import TrainingSamples

JOINTS = 3
Energy = Callable[[Tensor, Tensor], Tensor]


def some_energies() -> Energies:
    random = np.random.default_rng(0)
    values = [random.uniform(0.3, 1.3, (JOINTS, JOINTS)), random.uniform(0, 0.9, (JOINTS, JOINTS))]
    return Energies(*map(torch.as_tensor, [*values, 2.0, random.uniform(0, 0.9, JOINTS)]))


def some_motions(seed: int, count: int) -> Motion:
    return Motion.of(np.random.default_rng(seed).normal(size=(count, 3 * JOINTS)))


def energy_covariance(energies: Energies, q: Tensor, qd: Tensor, p: Tensor, pd: Tensor) -> Tensor:
    """Return k_T + k_U of two states of the arm, as the module's head has it."""
    alike = (q - p).cos()
    total = energies.size**2 * (1 - energies.postures * (1 - alike)).prod()
    for count, (speed, turn) in enumerate(zip(energies.speeds, energies.turns, strict=True), 1):
        polynomial = ((1 - turn * (1 - alike)) ** 2)[:count].prod()
        total = total + (speed * qd * pd)[:count].sum() ** 2 * polynomial
    return total


def by_lagrange(energy: Energy, q: Tensor, qd: Tensor, qdd: Tensor) -> Tensor:
    """Return d/dt ∂/∂q̇ - ∂/∂q of an energy; the last axis of the result is that of the joints."""
    rate = jvp(lambda *state: jacfwd(energy, 1)(*state), (q, qd), (qd, qdd))[1]
    return rate - jacfwd(energy, 0)(q, qd)


def test_torques_vary_together_as_lagranges_operator_on_both_energies_says() -> None:
    energies, first, second = some_energies(), some_motions(1, 2), some_motions(2, 3)
    found = torque_covariance(first, second, energies, each_torque(second))
    for n in range(2):
        for m in range(3):
            other = [values[:, m] for values in second]

            def of_second(q: Tensor, qd: Tensor, other: list[Tensor] = other) -> Tensor:
                return by_lagrange(lambda p, pd: energy_covariance(energies, q, qd, p, pd), *other)

            expected = by_lagrange(of_second, *(values[:, n] for values in first))
            torch.testing.assert_close(found[:, :, n, m], expected)


def test_covariances_are_symmetric_and_those_of_some_torques() -> None:
    motions = some_motions(1, 20)
    blocks = torque_covariance(motions, motions, some_energies(), each_torque(motions))
    matrix = blocks.permute(1, 2, 0, 3).reshape(20 * JOINTS, 20 * JOINTS)
    torch.testing.assert_close(matrix, matrix.T)
    assert torch.linalg.eigvalsh(matrix).min() > -1e-9 * matrix.diagonal().max()


def two_links(seed: int, count: int) -> TrainingSamples:
    """Return motions (n, 6) and torques (n, 2) of two links in a vertical plane, with friction."""
    random = np.random.default_rng(seed)
    inputs = random.normal(size=(count, 6)) * [1.5, 1.5, 1, 1, 3, 3]
    q, qd, qdd = np.split(inputs, 3, axis=1)
    cos, sin, (fast, slow) = 1.5 * np.cos(q[:, 1]), 1.5 * np.sin(q[:, 1]), qd.T
    far = 15 * np.cos(q.sum(axis=1))
    first = (5 + 2 * cos) * qdd[:, 0] + (1 + cos) * qdd[:, 1] - sin * slow * (2 * fast + slow)
    second = (1 + cos) * qdd[:, 0] + qdd[:, 1] + sin * fast**2
    torque = np.stack([first + 30 * np.cos(q[:, 0]) + far, second + far], axis=1)
    return TrainingSamples(inputs, torque + 3 * np.tanh(qd / 0.01) + 2 * qd)


def test_energies_tell_the_torques_of_two_links_that_a_linear_map_does_not() -> None:
    learnt, new = two_links(0, 150), two_links(1, 100)
    found = lagrangian_process.train(learnt, learnt)(new.inputs)

    def terms(inputs: Array) -> Array:
        return np.hstack([inputs, np.sign(inputs[:, 2:4]), np.ones((len(inputs), 1))])

    mapped = terms(new.inputs) @ np.linalg.lstsq(terms(learnt.inputs), learnt.torque)[0]
    error, linear = (np.std(own - new.torque, axis=0) for own in (found, mapped))
    assert (error < 0.1 * linear).all()


def test_the_noise_of_each_regime_is_found() -> None:
    random = np.random.default_rng(0)
    noise = np.array([0.3, 3.0, 1.0, 0.6])  # Nm
    motions, regimes = random.normal(size=(300, 18)), random.integers(0, 4, (300, 6))
    torque = np.sin(motions[:, :6]) + noise[regimes] * random.normal(size=(300, 6))
    samples = TrainingSamples(np.hstack([motions, regimes]), torque)
    variance = regime_process.train(samples, samples)(samples.inputs)[:, 6:]
    found = [np.sqrt(np.median(variance[regimes == k])) for k in regime_process.REGIMES]
    assert found == pytest.approx(noise, rel=0.35)


def test_a_torque_of_great_variance_moves_the_estimate_little() -> None:
    measured, variance = np.zeros((400, 6)), np.ones((400, 6))
    measured[200:220], variance[200:220, :3] = 5.0, 100.0
    own = VarianceAware(2.0, np.ones(6), lambda _: np.empty(0))
    unsure, sure = np.split(own.follow(measured, variance, 0.008)[219], 2)
    assert (unsure < 0.3 * sure).all()
    assert (sure > 2.5).all()
