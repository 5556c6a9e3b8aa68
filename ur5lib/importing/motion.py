"""The blocks that are positions and velocities, by name; and the clock under which they agree."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import NamedTuple

import numpy as np

from ur5lib.checks.channels import MIN_MOVING_SPEED
from ur5lib.checks.checked import described, described_arms
from ur5lib.checks.readings import usual_orders
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
from ur5lib.importing.poses import fitting, poses
from ur5lib.importing.spellings import (
    EFFORTS,
    TARGET_OR_TORQUE,
    last_part,
    named_unit,
    names_command,
    names_share,
)
from ur5lib.importing.stated_units import in_stated_values, values_of
from ur5lib.importing.unwrapped import with_continuous_angles
from ur5lib.records.account import NOTHING, Confidence
from ur5lib.robots.drives import turns_matrix
from ur5lib.timeseries.arrays import Array, Mask

MIN_CORRELATION = 0.9  # of a slope with its velocity
VELOCITY_RATIO_RANGE = (0.8, 1.25)  # of a velocity to its slope
CLEAR_MISFIT_RATIO = 0.1  # of what another block misses as a derivative
MAX_SLOPE_STEP = 1.0  # s; across longer steps, a slope is no velocity
SLOPE_SPANS = (0.05, 0.3)  # s
MIN_SLOPES = 10
MIN_COMPARED = 2  # blocks of which the slowest may be angles
USUAL_SHARE_OF_SLOPES = 0.95  # beyond which they may be leaps
MIN_LEAP_SHARE = 0.02  # of a joint's travel, by which it leaps between two runs
MAX_SHARE_AROUND_LEAP = 0.2  # of a leap, that the joint moves in the steps before and after it
MIN_SHARE_OF_VELOCITIES = 0.8  # of moving columns that are derivatives; two exchanged are fewer
CLEAR_CLOCK_RATIO = 2.0  # times the misfit of another clock that then takes its place
WORST_MISFIT = 10.0  # of a clock under which no velocity is a derivative
SHARES_REACH = 100.0  # of each joint's own range, to which some drivers of servos scale it
SERVO = re.compile(r"[a-z]\.[a-z]+$")  # a motor and its quantity, as elbow_flex.pos
COUNTS_REACH = 3600.0  # least, of encoders; no joint turns so many degrees
NO_ANGLE = (
    "in degrees, if it is an angle: within −100 … 100 it may be a share of each joint's range, and "
    "beyond ten turns counts of encoders; then ask for the calibration file"
)
BESIDE_POSITIONS = ("actual_qd", *EFFORTS)
TARGET_UNITS = {"target_q": "deg", "target_qd": "deg/s", "target_qdd": "deg/s2"}  # if in degrees
MAX_RATIO_OF_FACTORS = 1.5  # of the largest to the smallest, where columns have one unit
MAX_SHARE_BEHIND_TARGET = 0.05  # of the range of the positions, or of 1
MAX_TURN_AT_REST = 0.01  # rad
MAX_ROUGHNESS = 0.5  # of the changes of steps to the steps; noise has 1.7
MAX_JOINT_ANGLE = 4 * np.pi  # rad; no joint turns further


class Agreement(NamedTuple):
    """How well a block is the derivative of another.

    share: of the moving columns that agree; ratio: median of velocity to slope; moving: number of
    moving columns; missed: share of the slopes' squares that the velocities miss; ratios: of
    velocity to slope, of each column that agrees.
    """

    share: float
    ratio: float
    moving: int
    missed: float
    ratios: Sequence[float] = ()

    def is_of_own_factors(self) -> bool:
        """Return whether all columns agree, but each by a factor of its own."""
        sizes = np.abs(self.ratios)
        return self.share == 1.0 and bool(sizes.max() > MAX_RATIO_OF_FACTORS * sizes.min())


@dataclass(frozen=True)
class ImportedMotion:
    """Positions of a file's joints, and their velocities and targets if recorded.

    blocks: by channel; units: by channel, those that are not SI; rate: [Hz] of a file without a
    clock, else None; still: whether its rows are postures.
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
        """Return further blocks with a column for each joint, on the positions' clock, that are
        nameless or have one of the meanings.
        """
        motion_blocks = [*map(id, self.blocks.values())]
        return [
            block
            for block in self.file.blocks
            if np.array_equal(self.file.clocks.stamps[block.clock], self.time, equal_nan=True)
            and block.rows.shape[1] == self.file.joints
            and id(block) not in motion_blocks
            and block.names not in self.file.account.excluded
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
    """Return how well velocities (N, k) are the derivatives of positions (N, k) at times (N,).

    Slopes are taken over the span of SLOPE_SPANS with which most columns agree: a longer one if
    positions are rounded.
    """
    found = (_agreement(*slopes_and_rates(position, velocity, time, span)) for span in SLOPE_SPANS)
    return max(found, key=lambda fit: fit.share)


def _agreement(slope: Array, rate: Array) -> Agreement:
    """Return how well velocities (M, k) agree with slopes (M, k)."""
    moving, good = _ratios(slope, rate)
    if not good:
        return Agreement(0.0, np.nan, len(moving), np.inf)
    ratio = float(np.median(good))
    missed = np.nansum((slope - rate / ratio) ** 2) / np.nansum(slope**2)
    return Agreement(len(good) / len(moving), ratio, len(moving), float(missed), good)


def slopes_and_rates(
    position: Array,
    velocity: Array,
    time: Array,
    span: float = SLOPE_SPANS[0],
    with_leaps: bool = False,
) -> tuple[Array, Array]:
    """Return smoothed slopes of positions (N, k), and the velocities at the same times, both (M,
    k).

    Rows that repeat a stamp count once; rows without positions (of other topics in one table) are
    left out; velocities in rows of their own are interpolated. span: of a slope [s]; with_leaps:
    also across the start of another run, so that all blocks have as many.
    """
    there = (np.diff(time, prepend=-np.inf) > 0) & np.isfinite(position).all(axis=1)
    apart = np.isfinite(velocity).all(axis=1)
    if np.count_nonzero(apart & there) < np.count_nonzero(apart & ~there):
        rows = [np.interp(time, time[apart], column[apart]) for column in velocity.T]
        velocity = np.stack(rows, axis=1)
    position, velocity, time = position[there], velocity[there], time[there]
    step = np.diff(time)
    width = max(1, round(span / max(float(np.median(step)), 1e-4))) if len(step) else 1
    rise = np.diff(position, axis=0)
    whole = step < MAX_SLOPE_STEP
    if len(position) and not with_leaps:
        whole &= ~_leaps(rise, np.ptp(position, axis=0))
    rise = rise[whole]
    step = step[whole, None]
    rate = (velocity[1:] + velocity[:-1])[whole] / 2 * step
    count = len(rise) // width * width
    rise, rate, step = (v[:count].reshape(-1, width, v.shape[-1]) for v in (rise, rate, step))
    return rise.sum(axis=1) / step.sum(axis=1), rate.sum(axis=1) / step.sum(axis=1)


def _leaps(rise: Array, travel: Array) -> Mask:
    """Return which steps (N,) of positions, of size `rise` (N, k), leap to the start of another run
    in the same file.

    A leap is isolated: the joint moves far less just before and after. travel: of each column (k,).
    """
    size = np.abs(rise)
    around = np.zeros_like(size)
    around[1:] = size[:-1]
    around[:-1] = np.maximum(around[:-1], size[1:])
    far = (size > MIN_LEAP_SHARE * travel) & (around < MAX_SHARE_AROUND_LEAP * size)
    return np.asarray(far.any(axis=1))


def _ratios(slopes: Array, rates: Array) -> tuple[list[float], list[float]]:
    """Return the ratios of velocity to slope of the moving columns, and the finite ones among
    these.
    """
    ratios = map(_ratio, slopes.T, rates.T)
    moving = [ratio for ratio in ratios if ratio is not None]
    return moving, [ratio for ratio in moving if np.isfinite(ratio)]


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


def rests(moving: ImportedMotion) -> bool:
    """Return whether no joint of a motion turns further than MAX_TURN_AT_REST."""
    return bool(np.nanmax(np.ptp(moving.in_si()["actual_q"], axis=0)) < MAX_TURN_AT_REST)


def find_motion(file: FileContents) -> ImportedMotion:
    """Return the positions of a file with velocities and targets, by their names, else by which
    block is the derivative of which.

    Raises InputError where no block can be the positions.
    """
    file = with_continuous_angles(file)
    file = _without_copies(file)
    position, velocity = _by_name(file) or _by_slopes(file) or (_slowest(file), None)
    file, position, velocity = _in_stated_values(file, position, velocity)
    file, rate, still = _timed(file, position, velocity)
    file = _with_polled_target(file, file.block(position.names))
    position = file.block(position.names)
    velocity = file.block(velocity.names) if velocity else None
    units = _units(file, position, velocity)
    measured = {"actual_q": position}
    if velocity and velocity.names not in file.account.excluded:
        measured["actual_qd"] = velocity
    targets = {name: block for name in TARGET_UNITS if (block := file.meant(name, position.clock))}
    return _with_targets(ImportedMotion(file, measured, units, rate, still), targets)


def _in_stated_values(
    file: FileContents, position: ColumnBlock, velocity: ColumnBlock | None
) -> tuple[FileContents, ColumnBlock, ColumnBlock | None]:
    """Return a file with positions and velocities in SI units, by the values that the user states;
    of velocities that are in the unit of the positions, by these.
    """
    stamps, units = file.clocks.stamps[position.clock], file.stated.units
    whole = in_stated_values(position, "actual_q", file)
    new, rate = {id(position): whole}, velocity
    if velocity is not None:
        rate = in_stated_values(velocity, "actual_qd", file)
        if whole is not position and "actual_qd" not in units and file.has_clock():
            fit = agreement(position.rows, velocity.rows, stamps)
            alike = fit.share == 1.0 and _is_near(fit.ratio)
            rate = velocity.scaled(np.array(whole.factors)) if alike else velocity
        new[id(velocity)] = rate
    return replace(file, blocks=[new.get(id(b), b) for b in file.blocks]), whole, rate


def _without_copies(file: FileContents) -> FileContents:
    """Return the file without nameless blocks that repeat an earlier one."""
    kept = list[ColumnBlock]()
    for block in file.blocks:
        same = (one for one in kept if np.array_equal(one.rows, block.rows, equal_nan=True))
        if block.is_nameless() and (first := next(same, None)):
            file.account.exclude(block, f"it repeats {first.title}")
        else:
            kept.append(block)
    return replace(file, blocks=kept)


def _by_name(file: FileContents) -> tuple[ColumnBlock, ColumnBlock | None] | None:
    """Return the block named as positions, and that of the velocities, None if unnamed; None
    without positions.
    """
    position = next((block for block in file.blocks if block.meaning() == "actual_q"), None)
    if position is None:
        return None
    velocity = file.meant("actual_qd", position.clock)
    if velocity is None and position.stated:
        velocity = next((other for one, other, _ in _pairs(file) if one is position), None)
    return position, velocity


def _with_polled_target(file: FileContents, position: ColumnBlock) -> FileContents:
    """Return the file with the block `tq` as the target of q if it stays near q, else it remains a
    torque.
    """
    blocks = [*file.blocks]
    for place, block in enumerate(blocks):
        named = last_part(block.stem()).lower() == TARGET_OR_TORQUE
        if named and block.rows.shape == position.rows.shape:
            apart = float(np.nanmedian(np.abs(block.rows - position.rows), axis=0).max())
            range_of_q = float(np.nanmax(np.ptp(np.nan_to_num(position.rows), axis=0)))
            if apart < MAX_SHARE_BEHIND_TARGET * max(range_of_q, 1.0):
                blocks[place] = replace(block, stated="target_q")
                near = f"no torque, but the target of {position.title}: within {apart:.2g} of it"
                file.account.hold("proven", block, "numbers", near)
    return replace(file, blocks=blocks)


def _by_slopes(file: FileContents) -> tuple[ColumnBlock, ColumnBlock] | None:
    """Return positions and velocities: the two nameless blocks of which one is best the derivative
    of the other; None if there are none.
    """
    pairs = sorted(_pairs(file), key=lambda pair: pair[2])
    if not pairs:
        return None
    (position, velocity, missed), *others = pairs
    if others and missed > CLEAR_MISFIT_RATIO * others[0][2]:
        rivals = f"{others[0][0].title} and {others[0][1].title} agree about as well"
        doubt = f"as positions, {velocity.title} as velocities; {rivals}: --columns names others"
        file.account.hold("check", position, "numbers", doubt)
    return position, velocity


def _slowest(file: FileContents) -> ColumnBlock:
    """Return the nameless block that changes slowest for its size, without steps, as angles do
    among all that an arm's motion causes. Raises InputError if there is none, if it is alone, as in
    the file of a sensor, or where a part of a group is left, so that the columns may be parted
    otherwise.
    """
    paces = {k: _pace(file, b) for k, b in enumerate(file.blocks) if b.is_nameless()}
    finite = sorted((pace, k) for k, pace in paces.items() if np.isfinite(pace))
    parted = any(1 < file.blocks[k].rows.shape[1] < file.joints for k in paces)
    if not finite or parted or len(paces) < MIN_COMPARED:
        raise InputError(f"{file.path}: no positions are found: {_why_no_positions(file)}")
    by_pose = (k for _, k in finite if _is_posed(file, file.blocks[k]))
    if (k := next(by_pose, None)) is not None:
        return file.blocks[k]
    block = file.blocks[finite[0][1]]
    rivals = [f"{file.blocks[k].title} {pace / finite[0][0]:.2g} times" for pace, k in finite[1:2]]
    faster = f"; it changes slowest for its size, {rivals[0]} as fast" if rivals else ""
    why = f"the block of {file.joints} columns that may be angles{faster}; or others, by --columns"
    file.account.hold("check", block, "numbers", why)
    return block


def _is_posed(file: FileContents, block: ColumnBlock) -> bool:
    """Return whether a block has angles that put the flange of an arm at another block."""
    rows = block.rows / (DEGREES_PER_RADIAN if _in_degrees(file, block) else 1.0)
    known, orders = described_arms().values(), usual_orders(file.joints)
    arms = [arm for arm in known if len(arm.joints) == file.joints and not arm.is_counted()]
    others = poses([b for b in file.blocks if b is not block], block.clock)
    return bool(arms) and any(
        fitting(rows, pose.in_metres()[1], arms, orders).good for pose in others
    )


def _pace(file: FileContents, block: ColumnBlock) -> float:
    """Return by which share of its spread a block changes from row to row; infinite if it is no
    smooth motion of as many angles as the arm has.
    """
    rows = block.rows[np.isfinite(block.rows).all(axis=1)]
    if rows.shape[1] != file.joints or len(rows) < MIN_SLOPES:
        return np.inf
    rise, spread = np.diff(rows, axis=0), rows.std(axis=0)
    moves = np.ptp(rows, axis=0) > MAX_TURN_AT_REST
    turns = np.abs(rows).max() / (DEGREES_PER_RADIAN if _in_degrees(file, block) else 1.0)
    steady = (rise >= 0).all(axis=0) | (rise <= 0).all(axis=0)  # as temperatures rise
    if not moves.any() or steady.all() or turns > MAX_JOINT_ANGLE:
        return np.inf
    rough = np.diff(rise, axis=0).std(axis=0)[moves] / rise.std(axis=0)[moves]
    pace = rise.std(axis=0)[moves] / spread[moves]
    return float(np.median(pace)) if np.median(rough) < MAX_ROUGHNESS else np.inf


def _why_no_positions(file: FileContents) -> str:
    """Return why no block can be the positions, and the remedy."""
    columns = [f"channel{k + 1}" for k in range(len(file.blocks) - 1)]
    example = ",".join([*(["time"] if file.has_clock() else []), "actual_q", *columns])
    remedy = f"name the columns, as with --columns {example}; it holds {block_widths(file)}"
    if resting := next((block for block in file.blocks if _is_posture(file, block)), None):
        return (
            f"the arm does not move, if {resting.title} are its joints' angles, and nothing else "
            f"shows which columns are positions; give a log that moves with it, or {remedy}"
        )
    return (
        "none is named like them (`actual_q_0`, `joint_position`), and no block of "
        f"{file.joints} columns is the derivative of another; {remedy}"
    )


def _is_posture(file: FileContents, block: ColumnBlock) -> bool:
    """Return whether a block may be the angles of an arm that rests: each joint's own, constant."""
    rows = block.rows[np.isfinite(block.rows).all(axis=1)]
    if rows.shape[1] != file.joints or not len(rows):
        return False
    unit = DEGREES_PER_RADIAN if _in_degrees(file, block) else 1.0
    turned, apart = np.ptp(rows, axis=0).max() / unit, np.ptp(rows[0]) / unit
    return bool(turned < MAX_TURN_AT_REST < apart)


def _pairs(file: FileContents) -> Iterator[tuple[ColumnBlock, ColumnBlock, float]]:
    """Yield (positions, velocities, share of slopes missed) for blocks of which one is the
    derivative of the other.
    """
    wide = (block for block in file.blocks if block.rows.shape[1] == file.joints)
    whole = [block for block in wide if not names_command(block.stem())]
    for position, velocity in _likely_pairs(whole, file.clocks.stamps):
        fit = agreement(position.rows, velocity.rows, file.clocks.stamps[position.clock])
        right = _is_near(fit.ratio) or (not file.has_clock() and fit.ratio > 0)
        if fit.moving and fit.share == 1.0 and right:
            yield position, velocity, fit.missed


def _likely_pairs(
    blocks: Sequence[ColumnBlock], stamps: Mapping[str, Array]
) -> Iterator[tuple[ColumnBlock, ColumnBlock]]:
    """Yield pairs (positions, velocities) of blocks on one clock of which the second correlates,
    column by column, with the slopes of the first.
    """
    by_clock = groupby(sorted(blocks, key=lambda block: block.clock), lambda block: block.clock)
    for clock, same in ((clock, [*group]) for clock, group in by_clock):
        pairs = [
            slopes_and_rates(np.nan_to_num(b.rows), b.rows, stamps[clock], with_leaps=True)
            for b in same
        ]
        slopes, rates = (np.nan_to_num(np.stack(part)) for part in zip(*pairs, strict=True))
        if slopes.shape[1] == 0:  # of two rows
            continue
        slopes, rates = map(_usual_part, (slopes, rates))  # without leaps between runs
        least = np.ones((len(same), len(same)))
        for slope, rate in zip(slopes.transpose(2, 0, 1), rates.transpose(2, 0, 1), strict=True):
            still = np.minimum.outer(slope.std(axis=1), rate.std(axis=1)) < MIN_MOVING_SPEED
            alike = _standardised(slope) @ _standardised(rate).T
            least = np.where(still, least, np.minimum(least, alike))
        np.fill_diagonal(least, 0.0)
        for k, j in zip(*np.nonzero((least >= MIN_CORRELATION - 0.2) & (least < 1)), strict=True):
            yield same[k], same[j]


def _usual_part(rates: Array) -> Array:
    """Return rates (n, M, k) limited, in each column, to the size below which most of it stays."""
    usual = np.quantile(np.abs(rates), USUAL_SHARE_OF_SLOPES, axis=1, keepdims=True)
    return np.clip(rates, -usual, usual)


def _standardised(rows: Array) -> Array:
    """Return rows (n, M) less their mean, each of norm 1."""
    centred = rows - rows.mean(axis=1, keepdims=True)
    return centred / (np.linalg.norm(centred, axis=1, keepdims=True) + 1e-300)


def _timed(
    file: FileContents, position: ColumnBlock, velocity: ColumnBlock | None
) -> tuple[FileContents, float | None, bool]:
    """Return the file on its best clock; the rate [Hz] of its rows, None with a clock; and whether
    rows are postures.
    """
    if file.has_clock():
        return _on_best_clock(file, position, velocity), None, False
    if file.stated.rate:
        return file, file.stated.rate, False
    unit = DEGREES_PER_RADIAN if _in_degrees(file, position) else 1.0
    if velocity is None and are_postures(position.rows / unit):
        leaps = "without a clock, and each row far from the next; or a motion with --rate 125"
        file.account.tell("check", "rows", "postures at rest", "numbers", leaps)
        return file, None, True
    rows = file.clocks.stamps[ROW_CLOCK]
    fit = agreement(position.rows, velocity.rows, rows) if velocity else None
    if velocity and fit and (rate := _rate(fit, rows)):
        follows = f"{position.title} changes by {velocity.title} at {rate:g} rows a second"
        sure, misses = _beside_next_column(fit, position, velocity, rows)
        file.account.tell(sure, "rate", f"{rate:g} Hz", "numbers", f"{follows}: {misses}")
        stamps = np.arange(len(rows)) / rate
        return file.on_clock(ROW_CLOCK, ROW_CLOCK, stamps, "s"), rate, False
    unknown = "no clock, and nothing tells another rate of the rows; name it, as with --rate 125"
    file.account.tell("check", "rate", f"{ASSUMED_RATE:g} Hz", "position", unknown)
    return file, ASSUMED_RATE, False


def _rate(fit: Agreement, rows: Array) -> float | None:
    """Return the rate [Hz] of rows by how positions and velocities agree at stamps (N,) [s]; None
    if most columns do not agree.
    """
    if fit.share <= 0.5 or fit.ratio <= 0:
        return None
    return float(f"{fit.ratio / (rows[1] - rows[0]):.4g}")


def _on_best_clock(
    file: FileContents, position: ColumnBlock, velocity: ColumnBlock | None
) -> FileContents:
    """Return the file on the clock with which velocities are derivatives best; without moving
    joints, on the most regular one.
    """
    current, units = position.clock, file.clocks.units
    tried = [
        (_misfit(position, velocity, stamps), name, unit, stamps)
        for name, unit, stamps in alternatives(file.clocks, current)
        if velocity or unit == units.get(name, "s")
    ]
    if min(trial[0] for trial in tried) >= WORST_MISFIT:  # nothing moves that could show it
        regular = [trial[1:] for trial in tried if trial[2] == units.get(trial[1], "s")]
        tried = [(irregularity(trial[2]), *trial) for trial in regular]  # of any unit the same
        velocity = None
    misfit, name, unit, stamps = min(tried, key=lambda trial: trial[0])
    as_read = [trial[0] for trial in tried if trial[1:3] == (current, units.get(current, "s"))]
    if as_read and as_read[0] <= CLEAR_CLOCK_RATIO * misfit + 1e-9:
        return file
    what = "velocities miss" if velocity else "its steps differ by"
    read = f"{as_read[0]:.2%} under {current}" if as_read else f"{current} tells no time"
    reason = f"in {unit}: {what} {misfit:.2%}, {read}"
    file.account.tell("proven", "clock", name, "numbers", reason)
    return file.on_clock(current, name, stamps, unit)


def _misfit(position: ColumnBlock, velocity: ColumnBlock | None, stamps: Array) -> float:
    """Return how badly a clock fits: what velocities miss of the slopes and their ratio's distance
    from a unit's; without velocities, its irregularity.
    """
    if velocity is None:
        return irregularity(stamps)
    fit = agreement(position.rows, velocity.rows, stamps)
    if not np.isfinite(fit.ratio):
        return WORST_MISFIT
    return fit.missed + abs(np.log(abs(fit.ratio / _nearest(fit.ratio))))


def _nearest(ratio: float) -> float:
    """Return the ratio of velocity to slope, 1 or a change between degrees and radians, that is
    nearest to one found.
    """
    return min(
        (1.0, DEGREES_PER_RADIAN, 1 / DEGREES_PER_RADIAN),
        key=lambda allowed: abs(np.log(abs(ratio) / allowed)),
    )


def _in_degrees(file: FileContents, position: ColumnBlock) -> bool:
    """Return whether positions must be in degrees: in radians, joints would turn farther than any
    does.
    """
    rows = np.abs(position.rows) / _turns(file)
    reached = np.nanquantile(rows, 0.99, axis=0)  # not by a damaged row
    return bool(np.median(reached) > MAX_JOINT_ANGLE or np.max(reached) > 5 * MAX_JOINT_ANGLE)


def _turns(file: FileContents) -> Array:
    """Return how often what is counted turns while a joint does (n,), (1,) where no arm is stated:
    its controller may count turns of the motors.
    """
    if not file.stated.robot:
        return np.ones(1)
    return np.abs(np.diagonal(turns_matrix(described(file.stated.robot))))


def _units(
    file: FileContents, position: ColumnBlock, velocity: ColumnBlock | None
) -> dict[str, str]:
    """Return the units of positions and velocities that are not SI; the account states why."""
    degrees = _are_degrees(file, position)
    units = {"actual_q": "deg"} if degrees else {}
    if velocity is None:
        taken, why = "differences of the positions", "no block is named so"
        file.account.tell("assumed", "velocities", taken, "name", why)
    elif _velocity_in_degrees(file, position, velocity, degrees):
        units["actual_qd"] = "deg/s"
    return units


def _are_degrees(file: FileContents, position: ColumnBlock) -> bool:
    """Return whether positions are in degrees: as stated, named, or by how far they turn."""
    stated, named = file.stated.units.get("actual_q"), named_unit(position.names[0])
    if values_of(stated or "") is not None:
        return False
    shown, most = _in_degrees(file, position), float(np.nanmax(np.abs(position.rows)))
    of_servos = not file.stated.robot or bool(SERVO.search(position.names[0]))
    are_shares = most <= SHARES_REACH and of_servos
    doubtful = shown and not named and (are_shares or are_counts(file, position))
    turns = f"reaches {most:.4g}: as radians {most / 2 / np.pi:.0f} turns; joints turn at most 2"
    if position.stated and position.names[0] not in file.stated.names():
        of_joints = "of the joints by name, and nothing else to be: positions"
        beside = _named_beside(file, position)
        told = f"{of_joints} beside {beside.title}" if beside else of_joints
        file.account.hold("assumed" if beside else "check", position, "name", told)
    if stated:
        file.account.hold("assumed", position, "option", f"in {stated}")
    elif names_share(position.names[0]) or doubtful:
        file.account.hold("check", position, "numbers", f"{NO_ANGLE}: reaches {most:.4g}")
    elif named:
        doubt = f", but {turns}" if shown and named != "deg" else ""
        file.account.hold("check" if doubt else "assumed", position, "name", f"in {named}{doubt}")
    elif shown:
        file.account.hold("assumed", position, "numbers", f"in degrees: {turns}")
    else:
        file.account.hold("assumed", position, position.evidence, f"in rad: reaches {most:.3g}")
    return (stated or named or ("deg" if shown else "rad")) == "deg"


def are_counts(file: FileContents, position: ColumnBlock) -> bool:
    """Return whether positions reach farther than any angle in degrees, as counts of encoders."""
    reached = np.nanquantile(np.abs(position.rows) / _turns(file), 0.99)  # not by a damaged row
    return bool(reached > COUNTS_REACH)


def _named_beside(file: FileContents, position: ColumnBlock) -> ColumnBlock | None:
    """Return a block of the joints that is named as what positions have with them."""
    named = (b for b in file.blocks if b.meaning() in BESIDE_POSITIONS and b is not position)
    return next((b for b in named if b.rows.shape[1] == file.joints), None)


def _velocity_in_degrees(
    file: FileContents, position: ColumnBlock, velocity: ColumnBlock, degrees: bool
) -> bool:
    """Return whether velocities are in degrees; those that are no derivatives are left out of the
    entry.
    """
    account, stamps = file.account, file.clocks.stamps[position.clock]
    fit = agreement(position.rows, velocity.rows, stamps)
    if not fit.moving:
        account.hold("assumed", velocity, velocity.evidence, "nothing moves that could prove it")
        return degrees
    if fit.is_of_own_factors():
        each = ", ".join(f"{ratio:.3g}" for ratio in fit.ratios)
        own = f"{velocity.title} are {each} times their slopes: a factor a joint, so no angles"
        account.hold("check", position, "numbers", f"{own}; ask for the calibration file")
    near = _nearest(fit.ratio) if np.isfinite(fit.ratio) else np.nan
    if fit.share < MIN_SHARE_OF_VELOCITIES or not _is_near(fit.ratio / near):
        no_derivative = f"not the derivative of {position.title}: "
        many = f"{fit.share:.0%} of {fit.moving} moving columns follow it"
        ratio = f", {fit.ratio:.3g} times as fast" if np.isfinite(fit.ratio) else ""
        account.exclude(velocity, no_derivative + many + ratio)
        causes = "joints in another order, of the motors, or another quantity; "
        instead = no_derivative + causes + "differences of the positions take its place"
        account.tell("check", velocity.title, NOTHING, "numbers", instead)
        return False
    if fit.share < 1.0:
        part = f"{1 - fit.share:.0%} of its moving columns are no derivatives of {position.title}"
        account.hold("check", velocity, "numbers", part)
    follows = f"the derivative of {position.title} on {fit.moving} joints that move"
    sure, misses = _beside_next_column(fit, position, velocity, stamps)
    account.hold(sure, velocity, "numbers", f"{follows}: {misses}")
    return {1.0: degrees, DEGREES_PER_RADIAN: True, 1 / DEGREES_PER_RADIAN: False}[near]


def _beside_next_column(
    fit: Agreement, position: ColumnBlock, velocity: ColumnBlock, time: Array
) -> tuple[Confidence, str]:
    """Return how sure velocities are derivatives, and in words what they miss, compared with
    velocities moved by one column.
    """
    shifted = agreement(position.rows, np.roll(velocity.rows, 1, axis=1), time).missed
    rival = f"misses {shifted:.0%}" if np.isfinite(shifted) else "follows no column"
    misses = f"misses {100 * fit.missed:.2g} % of its squares; one column further, it {rival}"
    return "proven" if shifted > 2 * fit.missed else "assumed", misses


def _is_near(ratio: float) -> bool:
    return VELOCITY_RATIO_RANGE[0] < ratio < VELOCITY_RATIO_RANGE[1]


def _with_targets(measured: ImportedMotion, targets: dict[str, ColumnBlock]) -> ImportedMotion:
    """Return a motion with its targets, in radians or degrees; targets that the motion does not
    follow in size are left out.
    """
    blocks, units = dict(measured.blocks), dict(measured.units)
    position, account, motion = measured.position, measured.file.account, measured.in_si()
    for name, block in targets.items():
        followed = motion.get(name.replace("target", "actual"))
        ratio = _size(followed, block.rows) if followed is not None else None
        if ratio is None:
            ratio = DEGREES_PER_RADIAN if "actual_q" in units else 1.0
        is_action = last_part(block.stem()) == "action"
        if is_action and np.array_equal(block.rows, position.rows):
            account.exclude(block, f"it repeats {position.title}")
        elif not (_is_near(ratio) or _is_near(ratio / DEGREES_PER_RADIAN)):
            account.exclude(block, "what moves does not follow it")
        else:
            blocks[name] = block
            units |= {name: TARGET_UNITS[name]} if ratio > VELOCITY_RATIO_RANGE[1] else {}
    return replace(measured, blocks=blocks, units=units)


def _size(motion: Array, target: Array) -> float | None:
    """Return the ratio of a target to the motion (N, n) that follows it, NaN if most moving joints
    do not follow; None if nothing moves.
    """
    moving, good = _ratios(motion - np.nanmean(motion, axis=0), target)
    if not moving:
        return None
    return float(np.median(good)) if 2 * len(good) > len(moving) else np.nan
