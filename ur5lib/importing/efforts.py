"""The channels of a file's efforts: currents, torques or targets, by name, doubted by gravity."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ur5lib.channels import CHANNELS as CHANNELS_OF_RTDE
from ur5lib.importing.blocks import Block
from ur5lib.importing.contents import Contents, Evidence
from ur5lib.importing.spellings import named_unit
from ur5lib.recordings.block_means import TINY, BlockMeans, combination, size
from ur5lib.recordings.checks import MOVES
from ur5lib.recordings.readings import (
    CLEAR_LEAD,
    effort_per_torque,
    lead_of_own_order,
    readings,
    unit_scores,
    usual_orders,
)
from ur5lib.recordings.stop_signs import SMOOTHER, roughness
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

MIN_SHARE_EXPLAINED_BY_FRICTION = 0.3  # of a measured effort's residual
CURRENT = "actual_current"
MEASURED_TORQUE = "actual_current_as_torque"
FREE = "neither"  # current nor torque: a torque less gravity, as some drivers write
UNITS = {"A": "A", "mA": "mA", "Nm": "Nm", FREE: "Nm less gravity"}
ROUNDED = 1e-3  # A; URScript gives currents with three decimals
COUNTED = (100, 100_000)  # multiples of a rounded current's step that it reaches
CHANNELS = {  # by unit, and whether it is a target
    ("A", False): CURRENT,
    ("A", True): "target_current",
    ("Nm", False): MEASURED_TORQUE,
    ("Nm", True): "target_moment",
    (FREE, False): "actual_torque_less_gravity",
}
NAMED = {channel: unit for (unit, _), channel in CHANNELS.items() if unit != FREE}
NAMED |= {"actual_torque": "Nm"}
EFFORTS = ("effort", *NAMED)


def as_amperes(block: Block, evidence: Evidence) -> Block:
    """Return a block in amperes if its columns are rounded currents times constants of a driver.

    Such columns are whole multiples of steps, none of which is a power of ten.
    """
    steps = np.array([_step(np.abs(column)) for column in block.rows.T])
    decimal = np.abs(np.log10(steps) - np.round(np.log10(steps))) < 1e-4
    if np.isnan(steps).any() or decimal.any():
        return block
    constants = ", ".join(f"{step / ROUNDED:.4g}" for step in steps)
    evidence.proven.append(
        f"{block.title} is a current rounded to {1e3 * ROUNDED:.0f} mA, multiplied by constants "
        f"(joint by joint {constants}): it holds whole multiples of these alone"
    )
    return block.scaled(ROUNDED / steps)


def _step(sizes: Array) -> float:
    """Return the number of which sizes (N,) are whole multiples, NaN if there is none."""
    levels = np.unique(sizes[np.isfinite(sizes)])
    gaps = np.diff(levels, prepend=0.0)
    for parts in (1, 2, 3):
        step = gaps[gaps > 1e-6 * levels.max(initial=0.0)].min(initial=np.inf) / parts
        counts = np.round(levels / step)
        if not COUNTED[0] < counts.max(initial=0) < COUNTED[1]:
            continue
        step = levels @ counts / (counts @ counts)
        if np.abs(levels - step * counts).max() < 0.01 * step:
            return float(step)
    return np.nan


def is_opposite(means: BlockMeans, name: str, arms: Sequence[Robot]) -> bool:
    """Return whether an effort has the opposite sign: with it, friction would drive the joints.

    Only where gravity agrees: it explains the turned effort far better. Joints that sense their
    torque have no friction.
    """
    effort, brakes = means.currents[name], []
    for column in range(effort.shape[1]):
        friction, speed = means.friction(column), np.abs(means.qd[:, column]).mean()
        terms = np.column_stack([friction, means.qdd, np.ones(len(effort))])
        force, error = combination(terms, effort[:, column], [1.0, float(speed)])
        brakes.append(force / max(error, TINY))
    if sum(brakes) >= 0 and not all(arm.senses_torque() for arm in arms):
        return False
    ways = [replace(means, currents={name: sign * effort}) for sign in (1, -1)]
    orders = usual_orders(effort.shape[1])
    as_read, turned = (readings(way, arms, orders)[0].score for way in ways)
    return turned - as_read > CLEAR_LEAD


def name_efforts(
    blocks: Mapping[str, Block], means: BlockMeans | None, arm: Robot | None, file: Contents
) -> dict[str, Block]:
    """Return the efforts by channel, in SI units, without those that neither name nor unit tells.

    blocks: by their names in `means`, which have the joints in order, None without a motion.
    """
    evidence = file.evidence
    units = {name: _unit(name, block, means, arm, file) for name, block in blocks.items()}
    currents = [blocks[name] for name, unit in units.items() if unit in ("A", "mA")]
    smooth = _smoothest(currents, file)
    channels: dict[str, Block] = {}
    for name, block in blocks.items():
        unit = units[name]
        if unit is None:
            continue
        if means and arm and unit != FREE:
            _doubt_order(name, block, means, arm, file)
        target = _is_target(name, block, unit, means, arm, file, smooth, currents)
        channel = CHANNELS[unit.replace("mA", "A"), target and unit != FREE]
        if channel == MEASURED_TORQUE and arm and (arm.senses_torque() or not arm.is_ur()):
            channel = "actual_torque"
        if channel == "target_moment" and arm and not arm.is_ur():
            evidence.exclude(block, "a torque that the controller of another arm commanded")
        elif channel in channels:
            evidence.exclude(block, f"it may be {channel}, as {channels[channel].title}")
        else:
            milli = np.full(block.rows.shape[1], 1e-3)
            channels[channel] = block.scaled(milli) if unit == "mA" else block
    return channels


def _unit(
    name: str, block: Block, means: BlockMeans | None, arm: Robot | None, file: Contents
) -> str | None:
    """Return the unit, A, mA, Nm or FREE: as told, named, or shown; None where nothing tells it."""
    evidence, meaning = file.evidence, block.meaning() or ""
    told = file.stated.units.get(meaning)
    stated = named_unit(block.names[0])
    named = stated if stated in ("A", "mA", "Nm") else NAMED.get(meaning)
    if told in ("A", "mA", "Nm"):
        return told
    usual_peak = np.nanmedian(np.abs(block.rows).max(axis=1))
    if named == "A" and usual_peak > CHANNELS_OF_RTDE[CURRENT].bound:
        evidence.proven.append(f"{block.title} in mA: no arm has as many amperes")
        return "mA"
    if means is None or arm is None:
        if named is None:
            evidence.exclude(block, "nothing tells its unit; name it, as with --columns")
        else:
            evidence.assumed.append(f"{block.title} in {named}, by its name")
        return named
    scores = unit_scores(means, name, arm)
    best, rival = sorted(scores, key=lambda unit: -scores[unit])[:2]
    lead, ratio = scores[best] - scores[rival], _gravity_per_unit(means, name, arm)
    sure = lead > CLEAR_LEAD
    free = sure and best == FREE and meaning in ("effort", MEASURED_TORQUE)
    if not free and (stated in scores or named):
        return _as_named(block, named, best, sure, ratio, lead, file)
    if free:
        evidence.check.append(
            f"{block.title} in Nm, less gravity, which does not explain it as it explains every "
            "current and motor torque; the gravity of the arm is added again"
        )
        return FREE
    if best == FREE or not sure:
        evidence.exclude(
            block,
            f"its unit is {UNITS[best]} or {UNITS[rival]} ({ratio}); record more postures, or "
            "name it with --columns and --unit",
        )
        return None
    evidence.proven.append(f"{block.title} in {best}: {ratio}")
    return best


def _as_named(
    block: Block, named: str | None, best: str, sure: bool, ratio: str, lead: float, file: Contents
) -> str | None:
    """Return the unit of RTDE's current or of a named one: another is a doubt, but milliamperes."""
    if sure and best == "mA" and named == "A" and named_unit(block.names[0]) != "A":
        file.evidence.proven.append(f"{block.title} in mA: {ratio}")
        file.evidence.check.append(f"{block.title} in mA, though RTDE's currents are in A")
        return best
    if sure and best == named:
        file.evidence.proven.append(f"{block.title} in {named}: {ratio}")
    elif sure:
        file.evidence.check.append(
            f"{block.title} in {named}, by its name; gravity tells {UNITS[best]} (log-likelihood "
            f"greater by {lead:.3g}): {ratio}"
        )
    else:
        file.evidence.assumed.append(f"{block.title} in {named}, by its name")
    return named


def _gravity_per_unit(means: BlockMeans, name: str, arm: Robot) -> str:
    """Return what gravity shows of the joint that bears most, for a sentence."""
    joint = int(np.argmax(np.std(means.gravity(arm), axis=0)))
    slope, _ = effort_per_torque(means, name, arm, joint)
    if np.isnan(slope):
        return "gravity does not change"
    return f"gravity on joint {joint + 1} is {1 / (slope or np.inf):.3g} Nm per unit of it"


def _doubt_order(name: str, block: Block, means: BlockMeans, arm: Robot, file: Contents) -> None:
    """Note where the joints of an effort have another order than the positions'."""
    leads = [lead_of_own_order(replace(means, offset=may), name, arm) for may in (False, True)]
    if max(leads) < -CLEAR_LEAD:
        file.evidence.check.append(
            f"{block.title}: two of its joints seem exchanged, or it is of another arm: gravity "
            f"and friction explain it better so (log-likelihood greater by {-max(leads):.3g})"
        )
    elif min(leads) < CLEAR_LEAD:
        file.evidence.assumed.append(f"{block.title} has the joints' order of the positions")
    else:
        file.evidence.proven.append(f"{block.title} has the joints' order of the positions")


def _smoothest(currents: list[Block], file: Contents) -> Block | None:
    """Return which of two nameless currents is the target: the one without noise."""
    if len(currents) != 2 or not all(block.is_nameless() for block in currents):
        return None
    first, second = (np.nanmedian(roughness(block.rows)) for block in currents)
    if max(first, second) * SMOOTHER < min(first, second):
        return None
    target = currents[int(second < first)]
    file.evidence.proven.append(f"{target.title} is a target: it is as smooth as only a target is")
    return target


def _is_target(
    name: str,
    block: Block,
    unit: str,
    means: BlockMeans | None,
    arm: Robot | None,
    file: Contents,
    smooth: Block | None,
    currents: list[Block],
) -> bool:
    """Return whether an effort was computed: by its name, without friction, or too smooth."""
    meaning = block.meaning() or ""
    if meaning.startswith("target") or block.stated:
        return meaning.startswith("target")
    if unit != "Nm" or means is None or arm is None:
        return block is smooth
    if meaning in ("actual_torque", "effort") or not arm.is_ur():  # it may sense its torque
        return False
    if _is_smoother(block, currents, smooth):
        file.evidence.proven.append(f"{block.title} is a target: it is as smooth as one")
        return True
    gravity, effort = means.gravity(arm), means.currents[name]
    moving = np.flatnonzero(means.qd.std(axis=0) > MOVES).tolist()
    shares = [_friction(means, effort[:, k], gravity[:, k], k) for k in moving]
    if not shares or float(np.median(shares)) >= MIN_SHARE_EXPLAINED_BY_FRICTION:
        return False
    file.evidence.proven.append(f"{block.title} is a target: it contains no friction")
    return True


def _is_smoother(block: Block, currents: Sequence[Block], target: Block | None) -> bool:
    """Return whether a nameless torque is as smooth, for its size, as no measured current."""
    if target is None or not block.is_nameless():
        return False
    rough = next(current for current in currents if current is not target)
    own, measured = (
        np.nanmedian(roughness(one.rows) / (np.nanstd(one.rows, axis=0) + TINY))
        for one in (block, rough)
    )
    return bool(own < SMOOTHER * measured)


def _friction(means: BlockMeans, effort: Array, gravity: Array, column: int) -> float:
    """Return the share of an effort, without gravity and inertia, that friction explains."""
    columns = np.column_stack([gravity, means.qdd])
    whole = np.column_stack([columns, means.friction(column)])
    without, rest = (size(solved(terms, effort)[1]) for terms in (columns, whole))
    return 1 - (rest / without) ** 2


def solved(columns: Array, values: Array) -> tuple[Array, Array]:
    """Return the coefficients of least squares, and the residuals."""
    solution = np.linalg.lstsq(columns, values, rcond=None)[0]
    return np.asarray(solution), np.asarray(values - columns @ solution)
