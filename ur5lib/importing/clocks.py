"""The clock of a file: of several, the one under which velocities are derivatives; or a rate."""

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from ur5lib.importing.blocks import NAMELESS_PREFIX
from ur5lib.importing.parted_runs import TEXT_ENDINGS
from ur5lib.importing.spellings import CLOCK_NAME, named_unit, place_of
from ur5lib.recordings.arrays import seconds_of
from ur5lib.recordings.bunched_stamps import are_new, close_rows, even_times
from ur5lib.recordings.entries import UNIT_FACTORS
from ur5lib.recordings.roll_overs import without_roll_over
from ur5lib.timeseries.arrays import Array

ROW_CLOCK = "row number"  # the clock of a file without one
ASSUMED_RATE = 125.0  # Hz; rows are at this rate until velocities show another
USUAL_STEPS = {"s": (1e-4, 1.0), "ms": (1.0, 1e3), "us": (1e3, 5e5), "ns": (5e5, 1e9)}
POSSIBLE_STEPS = (1e-4, 20.0)  # s
MIN_CHANGES = 3  # of a clock
MIN_SHARE_FORWARD = 0.95  # this share of steps goes forward; a clock almost never goes back
MIN_EPOCH_STAMP = 1e9  # s; stamps after 2001 count from 1970
# Size of second to first differences: below 1 of a motion, above of postures.
MIN_POSTURE_ROUGHNESS = 1.2
MIN_POSTURE_DISTANCE = 0.05  # rad, between two postures


class FileClocks(NamedTuple):
    """The clocks of a file. stamps: increasing time stamps (N,) [s] by name; units: of those that
    were not in seconds; doubts: why an array in a clock's place is none; notes: what was done to
    stamps, as where bunches of rows are put at equal steps.
    """

    stamps: dict[str, Array]
    units: dict[str, str]
    doubts: Mapping[str, str] = {}
    notes: Mapping[str, str] = {}


def clocks_of(arrays: Mapping[str, np.ndarray], stated: str | None) -> FileClocks:
    """Return the clocks among arrays: those named like one, else the first array; where no column
    has a name, the first or the last one.

    stated: the unit that the user gives, None if it is to be found.
    """
    named, ends = [name for name in arrays if CLOCK_NAME.search(name)], _by_place(arrays)
    ends += [*arrays][-1:] if "".join(ends).startswith(NAMELESS_PREFIX) else []
    stamps = {name: seconds_of(arrays[name]) for name in named or ends}
    stamps = {name: values for name, values in stamps.items() if is_clock(values)}
    stamps = stamps if named else dict([*stamps.items()][:1])
    if not named and any((np.diff(values) == 1).all() for values in stamps.values()):
        return FileClocks({}, {}, dict.fromkeys(stamps, "it counts the rows"))
    units = {name: unit for name, values in stamps.items() if (unit := _unit(name, values, stated))}
    clocks, notes = dict[str, Array](), dict[str, str]()
    others = [array for name, array in arrays.items() if name not in stamps]
    for name, unit in units.items():
        as_read = stamps[name] * UNIT_FACTORS.get(unit, 1.0)
        clocks[name] = without_roll_over(as_read)
        if not np.array_equal(clocks[name], as_read, equal_nan=True):
            notes[name] = "its counter of 32 bits begins again on the way: it is read as going on"
        close = close_rows(clocks[name])
        if close.any() and are_new(_side_by_side(others, len(stamps[name])), close):
            clocks[name] = even_times(clocks[name], close)
            notes[name] = (
                f"{close.mean():.0%} of its steps are far shorter than a row, as of whole seconds "
                "or of packets: the rows are put at equal steps"
            )
    not_seconds = {name: unit for name, unit in units.items() if unit != "s"}
    return FileClocks(clocks, not_seconds, {}, notes)


def _by_place(arrays: Mapping[str, np.ndarray]) -> list[str]:
    """Return, in a list, the name of the first array, empty if it is one of several columns of
    joints or axes: stamps are the first column of a file of one quantity.
    """
    for first in [*arrays][:1]:
        stem, place = place_of(first)
        alike = [name for name in arrays if place_of(name)[0] == stem]
        of_joints = place >= 0 and len(alike) > 1 and not stem.endswith(TEXT_ENDINGS)
        return [first] if first.startswith(NAMELESS_PREFIX) or not of_joints else []
    return []


def _side_by_side(arrays: Iterable[np.ndarray], rows: int) -> Array:
    """Return the columns (rows, M) of the arrays that have as many rows, turned or not."""
    tall = (array.T if array.shape[-1] == rows else array for array in arrays)
    found = [array for array in tall if len(array) == rows and array.ndim <= 2]
    return np.column_stack([np.empty((rows, 0)), *found])


def equally_spaced(
    arrays: Mapping[str, np.ndarray], rate: float | None, doubts: Mapping[str, str]
) -> FileClocks:
    """Return a clock with equal steps, row number over rate [s], for the most frequent array
    length.

    rate: [Hz], None for ASSUMED_RATE; doubts: handed through to the result.
    """
    lengths = [max(values.shape) for values in arrays.values() if values.ndim in (1, 2)]
    rows = max(lengths, key=lengths.count, default=0)
    return FileClocks({ROW_CLOCK: np.arange(rows) / (rate or ASSUMED_RATE)}, {}, doubts)


def is_clock(stamps: Array) -> bool:
    """Return whether values (N,) increase like a clock; some may be equal, few may go back."""
    steps = np.diff(stamps[np.isfinite(stamps)]) if stamps.ndim == 1 else np.array([])
    return (
        len(steps) >= 2
        and bool(np.mean(steps >= 0) >= MIN_SHARE_FORWARD)
        and bool(np.count_nonzero(steps > 0) >= MIN_CHANGES)
    )


def typical_step(stamps: Array) -> float:
    """Return the mean step from row to row of stamps (N,), without steps back and with long pauses
    cut.
    """
    steps = np.diff(stamps[np.isfinite(stamps)])
    steps = steps[steps >= 0]
    return float(np.minimum(steps, np.quantile(steps[steps > 0], 0.99)).mean())


def alternatives(clocks: FileClocks, current: str) -> Iterator[tuple[str, str, Array]]:
    """Yield (name, unit, stamps (N,) [s]) of `current` and the clocks next to it in the file, once
    in each possible unit.
    """
    for name, stamps in clocks.stamps.items():
        beside = len(stamps) == len(clocks.stamps[current]) and "/" not in name + current
        if not (beside or name == current):
            continue
        as_read = stamps / UNIT_FACTORS.get(clocks.units.get(name, "s"), 1.0)
        step = typical_step(as_read)
        for unit in USUAL_STEPS:
            seconds = UNIT_FACTORS.get(unit, 1.0)
            if named_unit(name) == unit or (
                named_unit(name) not in USUAL_STEPS
                and POSSIBLE_STEPS[0] <= step * seconds <= POSSIBLE_STEPS[1]
            ):
                yield name, unit, as_read * seconds


def _unit(name: str, stamps: Array, stated: str | None) -> str | None:
    """Return the unit of stamps (N,): as stated, by name, or by usual steps; None if they are no
    clock.
    """
    if (named := stated or named_unit(name)) in USUAL_STEPS:
        return named
    step = typical_step(stamps)
    unit = next((unit for unit, (low, high) in USUAL_STEPS.items() if low <= step < high), None)
    backwards = np.count_nonzero(np.diff(stamps[np.isfinite(stamps)]) < 0)
    within_seconds = unit == "ns" and np.nanmax(stamps) < 1e9 and backwards > 1
    return None if within_seconds else unit


def irregularity(stamps: Array) -> float:
    """Return the mean distance of a clock's steps from their median, as a share of it; stamps:
    (N,).
    """
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    usual = float(np.median(steps))
    return float(np.mean(np.abs(steps - usual)) / usual)


def are_postures(q: Array) -> bool:
    """Return whether rows (N, n) [rad] leap from posture to posture, and are no smooth motion."""
    steps = np.diff(q, axis=0)
    far = np.abs(steps) > MIN_POSTURE_DISTANCE
    path = np.abs(steps).sum()
    leaps = float(np.abs(steps)[far].sum()) / path if path else 1.0
    bends = np.diff(steps, axis=0)
    rough = float(np.std(bends) / (np.std(steps) + 1e-12)) if len(bends) else 0.0
    return leaps > 0.5 and (rough > MIN_POSTURE_ROUGHNESS or leaps > 0.9)
