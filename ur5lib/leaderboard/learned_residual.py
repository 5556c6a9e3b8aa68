"""A torque without contact, learnt as a function of the motion, by path.

What friction and model leave is learnt from (q, q̇, torque of the rigid-body model) at one instant,
and subtracted, so that it can be part of a causal estimate.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ur5lib.errors import InputError
from ur5lib.leaderboard.estimator import Contender, Learned
from ur5lib.leaderboard.estimators.momentum_observer import FirstOrder, learn_causal
from ur5lib.leaderboard.force import TorqueEstimate
from ur5lib.leaderboard.run import Run
from ur5lib.leaderboard.tuning import untuned
from ur5lib.timeseries.arrays import Array


class TrainingSamples(NamedTuple):
    """Inputs (n, M) and torques (n, 6) [Nm]."""

    inputs: Array
    torque: Array


Predict = Callable[[Array], Array]
"""Returns the torque (N, 6) at inputs (N, M)."""
Train = Callable[[TrainingSamples, TrainingSamples], Predict]
"""Takes the samples to learn from, and those of a path that is left out, to stop by; all are
standardised."""


Learnable = Callable[[Run], TrainingSamples]
"""Returns what is learnt from, and what, at all samples of a run, NaN where unknown."""


def residual(run: Run) -> TrainingSamples:
    """Return (q, q̇, τ_model), (N, 18) [rad, rad/s, Nm], and the smoothed external torque."""
    return TrainingSamples(np.concatenate([run.q, run.qd, run.model], axis=1), run.smoothed)


def samples(runs: Sequence[Run], step: float, of: Learnable) -> TrainingSamples:
    """Return the samples of runs every `step` seconds, where all is known."""
    parts = []
    for run in runs:
        rows = slice(None, None, max(1, round(step / run.period)))
        inputs, torque = (values[rows] for values in of(run))
        finite = np.isfinite(inputs).all(axis=1) & np.isfinite(torque).all(axis=1)
        parts.append((inputs[finite], torque[finite]))
    return TrainingSamples(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def standardised(train: Train, learnt: TrainingSamples, left_out: TrainingSamples) -> Predict:
    """Train on samples less their mean, over their standard deviation; return the prediction in
    their own units. A column that does not vary keeps its unit.
    """
    mean = TrainingSamples(*(values.mean(axis=0) for values in learnt))
    spread = [values.std(axis=0) for values in learnt]
    std = TrainingSamples(*(np.where(values > 1e-9, values, 1.0) for values in spread))
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
    """Return the learnt torque of a run, for each path by the regression that has not seen it.

    A path beyond those is predicted by the mean of the regressions. Raises InputError if all runs
    follow one path.
    """
    paths = sorted({run.path for run in runs})
    if len(paths) < 2:
        raise InputError("a learnt residual needs two paths to fit on; record another")
    without = {
        path: standardised(
            train,
            samples([run for run in runs if run.path != path], step, of),
            samples([run for run in runs if run.path == path], step, of),
        )
        for path in paths
    }

    def predicted(run: Run) -> Array:
        chosen = [without[run.path]] if run.path in without else [*without.values()]
        inputs = of(run).inputs
        values, finite = np.full_like(run.q, np.nan), np.isfinite(inputs).all(axis=1)
        values[finite] = np.mean([predict(inputs[finite]) for predict in chosen], axis=0)
        return values

    return predicted


def on_top(name: str, source: str, train: Train, step: float) -> list[Contender]:
    """Return the estimators that subtract a regression from least squares and from the momentum
    observer; name: of the regression; step: as in `samples`.
    """

    @lru_cache(maxsize=1)  # both learn it from the same runs
    def residual_of(runs: tuple[Run, ...]) -> TorqueEstimate:
        return cross_fitted(train, runs, step)

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
