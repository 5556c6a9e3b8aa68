"""What two runs of one path leave: an error that no function of the motion can avoid.

If the error of each run is what its motion explains plus what does not repeat, half of the mean
square of their difference at the same states is the mean square of the latter.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.contact_wrench import regularised_wrench
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.gate import diagonal
from ur5lib.force.problem import fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.identification.currents import torque_constants
from ur5lib.identification.samples import path_of
from ur5lib.recordings.copies import same_runs
from ur5lib.records.arm_state import Repeated
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals, slowly
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.trajectories import (
    REST_SPEED,
    PathStates,
    group_by_path,
    nearest,
    scaled_states,
)

MIN_COMMON_DURATION = 1.0  # s, that two runs share, below which they are not compared


class PathRun(NamedTuple):
    """A run along a path: scaled states (N, 2 n), errors (N, m) by quantity, and its period [s].

    Errors are NaN where they are unknown, and where a run that moves rests.
    """

    path: PathStates
    states: Array
    errors: dict[str, Array]
    period: float


class Common(NamedTuple):
    """At the same states of two runs, the difference of their errors over √2 (M, m), and the errors
    of both (2 M, m).
    """

    left: Array
    errors: Array


def measure_repetition(
    signals: Mapping[str, Signals],
    motion: Mapping[str, Motion],
    torques: Mapping[str, Torques],
    currents: Mapping[str, Currents],
    kinematics: Mapping[str, Kinematics],
    predictions: Mapping[str, Prediction],
    quality: Mapping[str, Quality],
    friction: Friction,
    residuals: Residuals,
    arm: Robot,
    contact_force_n: float,
) -> list[Repeated]:
    """Return what repetition alone leaves of an arm's errors; empty where no path was repeated.

    signals … quality: of contact-free recordings, of which copies do not count;
    contact_force_n: [N], of a typical contact.
    """
    prior, runs = ContactPrior(force=contact_force_n), []
    copies = {other for _, other in same_runs({n: one.fingerprint for n, one in quality.items()})}
    for name, moved in motion.items():
        if not predictions[name].is_loaded and name not in copies:
            errors = {
                "torque": torque_error(signals[name], torques[name], arm.fullest_model()),
                "current": current_error(currents[name], friction.fit_for(name)),
                "force": force_error(moved, currents[name], kinematics[name], residuals, prior),
            }
            runs.append(path_run(moved, errors))
    return [*repetition(runs)]


def torque_error(signals: Signals, torques: Torques, model: str) -> Array | None:
    """Return by how much a link model's torque (N, n) [Nm] misses the controller's, below 2 Hz."""
    if signals.target_moment is None:
        return None
    known = torques.target if model in torques.target else torques.measured
    return slowly(known[model] - signals.target_moment, signals)


def current_error(currents: Currents, fit: CurrentFit) -> Array | None:
    """Return by how much the predicted current (N, n) [A] misses the measured one."""
    torque = currents.external_torque
    return None if torque is None else torque / torque_constants(fit)


def force_error(
    motion: Motion,
    currents: Currents,
    kinematics: Kinematics,
    residuals: Residuals,
    prior: ContactPrior,
) -> Array | None:
    """Return the force (N, 3) [N] for which the error of the currents would pass in a contact."""
    problem = fmap_problem(motion, currents, residuals)
    if problem is None:
        return None
    one, model = problem
    noise = diagonal(model.variance(model.spread, one.states))  # S
    wrench = regularised_wrench(one.torque, kinematics.jacobian, noise, prior.unknown()).mean
    return np.where(finite_rows(one.torque)[:, None], wrench[:, :3], np.nan)


def path_run(motion: Motion, errors: Mapping[str, Array | None]) -> PathRun:
    """Return a run by its motion and its errors (N, m) by quantity, None where unknown."""
    path = path_of(motion.q, motion.motor_qd, motion.period)
    counts = np.abs(motion.motor_qd).max(axis=1, keepdims=True) > (REST_SPEED if path.moves else -1)
    known = {name: np.where(counts, one, np.nan) for name, one in errors.items() if one is not None}
    return PathRun(path, scaled_states(motion.q, motion.motor_qd), known, motion.period)


def repetition(runs: Sequence[PathRun]) -> Iterator[Repeated]:
    """Yield what all pairs of runs of one path leave of each error, by joint or component."""
    labels = group_by_path([run.path for run in runs])
    pairs = [
        (path, first, second)
        for (path, first), (other, second) in combinations(zip(labels, runs, strict=True), 2)
        if path == other
    ]
    for quantity, unit in (("torque", "Nm"), ("current", "A"), ("force", "N")):
        found = {
            (path, k): common
            for k, (path, first, second) in enumerate(pairs)
            if (common := common_errors(first, second, quantity))
        }
        if found:
            paths = len({path for path, _ in found})
            left, errors = (np.concatenate(part) for part in zip(*found.values(), strict=True))
            yield from _rows(quantity, unit, paths, left, errors)


def common_errors(first: PathRun, second: PathRun, quantity: str) -> Common | None:
    """Return the errors of two runs where they pass the same states; None where they hardly do."""
    if not (quantity in first.errors and quantity in second.errors):
        return None
    (one, of_one), (other, of_other) = (
        (run.states[rows], run.errors[quantity][rows])
        for run in (first, second)
        for rows in [finite_rows(np.hstack([run.states, run.errors[quantity]]))]
    )
    if not (len(one) and len(other)):
        return None
    near, at = nearest(other, one)
    if near.sum() * second.period < MIN_COMMON_DURATION:
        return None
    pair = of_one[at[near]], of_other[near]
    return Common((pair[0] - pair[1]) / np.sqrt(2), np.concatenate(pair))


def _rows(quantity: str, unit: str, paths: int, left: Array, errors: Array) -> Iterator[Repeated]:
    """Yield the rows of a quantity: root mean squares of currents, mean absolute values of others,
    as the study's tables of errors have them.
    """
    power = 2 if quantity == "current" else 1
    floors, own = ((np.abs(one) ** power).mean(axis=0) ** (1 / power) for one in (left, errors))
    for k, (floor, error) in enumerate(zip(floors, own, strict=True)):
        place = {"component": ("Fx", "Fy", "Fz")[k]} if quantity == "force" else {"joint": k + 1}
        yield Repeated(
            quantity=quantity,
            **place,
            unit=unit,
            floor=float(floor),
            error=float(error),
            paths=paths,
            samples=len(left),
        )
