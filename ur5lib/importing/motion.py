"""The blocks that are positions and velocities: the latter are derivatives of the former."""

import itertools
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ur5lib.errors import InputError, some
from ur5lib.importing.blocks import Block, names_command
from ur5lib.importing.contents import Contents
from ur5lib.recordings.checks import MOVES
from ur5lib.recordings.stop_signs import DEGREES
from ur5lib.timeseries.arrays import Array

AGREE = 0.9  # least correlation of a slope with its velocity
RATIO = (0.8, 1.25)  # of a slope to its velocity
CLOSER = 0.1  # of what another block misses as a derivative; then it is no rival
LONGEST = 0.1  # s; across longer steps, a slope is no velocity
SMOOTHED = 0.05  # s
TARGETS = {"target_q": "deg", "target_qd": "deg/s", "target_qdd": "deg/s2"}  # if in degrees
TURN = 4 * np.pi  # rad; no joint turns further
COUNTS = {6: "six", 7: "seven", 8: "eight"}
NO_PAIR = (
    "none is named like positions (`actual_q_0`, `joint_position`), and no block of {} columns is "
    "the derivative of another; it holds {}; name the columns, or import it together with a "
    "recording of the same columns in which the arm moves"
)


@dataclass(frozen=True)
class ImportedMotion:
    """Positions of a file's joints, and their velocities and targets as far as recorded.

    blocks: by channel; units: by channel, those that are not SI.
    """

    file: Contents
    blocks: dict[str, Block]
    units: dict[str, str]

    @property
    def position(self) -> Block:
        """Return the positions."""
        return self.blocks["actual_q"]

    @property
    def time(self) -> Array:
        """Return the time stamps (N,) [s]."""
        return self.file.clocks[self.position.clock]

    def beside(self, meanings: Collection[str]) -> list[Block]:
        """Return other blocks of the joints on the positions' clock, by meaning or nameless."""
        own = [*map(id, self.blocks.values())]
        return [
            block
            for block in self.file.blocks
            if block.clock == self.position.clock
            and block.rows.shape[1] == self.file.joints
            and id(block) not in own
            and (block.meaning() in meanings or block.is_nameless())
        ]

    def in_si(self) -> dict[str, Array]:
        """Return the measured positions and velocities (N, n) [rad, rad/s]."""
        return {
            name: block.rows / (DEGREES if name in self.units else 1.0)
            for name, block in self.blocks.items()
            if name not in TARGETS
        }


def agreement(position: Block, velocity: Block, time: Array) -> tuple[float, float, int]:
    """Return how well a block is the derivative of another.

    Share of the moving columns that agree, median ratio of velocity to slope, and number of moving
    columns.
    """
    ratios = [ratio for ratio in column_ratios(position, velocity, time) if ratio is not None]
    good = [ratio for ratio in ratios if np.isfinite(ratio)]
    if not good:
        return 0.0, np.nan, len(ratios)
    return len(good) / len(ratios), float(np.median(good)), len(ratios)


def column_ratios(position: Block, velocity: Block, time: Array) -> list[float | None]:
    """Return the ratio of velocity to slope by column; None if it rests, NaN if they disagree."""
    slope, rate = slopes_and_rates(position.rows, velocity.rows, time)
    return [_ratio(*pair) for pair in zip(slope.T, rate.T, strict=True)]


def slopes_and_rates(position: Array, velocity: Array, time: Array) -> tuple[Array, Array]:
    """Return smoothed slopes of positions (N, k) and velocities at the same times (M, k)."""
    step = np.diff(time)
    width = max(1, round(SMOOTHED / max(float(np.median(step)), 1e-4)))
    whole = (step > 0) & (step < LONGEST) & np.isfinite(np.diff(position, axis=0)).all(axis=1)
    rise = np.diff(position, axis=0)[whole]
    step = step[whole, None]
    rate = (velocity[1:] + velocity[:-1])[whole] / 2 * step
    count = len(rise) // width * width
    rise, rate, step = (v[:count].reshape(-1, width, v.shape[-1]) for v in (rise, rate, step))
    return rise.sum(axis=1) / step.sum(axis=1), rate.sum(axis=1) / step.sum(axis=1)


def _ratio(slope: Array, rate: Array) -> float | None:
    finite = np.isfinite(slope) & np.isfinite(rate)
    slope, rate = slope[finite], rate[finite]
    if len(slope) < 10 or max(np.std(slope), np.std(rate)) < MOVES:
        return None
    if min(np.std(slope), np.std(rate)) == 0 or np.corrcoef(slope, rate)[0, 1] < AGREE:
        return np.nan
    return float(slope @ rate / (slope @ slope))


def find_motion(file: Contents) -> ImportedMotion:
    """Return the positions, the velocities, and the targets of both.

    By their names, and proven by the derivative; without names, by the derivative alone. Raises
    InputError where no block or more than one may be the positions.
    """
    named = {block.meaning(): block for block in reversed(file.blocks)}
    if "actual_q" in named:
        position = named["actual_q"]
        if others := [b.title for b in file.blocks if b.meaning() == "actual_q"][1:]:
            file.evidence.assumed.append(
                f"{position.title} are the positions; left out: {', '.join(others)}, named like "
                "positions, too"
            )
    else:
        position, named["actual_qd"] = _nameless(file)
    beside = {name: block for name, block in named.items() if block.clock == position.clock}
    velocity = beside.get("actual_qd")
    measured = {"actual_q": position} | ({"actual_qd": velocity} if velocity else {})
    motion = ImportedMotion(file, measured, _units(file, position, velocity))
    return _with_targets(motion, {name: beside[name] for name in TARGETS if name in beside})


def _with_targets(measured: ImportedMotion, targets: dict[str, Block]) -> ImportedMotion:
    """Return a motion with its targets in radians or degrees, without those of another size."""
    evidence, kept, units = measured.file.evidence, dict[str, Block](), dict(measured.units)
    for name, block in targets.items():
        ratio = _size(measured, name, block)
        unit = DEGREES if "actual_q" in units else 1.0
        if ratio is not None:
            unit = DEGREES if abs(ratio) > np.sqrt(DEGREES) else 1.0
        if ratio is not None and not RATIO[0] < ratio / unit < RATIO[1]:
            evidence.left_out.append(block.names)
            evidence.assumed.append(f"{block.title}: left out, for what moves does not follow it")
            continue
        kept[name] = block
        units |= {name: TARGETS[name]} if unit == DEGREES else {}
    return replace(measured, blocks=measured.blocks | kept, units=units)


def _size(measured: ImportedMotion, name: str, block: Block) -> float | None:
    """Return the ratio of a target to what it commands, None where nothing tells it.

    NaN where most joints that move do not follow; accelerations may be too small to tell.
    """
    own = measured.in_si().get({"target_q": "actual_q"}.get(name, "actual_qd"))
    if own is None:
        return None
    if name == "target_qdd":
        ratios = column_ratios(replace(block, rows=own), block, measured.time)
    else:
        both = zip((own - np.nanmean(own, axis=0)).T, block.rows.T, strict=True)
        ratios = [_ratio(*pair) for pair in both]
    moving = [ratio for ratio in ratios if ratio is not None]
    found = [ratio for ratio in moving if np.isfinite(ratio)]
    if 2 * len(found) > len(moving):
        return float(np.median(found))
    return None if name == "target_qdd" or not moving else np.nan


def _nameless(file: Contents) -> tuple[Block, Block]:
    ranked = sorted(_pairs(file), key=lambda pair: pair[2])
    pairs = [pair[:2] for pair in ranked]
    if len(pairs) != 1 and not (pairs and ranked[0][2] < CLOSER * ranked[1][2]):
        several = " and ".join(f"{p.title} with {v.title}" for p, v in pairs[:2])
        shown = [f"{block.title} ({block.rows.shape[1]})" for block in file.blocks]
        held = some(shown, 6) or "nothing beside its clock"
        none = NO_PAIR.format(COUNTS[file.joints], held)
        raise InputError(
            f"{file.path}: the columns of the positions are ambiguous: "
            + (f"{several} may be; name the columns" if pairs else none)
        )
    return pairs[0]


def _pairs(file: Contents) -> Iterator[tuple[Block, Block, float]]:
    """Yield blocks of the joints, their derivatives, and the share that the slopes miss."""
    every = (block for block in file.blocks if block.rows.shape[1] == file.joints)
    whole = [block for block in every if not names_command(block.stem())]
    for position, velocity in itertools.permutations(whole, 2):
        if position.clock == velocity.clock:
            stamps = file.clocks[position.clock]
            share, ratio, count = agreement(position, velocity, stamps)
            if count and share == 1.0 and RATIO[0] < ratio < RATIO[1]:
                slope, rate = slopes_and_rates(position.rows, velocity.rows, stamps)
                missed = np.nansum((slope - rate) ** 2) / np.nansum(slope**2)
                yield position, velocity, float(missed)


def _units(file: Contents, position: Block, velocity: Block | None) -> dict[str, str]:
    """Return the units of positions and velocities that are not SI."""
    evidence = file.evidence
    reached = np.nanquantile(np.abs(position.rows), 0.99, axis=0)  # not by a damaged row
    degrees = float(np.median(reached)) > TURN
    units = {"actual_q": "deg"} if degrees else {}
    if degrees:
        evidence.proven.append(f"{position.title} in degrees: no joint turns by as many radians")
    if velocity is None:
        evidence.assumed.append("no velocities: differences of the positions take their place")
        return units
    share, ratio, count = agreement(position, velocity, file.clocks[position.clock])
    if not count:
        evidence.assumed.append(f"{velocity.title}: nothing moves that could prove it a velocity")
        return units
    in_degrees = {1.0: degrees, DEGREES: True, 1 / DEGREES: False}
    near = min(in_degrees, key=lambda factor: abs(np.log(abs(ratio) / factor)) if ratio else np.inf)
    if share < 1.0 or not RATIO[0] < ratio / near < RATIO[1]:
        raise InputError(
            f"{file.path}: {velocity.title} is not the derivative of {position.title}, column by "
            "column: their joints are in different orders, or one of them is another quantity; "
            "bring them into one order, or write the entry by hand (raw/README.md)"
        )
    evidence.proven.append(
        f"{velocity.title} is the velocity of {position.title} ({count} joints move)"
    )
    return units | ({"actual_qd": "deg/s"} if in_degrees[near] else {})
