"""The error that does not repeat between two runs of one path: no function of the motion avoids it.

The error of each run is a function of its motion plus a part that does not repeat. The mean square
of that part is half of the mean square of the runs' difference at the same states.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ur5lib.identification.samples import path_of
from ur5lib.records.motion import Motion
from ur5lib.records.repetition import Repeated
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.trajectories import (
    REST_SPEED,
    PathStates,
    group_by_path,
    nearest,
    scaled_states,
)

MIN_COMMON_DURATION = 1.0  # s; two runs that share less are not compared


class PathRun(NamedTuple):
    """A run along a path, with its errors.

    path: its states, for comparison of paths; states: scaled (N, 2 n); errors: (N, m) by quantity,
    NaN where unknown, and at rest if the run moves at all; period: [s].
    """

    path: PathStates
    states: Array
    errors: dict[str, Array]
    period: float


class Common(NamedTuple):
    """Two runs compared at the same states. left: difference of their errors over √2 (M, m);
    errors: of both (2 M, m).
    """

    left: Array
    errors: Array


def path_run(motion: Motion, errors: Mapping[str, Array | None]) -> PathRun:
    """Return a run along a path from its motion and its errors (N, m) by quantity, None for one
    that is unknown.
    """
    path = path_of(motion.q, motion.motor_qd, motion.period)
    counts = np.abs(motion.motor_qd).max(axis=1, keepdims=True) > (REST_SPEED if path.moves else -1)
    known = {name: np.where(counts, one, np.nan) for name, one in errors.items() if one is not None}
    return PathRun(path, scaled_states(motion.q, motion.motor_qd), known, motion.period)


def repetition(runs: Sequence[PathRun]) -> Iterator[Repeated]:
    """Yield the error that does not repeat on one path, by quantity and joint or component."""
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
    """Return the errors of two runs at the same states; None if either lacks the quantity, or they
    share less than MIN_COMMON_DURATION.
    """
    if not (quantity in first.errors and quantity in second.errors):
        return None
    (one, of_one), (other, of_other) = (
        (run.states[rows], run.errors[quantity][rows])
        for run in (first, second)
        for rows in [np.isfinite(np.hstack([run.states, run.errors[quantity]])).all(axis=1)]
    )
    if not (len(one) and len(other)):
        return None
    near, at = nearest(other, one)
    if near.sum() * second.period < MIN_COMMON_DURATION:
        return None
    pair = of_one[at[near]], of_other[near]
    return Common((pair[0] - pair[1]) / np.sqrt(2), np.concatenate(pair))


def _rows(quantity: str, unit: str, paths: int, left: Array, errors: Array) -> Iterator[Repeated]:
    """Yield the rows of a quantity: RMS of currents, mean absolute values of others.

    The study's tables of errors have the same measures.
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
