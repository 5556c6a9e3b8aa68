"""Made-up contact-free recordings of an arm whose current-torque map is known."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import signal

from ur5lib.identification.current_samples import ZeroPhaseLowpass
from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import Normal
from ur5lib.identification.samples import CurrentSamples, columns_of
from ur5lib.robots.friction import BASE_TERMS
from ur5lib.timeseries.arrays import Array, Mask

PERIOD = 0.02
CONSTANT = np.array([8.5, 10.8, 10.2, 10.0, 11.0, 10.5])
LOAD = np.array([8.0, 50.0, 20.0, 2.0, 2.0, 0.0])  # Nm; joint 6 carries nothing
FRICTION = [  # Coulomb, viscous and load friction
    *((6.4, 7.2, 0.0), (5.7, 9.3, 0.08), (8.8, 4.9, 0.0)),
    *((1.5, 1.3, 0.0), (1.6, 1.2, 0.0), (1.6, 0.8, 0.0)),
]
OFFSET = np.array([0.1, 0.4, 0.0, 0.3, 0.2, 0.3])  # Nm
NOISE = np.array([0.08, 0.1, 0.1, 0.03, 0.025, 0.025])  # A, of the slow residual


smooth = ZeroPhaseLowpass(order=4, cutoff=2.0)


def prior(width: float = 0.1, torque_max: float = 150.0) -> Prior:
    """Torque constants known to `width`, each on its own."""
    inverse = 1 / CONSTANT
    return Prior(Normal(inverse, np.diag((width * inverse) ** -2.0)), np.full(6, torque_max))


def coefficients(joint: int) -> Array:
    """The true ones, of the current."""
    return np.array([1.0, -OFFSET[joint], *FRICTION[joint]]) / CONSTANT[joint]


def make_record(seed: int, seconds: float = 24.0) -> CurrentSamples:
    """A motion of slow waves with pauses, and the current it needs without any noise."""
    random = np.random.default_rng(seed)
    time = np.arange(0, seconds, PERIOD)[:, None]
    frequency, phase = random.uniform(0.3, 1.2, (2, 6)), random.uniform(0, 6, (2, 6))
    qd = 0.5 * np.sum(np.sin(frequency[:, None] * time + phase[:, None]), axis=0)
    qd *= np.clip(5 * np.sin(0.5 * time + phase[0]) + 3, 0, 1)  # smooth stops
    q = np.cumsum(qd, axis=0) * PERIOD + phase[1]
    torque = LOAD * np.sin(q + 0.3 * np.roll(q, 1, axis=1))
    return with_current(
        CurrentSamples(f"made_up_{seed}", PERIOD, np.zeros(len(q), int), q, qd, torque, 0 * q)
    )


def with_current(record: CurrentSamples) -> CurrentSamples:
    """The record with the current that its motion and torque need."""
    motions = [record.joint(joint) for joint in range(6)]
    exact = [columns_of(motions[j], BASE_TERMS) @ coefficients(j) for j in range(6)]
    return replace(record, current=np.stack(exact, axis=1))


def make_noise(random: np.random.Generator, count: int, step: float) -> Array:
    """A residual (count, 6) [A] as real ones are: correlated over 0.5 s, with an offset."""
    memory = np.exp(-step / 0.5)
    white = random.standard_normal((count, 6)) * np.sqrt(1 - memory**2)
    offset = 0.4 * random.standard_normal(6)
    return NOISE * (signal.lfilter([1.0], [1.0, -memory], white, axis=0) + offset)


def with_noise(record: CurrentSamples, seed: int) -> CurrentSamples:
    """The record with a correlated residual, and white noise on top."""
    random = np.random.default_rng(1000 + seed)
    noise = make_noise(random, len(record.q), record.period)
    white = 0.1 * random.standard_normal(record.current.shape)
    return replace(record, current=record.current + noise + white)


def noisy(seeds: Iterable[int], seconds: float = 24.0) -> list[CurrentSamples]:
    """A recording with noise of each seed."""
    return [with_noise(make_record(seed, seconds), seed) for seed in seeds]


def cut(record: CurrentSamples, rows: slice | Mask, **changes: Any) -> CurrentSamples:
    """Some samples of a recording."""
    names = ("segment", "q", "qd", "torque", "current")
    return replace(record, **{name: getattr(record, name)[rows] for name in names}, **changes)
