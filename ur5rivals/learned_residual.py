"""A torque without contact, learnt as a function of the motion, by path.

Either the residual of friction and model is learnt from (q, q̇, torque of the rigid-body model) at
one instant, so that it can be subtracted in a causal estimate. Or the motors' whole torque is
learnt, without friction and model, and the external torque is the measured less the learnt one.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.least_squares import TIME_CONSTANTS, LowPassed
from ur5rivals.estimators.momentum_observer import FirstOrder, learn_causal
from ur5rivals.force import TorqueEstimate
from ur5rivals.run import Run
from ur5rivals.tuning import tuned, untuned


class TrainingSamples(NamedTuple):
    """The samples that a regression learns from: inputs (n, M) and torques (n, 6) [Nm]."""

    inputs: Array
    torque: Array


Predict = Callable[[Array], Array]
"""Returns the torque (N, 6), or more (N, K), at inputs (N, M)."""
Train = Callable[[TrainingSamples, TrainingSamples], Predict]
"""Takes the samples to learn from, and those of a path that is left out, to stop by."""


Learnable = Callable[[Run], TrainingSamples]
"""Returns what is learnt from, and what, at all samples of a run, NaN where unknown."""


def residual(run: Run) -> TrainingSamples:
    """Return as inputs (q, q̇, τ_model) (N, 18) [rad, rad/s, Nm], and as torque the smoothed
    external torque.
    """
    return TrainingSamples(np.concatenate([run.q, run.qd, run.model], axis=1), run.smoothed)


def samples(runs: Sequence[Run], step: float, of: Learnable) -> TrainingSamples:
    """Return the finite samples of runs, `step` seconds apart; of: function that returns the
    samples of a run.
    """
    parts = []
    for run in runs:
        rows = slice(None, None, max(1, round(step / run.period)))
        inputs, torque = (values[rows] for values in of(run))
        finite = np.isfinite(inputs).all(axis=1) & np.isfinite(torque).all(axis=1)
        parts.append((inputs[finite], torque[finite]))
    return TrainingSamples(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def spread_over(learnt: TrainingSamples, count: int) -> TrainingSamples:
    """Return at most `count` of the samples, evenly spaced."""
    rows = np.unique(np.linspace(0, len(learnt.inputs) - 1, count).astype(int))
    return TrainingSamples(*(values[rows] for values in learnt))


def in_parts(predict: Predict, count: int) -> Predict:
    """Return a prediction that computes the same in parts of about `count` samples, to save
    memory.
    """
    return lambda new: np.concatenate(
        [predict(part) for part in np.array_split(new, 1 + len(new) // count)]
    )


def deviation(values: Array) -> Array:
    """Return the standard deviations (M,) of values (n, M), 1 of a column that does not vary."""
    spread = values.std(axis=0)
    return np.where(spread > 1e-9, spread, 1.0)


def standardised(train: Train, learnt: TrainingSamples, left_out: TrainingSamples) -> Predict:
    """Return the prediction in original units of a regression that is trained on (samples - mean) /
    standard deviation.
    """
    mean = TrainingSamples(*(values.mean(axis=0) for values in learnt))
    std = TrainingSamples(*map(deviation, learnt))
    to_learn, to_stop = (
        TrainingSamples(
            (values.inputs - mean.inputs) / std.inputs, (values.torque - mean.torque) / std.torque
        )
        for values in (learnt, left_out)
    )
    predict = train(to_learn, to_stop)

    def predicted(new: Array) -> Array:
        return predict((new - mean.inputs) / std.inputs) * std.torque + mean.torque

    return predicted


def cross_fitted(
    train: Train, runs: Sequence[Run], step: float, of: Learnable = residual
) -> TorqueEstimate:
    """Return a function that predicts a run's torque by the regression without the run's path.

    Other paths are predicted by the mean of the regressions. Raises InputError if all runs follow
    one path.
    """
    paths = sorted({run.path for run in runs})
    if len(paths) < 2:
        raise InputError("a learnt residual needs two paths to fit on; record another")
    without = {
        path: train(
            samples([run for run in runs if run.path != path], step, of),
            samples([run for run in runs if run.path == path], step, of),
        )
        for path in paths
    }

    def predicted(run: Run) -> Array:
        chosen = [without[run.path]] if run.path in without else [*without.values()]
        inputs = of(run).inputs
        finite = np.isfinite(inputs).all(axis=1)
        known = np.mean([predict(inputs[finite]) for predict in chosen], axis=0)
        values = np.full((len(inputs), known.shape[1]), np.nan)
        values[finite] = known
        return values

    return predicted


def on_top(name: str, source: str, train: Train, step: float) -> list[Contender]:
    """Return two estimators that subtract a learnt regression from the torque: one before least
    squares, one in the momentum observer.

    name: of the regression; source: its publication; train: function that learns it; step: as in
    `samples`.
    """

    @lru_cache(maxsize=1)  # both estimators learn it from the same runs
    def residual_of(runs: tuple[Run, ...]) -> TorqueEstimate:
        return cross_fitted(partial(standardised, train), runs, step)

    def learn_offline(runs: Sequence[Run]) -> Learned:
        residual_torque = residual_of((*runs,))
        return untuned(lambda run: run.smoothed - residual_torque(run), runs)

    def learn_observed(runs: Sequence[Run]) -> Learned:
        residual_torque, observer = residual_of((*runs,)), learn_causal(runs)
        below = FirstOrder(**observer.constants)
        return untuned(lambda run: below.torque(run) - residual_torque(run), runs, observer.latency)

    return [
        Contender(f"least squares + {name}", source, False, learn_offline),
        Contender(f"momentum observer + {name}", source, True, learn_observed),
    ]


def motor(run: Run) -> Array:
    """Return the measured torque k i of the motors (N, 6) [Nm]."""
    return run.model + run.friction - run.torque


def beyond(predicted: TorqueEstimate, runs: Sequence[Run]) -> Learned:
    """Return the estimator of the motors' measured torque less the predicted one.

    predicted: function that predicts the torque of a run; the low-pass is tuned as that of causal
    least squares.
    """

    def unexplained(run: Run) -> Run:
        return replace(run, torque=predicted(run) - motor(run))

    filters = [LowPassed(time_constant) for time_constant in TIME_CONSTANTS]
    learned = tuned(filters, [unexplained(run) for run in runs])
    return learned._replace(method=lambda run: learned.method(unexplained(run)))
