"""The channels of a file's efforts: currents, torques or targets, by name or else by gravity."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ur5lib.channels import CHANNELS
from ur5lib.checks.arm import torque_constants
from ur5lib.checks.block_means import SMALLEST_SIZE, BlockMeans, combination
from ur5lib.checks.exchanged_channels import MAX_ROUGHNESS_RATIO, roughness
from ur5lib.checks.readings import CLEAR_LEAD, readings, unit_scores, usual_orders
from ur5lib.importing.blocks import JOINTS_OF_UR, ColumnBlock
from ur5lib.importing.contents import FileContents, ImportEvidence
from ur5lib.importing.identity import tells_columns
from ur5lib.importing.spellings import named_unit
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

CURRENT_CHANNEL = "actual_current"
TORQUE_CHANNEL = "actual_current_as_torque"
LESS_GRAVITY = "neither"  # current nor torque: a torque less gravity, as some drivers write
ROUNDING_STEP = 1e-3  # A; URScript gives currents with three decimals
LARGEST_MULTIPLE_RANGE = (100, 100_000)  # multiples of a rounded current's step that it reaches
UNIT_WORDS = {"A": "A", "mA": "mA", "Nm": "Nm", LESS_GRAVITY: "Nm less gravity"}
CHANNELS_BY_UNIT = {  # by unit, and whether it is a target
    ("A", False): CURRENT_CHANNEL,
    ("A", True): "target_current",
    ("Nm", False): TORQUE_CHANNEL,
    ("Nm", True): "target_moment",
    (LESS_GRAVITY, False): "actual_torque_less_gravity",
}
UNITS_BY_CHANNEL = {
    channel: unit for (unit, _), channel in CHANNELS_BY_UNIT.items() if unit != LESS_GRAVITY
}
UNITS_BY_CHANNEL |= {"actual_torque": "Nm"}
EFFORT_MEANINGS = ("effort", *UNITS_BY_CHANNEL)


def as_amperes(block: ColumnBlock, evidence: ImportEvidence) -> ColumnBlock:
    """Return a block in amperes if its columns are rounded currents times constants of a driver.

    Such columns are whole multiples of steps, none of which is a power of ten.
    """
    steps = np.array([_step(np.abs(column)) for column in block.rows.T])
    if len(steps) != JOINTS_OF_UR:
        return block
    decimal = np.abs(np.log10(steps) - np.round(np.log10(steps))) < 1e-4
    if np.isnan(steps).any() or decimal.any():
        return block
    constants = ", ".join(f"{step / ROUNDING_STEP:.4g}" for step in steps)
    evidence.proven.append(
        f"{block.title} is a current rounded to {1e3 * ROUNDING_STEP:.0f} mA, multiplied by "
        f"constants (joint by joint {constants}): it holds whole multiples of these alone"
    )
    return block.scaled(ROUNDING_STEP / steps)


def _step(sizes: Array) -> float:
    """Return the number of which sizes (N,) are whole multiples, NaN if there is none."""
    levels = np.unique(sizes[np.isfinite(sizes)])
    gaps = np.diff(levels, prepend=0.0)
    for parts in (1, 2, 3):
        step = gaps[gaps > 1e-6 * levels.max(initial=0.0)].min(initial=np.inf) / parts
        counts = np.round(levels / step)
        if counts.max(initial=0) == 0:
            return np.nan
        step = levels @ counts / (counts @ counts)
        if np.abs(levels - step * counts).max() < 0.01 * step:  # not its half or third as well
            return (
                float(step)
                if LARGEST_MULTIPLE_RANGE[0] < counts.max() < LARGEST_MULTIPLE_RANGE[1]
                else np.nan
            )
    return np.nan


def is_opposite(means: BlockMeans, name: str, arms: Sequence[Robot]) -> bool:
    """Return whether an effort has the opposite sign: with it, friction would drive the joints.

    Only where gravity agrees: it explains the turned effort far better. Joints that sense their
    torque have no friction; turned, these must hold the arm's gravity.
    """
    effort, brakes = means.currents[name], []
    for column in range(effort.shape[1]):
        friction, speed = means.friction(column), np.abs(means.qd[:, column]).mean()
        terms = np.column_stack([friction, means.qdd, np.ones(len(effort))])
        force, error = combination(terms, effort[:, column], [1.0, float(speed)])
        brakes.append(force / max(error, SMALLEST_SIZE))
    ways = [replace(means, currents={name: sign * effort}) for sign in (1, -1)]
    fits = [torque_constants(ways[1], arm, name) for arm in arms if arm.senses_torque()]
    if sum(brakes) >= 0 and not any(fit.ratio and not fit.foreign() for fit in fits):
        return False
    orders = usual_orders(effort.shape[1])
    as_read, turned = (readings(way, arms, orders)[0].score for way in ways)
    return turned - as_read > CLEAR_LEAD


def name_efforts(
    blocks: Mapping[str, ColumnBlock],
    means: BlockMeans | None,
    arm: Robot | None,
    file: FileContents,
) -> dict[str, ColumnBlock]:
    """Return the efforts by channel, in SI units, without those that neither name nor unit tells.

    blocks: by their names in `means`, which have the joints in order, None without a motion.
    """
    telling = arm if arm and tells_columns(arm) else None
    scores = {
        name: unit_scores(means, name, telling) if means and telling else {} for name in blocks
    }
    units = {name: _unit(block, scores[name], file) for name, block in blocks.items()}
    targets = _targets([blocks[name] for name, unit in units.items() if unit], file)
    channels: dict[str, ColumnBlock] = {}
    for name, block in blocks.items():
        unit = units[name]
        if unit is None:
            continue
        target = any(block is other for other in targets)
        channel = CHANNELS_BY_UNIT[unit.replace("mA", "A"), target and unit != LESS_GRAVITY]
        if channel == TORQUE_CHANNEL and arm and (arm.senses_torque() or not arm.is_ur()):
            channel = "actual_torque"
        if channel == "target_moment" and arm and not arm.is_ur():
            file.evidence.exclude(block, "a torque that the controller of another arm commanded")
        elif channel in channels:
            file.evidence.exclude(block, f"it may be {channel}, as {channels[channel].title}")
        else:
            channels[channel] = block.scaled(1e-3) if unit == "mA" else block
    return channels


def _unit(block: ColumnBlock, scores: Mapping[str, float], file: FileContents) -> str | None:
    """Return the unit, A, mA, Nm or LESS_GRAVITY: as stated, named, or shown; None if unknown.

    scores: log-likelihoods of the units by gravity, none without a motion.
    """
    evidence, meaning = file.evidence, block.meaning() or ""
    given, spelled = file.stated.units.get(meaning), named_unit(block.names[0])
    if given in UNIT_WORDS:
        return given
    named = spelled if spelled in UNIT_WORDS else UNITS_BY_CHANNEL.get(meaning)
    peak = np.nanmedian(np.abs(block.rows).max(axis=1))
    if named == "A" and peak > CHANNELS[CURRENT_CHANNEL].bound:
        evidence.proven.append(f"{block.title} in mA: no arm has as many amperes")
        return "mA"
    best, rival, *_ = [*sorted(scores, key=lambda unit: -scores[unit]), "", ""]
    lead = scores[best] - scores[rival] if scores else 0.0
    likelier = f"gravity tells {UNIT_WORDS.get(best)} (log-likelihood greater by {lead:.3g})"
    if lead <= CLEAR_LEAD or (best == LESS_GRAVITY and not named and meaning != "effort"):
        if named is None:
            evidence.exclude(
                block,
                "nothing tells its unit; record more postures, or name it with --columns and "
                "--unit",
            )
        else:
            evidence.assumed.append(f"{block.title} in {named}, by its name")
        return named
    unclear = meaning in ("effort", TORQUE_CHANNEL) and spelled not in UNIT_WORDS
    if best == LESS_GRAVITY and unclear:
        evidence.check.append(
            f"{block.title} in Nm, less gravity, which does not explain it as it explains every "
            "current and motor torque; the gravity of the arm is added again"
        )
        return LESS_GRAVITY
    if named in (None, best):
        evidence.proven.append(f"{block.title} in {best}: {likelier}")
        return best
    if best == "mA" and named == "A" and spelled != "A":
        evidence.check.append(f"{block.title} in mA, though RTDE's currents are in A: {likelier}")
        return best
    evidence.check.append(f"{block.title} in {named}, by its name; {likelier}")
    return named


def _targets(efforts: Sequence[ColumnBlock], file: FileContents) -> list[ColumnBlock]:
    """Return the efforts that were computed: by their names, or nameless and without noise."""
    named = [effort for effort in efforts if (effort.meaning() or "").startswith("target")]
    nameless = [effort for effort in efforts if effort.is_nameless()]
    rough = [float(np.nanmedian(roughness(effort.rows) / _spread(effort))) for effort in nameless]
    smooth = [
        effort
        for effort, roughness_of_effort in zip(nameless, rough, strict=True)
        if roughness_of_effort < MAX_ROUGHNESS_RATIO * max(rough)
    ]
    file.evidence.proven.extend(f"{o.title} is a target: it is as smooth as one" for o in smooth)
    return [*named, *smooth]


def _spread(block: ColumnBlock) -> Array:
    return np.asarray(np.nanstd(block.rows, axis=0) + SMALLEST_SIZE)
