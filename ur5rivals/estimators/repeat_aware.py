"""F̂ᵐᵃᵖ less the residual torque of contact-free runs of the same trajectory.

Friction depends on position and direction in a way that no formula describes, but it repeats. At
configurations and velocities that a contact-free run also passes, that run's external torque is
subtracted. Differences between contact-free runs give the repeatability.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5lib.force.external_torque import JointState, finite_rows, is_still
from ur5lib.force.residual_model import (
    ResidualModel,
    TorqueStretch,
    few_paths,
    fit_residual_model,
)
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import unbroken
from ur5lib.timeseries.trajectories import nearest, scaled_states
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.ours import OURS
from ur5rivals.force import CUTOFF_HZ, breakaway_of, learned_noise, most_probable
from ur5rivals.run import Estimate, Run


def repeated(run: Run) -> Array:
    """Return the external torque (N, 6) [Nm] less that of the other runs' sample nearest in
    (q, qd); nothing is subtracted at rest, or without a near sample.
    """
    pairs = [(free, _moves(free) & finite_rows(free.smoothed)) for free in run.repeats]
    places = np.concatenate([scaled_states(free.q, free.qd)[rows] for free, rows in pairs])
    torques = np.concatenate([free.smoothed[rows] for free, rows in pairs])
    result, moves = run.smoothed.copy(), np.flatnonzero(_moves(run))
    if len(places) and len(moves):
        near, index = nearest(scaled_states(run.q, run.qd)[moves], places)
        result[moves[near]] -= torques[index[near]]
    return result


def _moves(run: Run) -> Mask:
    return finite_rows(run.q) & finite_rows(run.qd) & ~is_still(run.states)


def noise_of_repeats(noise: ResidualModel, runs: Sequence[Run]) -> ResidualModel:
    """Return the noise with that in motion replaced by the repeatability of one trajectory's runs.

    It is wider by Student's t for few runs. With a single run, the repeatability is unknown.
    """
    if len(runs) < 2:
        return noise
    stretches = [
        TorqueStretch(torque[rows], run.states[rows], run.period)
        for run in runs
        for torque in [repeated(run)]
        for rows in unbroken(run.segment)
    ]
    of_repeats = fit_residual_model(stretches, CUTOFF_HZ, noise.breakaway).wider(
        few_paths(len(runs))
    )

    def joined(moving: Array, resting: Array) -> Array:
        return np.concatenate([moving[: JointState.RESTING], resting[JointState.RESTING :]])

    return replace(
        noise,
        spread=joined(of_repeats.spread, noise.spread),
        change=joined(of_repeats.change, noise.change),
        rate=joined(of_repeats.rate, noise.rate),
    )


def learn(runs: Sequence[Run]) -> Learned:
    """Return the estimator, with the noise that the runs show for states in which repeats do not
    count; in motion, each trajectory has its own noise.
    """
    noise = learned_noise(lambda run: run.smoothed, runs, breakaway_of(runs))

    def estimate(run: Run) -> Estimate | None:
        if not run.repeats:
            return None
        return most_probable(run, repeated(run), noise_of_repeats(noise, run.repeats))

    return Learned(estimate, {})


ESTIMATORS = [Contender(f"{OURS}, repeat-aware", "ours", False, learn)]
