"""The clock of a file: of several, the one under which velocities are derivatives; or a rate."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from ur5lib.importing.spellings import CLOCK_NAME, named_unit
from ur5lib.recordings.arrays import seconds_of
from ur5lib.recordings.entries import UNIT_FACTORS
from ur5lib.timeseries.arrays import Array

ROW_CLOCK = "row number"  # the clock of a file without one
ASSUMED_RATE = 125.0  # Hz, of rows until velocities tell another
USUAL_STEPS = {"s": (1e-4, 1.0), "ms": (1.0, 1e3), "us": (1e3, 5e5), "ns": (5e5, 1e9)}
POSSIBLE_STEPS = (1e-4, 20.0)  # s
MIN_SHARE_OF_CHANGES = 0.1  # of steps; a clock of whole seconds changes in fewer
MIN_SHARE_FORWARD = 0.95  # of steps; a clock hardly ever goes back
MIN_EPOCH_STAMP = 1e9  # s; stamps after 2001 count from 1970
# size of second to first differences: below 1 of a motion, above of postures
MIN_POSTURE_ROUGHNESS = 1.2
MIN_POSTURE_DISTANCE = 0.05  # rad, between two postures


class FileClocks(NamedTuple):
    """Increasing time stamps (N,) [s] by name, and the units of those that are not in seconds."""

    stamps: dict[str, Array]
    units: dict[str, str]


def clocks_of(arrays: Mapping[str, np.ndarray], stated: str | None) -> FileClocks:
    """Return the clocks among arrays: those with the name of one, or else the first array.

    stated: the unit that the user gives.
    """
    named = [name for name in arrays if CLOCK_NAME.search(name)]
    stamps = {name: seconds_of(arrays[name]) for name in named or [*arrays][:1]}
    units = {name: unit for name, values in stamps.items() if (unit := _unit(name, values, stated))}
    clocks = {name: stamps[name] * UNIT_FACTORS.get(unit, 1.0) for name, unit in units.items()}
    return FileClocks(clocks, {name: unit for name, unit in units.items() if unit != "s"})


def equally_spaced(arrays: Mapping[str, np.ndarray], rate: float | None) -> FileClocks:
    """Return the rows' numbers as a clock at a rate [Hz], of as many rows as most arrays have."""
    lengths = [max(values.shape) for values in arrays.values() if values.ndim in (1, 2)]
    rows = max(lengths, key=lengths.count, default=0)
    return FileClocks({ROW_CLOCK: np.arange(rows) / (rate or ASSUMED_RATE)}, {})


def is_clock(stamps: Array) -> bool:
    """Return whether values (N,) increase like a clock, repeated stamps among them."""
    steps = np.diff(stamps[np.isfinite(stamps)]) if stamps.ndim == 1 else np.array([])
    return (
        len(steps) >= 2
        and bool(np.mean(steps >= 0) >= MIN_SHARE_FORWARD)
        and bool(np.mean(steps > 0) >= MIN_SHARE_OF_CHANGES)
    )


def alternatives(clocks: FileClocks, current: str) -> Iterator[tuple[str, str, Array]]:
    """Yield name, unit and stamps (N,) [s] of the clocks that blocks on one of them may have.

    They are as long, beside it in the file, and in each unit that their steps allow.
    """
    for name, stamps in clocks.stamps.items():
        beside = len(stamps) == len(clocks.stamps[current]) and "/" not in name + current
        if not (beside or name == current):
            continue
        as_read = stamps / UNIT_FACTORS.get(clocks.units.get(name, "s"), 1.0)
        steps = np.diff(as_read)
        step = float(np.median(steps[steps > 0]))
        for unit in USUAL_STEPS:
            seconds = UNIT_FACTORS.get(unit, 1.0)
            if named_unit(name) == unit or (
                named_unit(name) not in USUAL_STEPS
                and POSSIBLE_STEPS[0] <= step * seconds <= POSSIBLE_STEPS[1]
            ):
                yield name, unit, as_read * seconds


def _unit(name: str, stamps: Array, stated: str | None) -> str | None:
    """Return the unit of stamps (N,): stated, by name, or by usual steps; None if no clock."""
    if not is_clock(stamps):
        return None
    if (named := stated or named_unit(name)) in USUAL_STEPS:
        return named
    steps = np.diff(stamps[np.isfinite(stamps)])
    step = float(np.median(steps[steps > 0]))
    unit = next((unit for unit, (low, high) in USUAL_STEPS.items() if low <= step < high), None)
    within_seconds = unit == "ns" and np.nanmax(stamps) < 1e9 and np.count_nonzero(steps < 0) > 1
    return None if within_seconds else unit


def irregularity(stamps: Array) -> float:
    """Return how far the steps of a clock (N,) lie from the usual one, as a share of it."""
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    usual = float(np.median(steps))
    return float(np.mean(np.abs(steps - usual)) / usual)


def are_postures(q: Array) -> bool:
    """Return whether rows (N, n) [rad] are postures, each for itself, and no samples of a motion.

    Random or stepped postures leap from one to the next; a motion is smooth.
    """
    steps = np.diff(q, axis=0)
    far = np.abs(steps) > MIN_POSTURE_DISTANCE
    path = np.abs(steps).sum()
    leaps = float(np.abs(steps)[far].sum()) / path if path else 1.0
    rough = float(np.std(np.diff(steps, axis=0)) / (np.std(steps) + 1e-12))
    return leaps > 0.5 and (rough > MIN_POSTURE_ROUGHNESS or leaps > 0.9)
