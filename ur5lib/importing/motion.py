"""The blocks that are positions and velocities, by name; and the clock under which they agree."""

import itertools
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ur5lib.checks.channels import MIN_MOVING_SPEED
from ur5lib.checks.checked import described
from ur5lib.checks.torques import DEGREES_PER_RADIAN
from ur5lib.errors import InputError
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.clocks import (
    ASSUMED_RATE,
    ROW_CLOCK,
    alternatives,
    are_postures,
    irregularity,
)
from ur5lib.importing.contents import FileContents, block_widths
from ur5lib.importing.spellings import named_unit, names_command
from ur5lib.robots.drives import turns_matrix
from ur5lib.timeseries.arrays import Array

MIN_CORRELATION = 0.9  # of a slope with its velocity
VELOCITY_RATIO_RANGE = (0.8, 1.25)  # of a velocity to its slope
CLEAR_MISFIT_RATIO = 0.1  # of what another block misses as a derivative
MAX_SLOPE_STEP = 1.0  # s; across longer steps, a slope is no velocity
SLOPE_SPAN = 0.05  # s
MIN_SLOPES = 10
MIN_SHARE_OF_VELOCITIES = 0.8  # of moving columns that are derivatives; two exchanged are fewer
CLEAR_CLOCK_RATIO = 2.0  # times the misfit of another clock that then takes its place
WORST_MISFIT = 10.0  # of a clock under which no velocity is a derivative
TARGET_UNITS = {"target_q": "deg", "target_qd": "deg/s", "target_qdd": "deg/s2"}  # if in degrees
MAX_JOINT_ANGLE = 4 * np.pi  # rad; no joint turns further
NO_POSITIONS_MESSAGE = (
    "{}: no positions are found: none is named like them (`actual_q_0`, `joint_position`), and no "
    "block of {} columns is the derivative of another; it holds {}; name them, as with --columns "
    "{}"
)


class Agreement(NamedTuple):
    """How well a block is the derivative of another.

    share: of the moving columns that agree; ratio: of velocity to slope, the median; moving: number
    of moving columns; missed: share of the slopes' squares that the velocities miss.
    """

    share: float
    ratio: float
    moving: int
    missed: float


@dataclass(frozen=True)
class ImportedMotion:
    """Positions of a file's joints, and their velocities and targets as far as recorded.

    blocks: by channel; units: by channel, those that are not SI; rate: [Hz] of a file without a
    clock; still: whether its rows are postures.
    """

    file: FileContents
    blocks: dict[str, ColumnBlock]
    units: dict[str, str]
    rate: float | None = None
    still: bool = False

    @property
    def position(self) -> ColumnBlock:
        """Return the positions."""
        return self.blocks["actual_q"]

    @property
    def time(self) -> Array:
        """Return the time stamps (N,) [s]."""
        return self.file.clocks.stamps[self.position.clock]

    def beside(self, meanings: Collection[str]) -> list[ColumnBlock]:
        """Return other blocks of the joints on the positions' clock, by meaning or nameless."""
        motion_blocks = [*map(id, self.blocks.values())]
        return [
            block
            for block in self.file.blocks
            if np.array_equal(self.file.clocks.stamps[block.clock], self.time)
            and block.rows.shape[1] == self.file.joints
            and id(block) not in motion_blocks
            and (block.meaning() in meanings or block.is_nameless())
        ]

    def in_si(self) -> dict[str, Array]:
        """Return the measured positions and velocities (N, n) [rad, rad/s]."""
        return {
            name: block.rows / (DEGREES_PER_RADIAN if name in self.units else 1.0)
            for name, block in self.blocks.items()
            if name not in TARGET_UNITS
        }


def agreement(position: Array, velocity: Array, time: Array) -> Agreement:
    """Return how well velocities (N, k) are the derivatives of positions (N, k) at times (N,)."""
    slope, rate = slopes_and_rates(position, velocity, time)
    moving = [
        ratio for pair in zip(slope.T, rate.T, strict=True) if (ratio := _ratio(*pair)) is not None
    ]
    good = [ratio for ratio in moving if np.isfinite(ratio)]
    if not good:
        return Agreement(0.0, np.nan, len(moving), np.inf)
    ratio = float(np.median(good))
    missed = np.nansum((slope - rate / ratio) ** 2) / np.nansum(slope**2)
    return Agreement(len(good) / len(moving), ratio, len(moving), float(missed))


def slopes_and_rates(position: Array, velocity: Array, time: Array) -> tuple[Array, Array]:
    """Return smoothed slopes of positions (N, k) and velocities at the same times (M, k).

    Rows of a polled log that repeat a stamp count once.
    """
    fresh = np.diff(time, prepend=-np.inf) > 0
    position, velocity, time = position[fresh], velocity[fresh], time[fresh]
    step = np.diff(time)
    width = max(1, round(SLOPE_SPAN / max(float(np.median(step)), 1e-4)))
    whole = (step < MAX_SLOPE_STEP) & np.isfinite(np.diff(position, axis=0)).all(axis=1)
    rise = np.diff(position, axis=0)[whole]
    step = step[whole, None]
    rate = (velocity[1:] + velocity[:-1])[whole] / 2 * step
    count = len(rise) // width * width
    rise, rate, step = (v[:count].reshape(-1, width, v.shape[-1]) for v in (rise, rate, step))
    return rise.sum(axis=1) / step.sum(axis=1), rate.sum(axis=1) / step.sum(axis=1)


def _ratio(slope: Array, rate: Array) -> float | None:
    """Return the ratio of a velocity to its slope; None if it rests, NaN if they disagree."""
    finite = np.isfinite(slope) & np.isfinite(rate)
    slope, rate = slope[finite], rate[finite]
    if len(slope) < MIN_SLOPES or max(np.std(slope), np.std(rate)) < MIN_MOVING_SPEED:
        return None
    if min(np.std(slope), np.std(rate)) == 0:
        return np.nan
    agree = np.corrcoef(slope, rate)[0, 1] >= MIN_CORRELATION
    return float(slope @ rate / (slope @ slope)) if agree else np.nan


def find_motion(file: FileContents) -> ImportedMotion:
    """Return the positions, the velocities, and the targets of both.

    By their names; without names, by the derivative. Raises InputError where no block can be the
    positions.
    """
    position, velocity = _by_name(file) or _nameless(file)
    file, rate, still = _timed(file, position, velocity)
    position = file.block(position.names)
    velocity = file.block(velocity.names) if velocity else None
    units = _units(file, position, velocity)
    measured = {"actual_q": position}
    if velocity and velocity.names not in file.evidence.excluded:
        measured["actual_qd"] = velocity
    targets = {name: block for name in TARGET_UNITS if (block := file.meant(name, position.clock))}
    return _with_targets(ImportedMotion(file, measured, units, rate, still), targets)


def _by_name(file: FileContents) -> tuple[ColumnBlock, ColumnBlock | None] | None:
    """Return the positions and the velocities that names tell."""
    named = [block for block in file.blocks if block.meaning() == "actual_q"]
    if not named:
        return None
    position, *others = named
    if others:
        titles = ", ".join(block.title for block in others)
        file.evidence.left_out.append(f"{titles}: named like positions, as {position.title} before")
    return position, file.meant("actual_qd", position.clock)


def _nameless(file: FileContents) -> tuple[ColumnBlock, ColumnBlock]:
    """Return the two nameless blocks of which one is the derivative of the other."""
    pairs = sorted(_pairs(file), key=lambda pair: pair[2])
    if not pairs:
        columns = [f"channel{k + 1}" for k in range(len(file.blocks) - 1)]
        example = ",".join([*(["time"] if file.has_clock() else []), "actual_q", *columns])
        raise InputError(
            NO_POSITIONS_MESSAGE.format(file.path, file.joints, block_widths(file), example)
        )
    (position, velocity, missed), *others = pairs
    if others and missed > CLEAR_MISFIT_RATIO * others[0][2]:
        file.evidence.check.append(
            f"{position.title} as positions, {velocity.title} as velocities; "
            f"{others[0][0].title} and {others[0][1].title} agree about as well: --columns names "
            "the right ones"
        )
    return position, velocity


def _pairs(file: FileContents) -> Iterator[tuple[ColumnBlock, ColumnBlock, float]]:
    """Yield blocks of the joints, their derivatives, and the share that the slopes miss."""
    wide = (block for block in file.blocks if block.rows.shape[1] == file.joints)
    whole = [block for block in wide if not names_command(block.stem())]
    for position, velocity in itertools.permutations(whole, 2):
        if position.clock == velocity.clock:
            stamps = file.clocks.stamps[position.clock]
            fit = agreement(position.rows, velocity.rows, stamps)
            right = VELOCITY_RATIO_RANGE[0] < fit.ratio < VELOCITY_RATIO_RANGE[1]
            right |= not file.has_clock() and fit.ratio > 0
            if fit.moving and fit.share == 1.0 and right:
                yield position, velocity, fit.missed


def _timed(
    file: FileContents, position: ColumnBlock, velocity: ColumnBlock | None
) -> tuple[FileContents, float | None, bool]:
    """Return the file on its best clock, the rate of its rows, and whether they are postures."""
    if file.has_clock():
        return _on_best_clock(file, position, velocity), None, False
    if file.stated.rate:
        return file, file.stated.rate, False
    if velocity is None and are_postures(
        position.rows / (DEGREES_PER_RADIAN if _in_degrees(file, position) else 1)
    ):
        file.evidence.check.append(
            "still: true: without a clock, and each row far from the next, the rows are taken for "
            "postures at rest; those of a motion have a rate, as --rate 125"
        )
        return file, None, True
    rows = file.clocks.stamps[ROW_CLOCK]
    if velocity and (rate := _rate(agreement(position.rows, velocity.rows, rows))):
        file.evidence.proven.append(
            f"rate {rate:g}: without a clock, {position.title} changes by {velocity.title} at "
            f"{rate:g} rows a second"
        )
        stamps = rows * ASSUMED_RATE / rate
        return file.on_clock(ROW_CLOCK, ROW_CLOCK, stamps, "s"), rate, False
    file.evidence.check.append(
        f"rate {ASSUMED_RATE:g}: the file has no clock, and nothing tells its rate; name the right "
        "one, as with --rate 125"
    )
    return file, ASSUMED_RATE, False


def _rate(fit: Agreement) -> float | None:
    """Return the rate [Hz] of rows of which velocities are derivatives, None where most are not."""
    return float(f"{fit.ratio * ASSUMED_RATE:.4g}") if fit.share > 0.5 and fit.ratio > 0 else None


def _on_best_clock(
    file: FileContents, position: ColumnBlock, velocity: ColumnBlock | None
) -> FileContents:
    """Return the file on the clock of which velocities are derivatives, else the most regular."""
    current, units = position.clock, file.clocks.units
    tried = [
        (_misfit(position, velocity, stamps), name, unit, stamps)
        for name, unit, stamps in alternatives(file.clocks, current)
        if velocity or unit == units.get(name, "s")
    ]
    misfit, name, unit, stamps = min(tried, key=lambda trial: trial[0])
    as_read = [trial[0] for trial in tried if trial[1:3] == (current, units.get(current, "s"))]
    if as_read and as_read[0] <= CLEAR_CLOCK_RATIO * misfit + 1e-9:
        return file
    why = "under it, velocities are derivatives" if velocity else "its steps are regular"
    file.evidence.proven.append(f"{name} in {unit} is the clock: {why}")
    return file.on_clock(current, name, stamps, unit)


def _misfit(position: ColumnBlock, velocity: ColumnBlock | None, stamps: Array) -> float:
    """Return how badly a clock fits: what velocities miss of the slopes, or its jitter."""
    if velocity is None:
        return irregularity(stamps)
    fit = agreement(position.rows, velocity.rows, stamps)
    if not np.isfinite(fit.ratio):
        return WORST_MISFIT
    return fit.missed + abs(np.log(abs(fit.ratio / _nearest(fit.ratio))))


def _nearest(ratio: float) -> float:
    """Return the ratio of velocity to slope that units allow, nearest to one found."""
    return min(
        (1.0, DEGREES_PER_RADIAN, 1 / DEGREES_PER_RADIAN),
        key=lambda allowed: abs(np.log(abs(ratio) / allowed)),
    )


def _in_degrees(file: FileContents, position: ColumnBlock) -> bool:
    """Return whether joints would turn farther than any, were positions in radians."""
    reached = np.nanquantile(np.abs(position.rows), 0.99, axis=0)  # not by a damaged row
    if file.stated.robot:  # whose controller may count turns of the motors
        reached = reached / np.abs(np.diagonal(turns_matrix(described(file.stated.robot))))
    return (
        float(np.median(reached)) > MAX_JOINT_ANGLE or float(np.max(reached)) > 5 * MAX_JOINT_ANGLE
    )


def _units(
    file: FileContents, position: ColumnBlock, velocity: ColumnBlock | None
) -> dict[str, str]:
    """Return the units of positions and velocities that are not SI, as stated, named, or shown."""
    evidence, stated = file.evidence, file.stated.units.get("actual_q")
    named, looks_like_degrees = named_unit(position.names[0]), _in_degrees(file, position)
    degrees = (stated or named or ("deg" if looks_like_degrees else "rad")) == "deg"
    if not (stated or named) and looks_like_degrees:
        evidence.proven.append(f"{position.title} in degrees: no joint turns by as many radians")
    elif looks_like_degrees and not degrees:
        evidence.check.append(f"{position.title} in rad, as named, turns farther than any joint")
    units = {"actual_q": "deg"} if degrees else {}
    if velocity is None:
        evidence.assumed.append("no velocities: differences of the positions take their place")
        return units
    fit = agreement(position.rows, velocity.rows, file.clocks.stamps[position.clock])
    if not fit.moving:
        evidence.assumed.append(f"{velocity.title}: nothing moves that could prove it a velocity")
        return units | ({"actual_qd": "deg/s"} if degrees else {})
    near = _nearest(fit.ratio) if np.isfinite(fit.ratio) else np.nan
    if (
        fit.share < MIN_SHARE_OF_VELOCITIES
        or not VELOCITY_RATIO_RANGE[0] < fit.ratio / near < VELOCITY_RATIO_RANGE[1]
    ):
        evidence.exclude(velocity, f"not the derivative of {position.title}")
        evidence.check.append(
            f"{velocity.title} is not the derivative of {position.title}, column by column: their "
            "joints are in different orders, or one is another quantity; it is left out"
        )
        return units
    if fit.share < 1.0:
        evidence.check.append(
            f"{velocity.title}: {1 - fit.share:.0%} of its moving columns are not the "
            f"derivatives of {position.title}"
        )
    evidence.proven.append(
        f"{velocity.title} is the velocity of {position.title} ({fit.moving} joints move)"
    )
    in_degrees = {1.0: degrees, DEGREES_PER_RADIAN: True, 1 / DEGREES_PER_RADIAN: False}[near]
    return units | ({"actual_qd": "deg/s"} if in_degrees else {})


def _with_targets(measured: ImportedMotion, targets: dict[str, ColumnBlock]) -> ImportedMotion:
    """Return a motion with its targets in radians or degrees, without those of another size."""
    followed_targets, units, motion = (
        dict[str, ColumnBlock](),
        dict(measured.units),
        measured.in_si(),
    )
    for name, block in targets.items():
        followed = motion.get({"target_q": "actual_q", "target_qd": "actual_qd"}.get(name, ""))
        ratio = _size(followed, block.rows) if followed is not None else None
        if ratio is None:
            ratio = DEGREES_PER_RADIAN if "actual_q" in units else 1.0
        if not any(
            VELOCITY_RATIO_RANGE[0] < ratio / unit < VELOCITY_RATIO_RANGE[1]
            for unit in (1.0, DEGREES_PER_RADIAN)
        ):
            measured.file.evidence.exclude(block, "what moves does not follow it")
            continue
        followed_targets[name] = block
        units |= {name: TARGET_UNITS[name]} if ratio > VELOCITY_RATIO_RANGE[1] else {}
    return replace(measured, blocks=measured.blocks | followed_targets, units=units)


def _size(motion: Array, target: Array) -> float | None:
    """Return the ratio of a target to what follows it (N, n), None where nothing moves.

    NaN where most joints that move do not follow.
    """
    pairs = zip((motion - np.nanmean(motion, axis=0)).T, target.T, strict=True)
    moving = [ratio for pair in pairs if (ratio := _ratio(*pair)) is not None]
    good = [ratio for ratio in moving if np.isfinite(ratio)]
    if not moving:
        return None
    return float(np.median(good)) if 2 * len(good) > len(moving) else np.nan
