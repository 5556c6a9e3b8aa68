"""The channels of a file's efforts: currents, torques or targets, by name or else by gravity."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ur5lib.channels import CHANNELS as CHANNELS_OF_RTDE
from ur5lib.importing.blocks import JOINTS_OF_UR, Block
from ur5lib.importing.contents import Contents, Evidence
from ur5lib.importing.spellings import named_unit
from ur5lib.recordings.arm_checks import constants
from ur5lib.recordings.block_means import TINY, BlockMeans, combination
from ur5lib.recordings.readings import CLEAR_LEAD, readings, unit_scores, usual_orders
from ur5lib.recordings.stop_signs import SMOOTHER, roughness
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

CURRENT = "actual_current"
MEASURED_TORQUE = "actual_current_as_torque"
FREE = "neither"  # current nor torque: a torque less gravity, as some drivers write
ROUNDED = 1e-3  # A; URScript gives currents with three decimals
COUNTED = (100, 100_000)  # multiples of a rounded current's step that it reaches
UNITS = {"A": "A", "mA": "mA", "Nm": "Nm", FREE: "Nm less gravity"}
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
    if len(steps) != JOINTS_OF_UR:
        return block
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
        if counts.max(initial=0) == 0:
            return np.nan
        step = levels @ counts / (counts @ counts)
        if np.abs(levels - step * counts).max() < 0.01 * step:  # not its half or third as well
            return float(step) if COUNTED[0] < counts.max() < COUNTED[1] else np.nan
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
        brakes.append(force / max(error, TINY))
    ways = [replace(means, currents={name: sign * effort}) for sign in (1, -1)]
    found = [constants(ways[1], arm, name) for arm in arms if arm.senses_torque()]
    if sum(brakes) >= 0 and not any(one.ratio and not one.off() for one in found):
        return False
    orders = usual_orders(effort.shape[1])
    as_read, turned = (readings(way, arms, orders)[0].score for way in ways)
    return turned - as_read > CLEAR_LEAD


def name_efforts(
    blocks: Mapping[str, Block], means: BlockMeans | None, arm: Robot | None, file: Contents
) -> dict[str, Block]:
    """Return the efforts by channel, in SI units, without those that neither name nor unit tells.

    blocks: by their names in `means`, which have the joints in order, None without a motion.
    """
    scores = {name: unit_scores(means, name, arm) if means and arm else {} for name in blocks}
    units = {name: _unit(block, scores[name], file) for name, block in blocks.items()}
    targets = _targets([blocks[name] for name, unit in units.items() if unit], file)
    channels: dict[str, Block] = {}
    for name, block in blocks.items():
        unit = units[name]
        if unit is None:
            continue
        target = any(block is one for one in targets)
        channel = CHANNELS[unit.replace("mA", "A"), target and unit != FREE]
        if channel == MEASURED_TORQUE and arm and (arm.senses_torque() or not arm.is_ur()):
            channel = "actual_torque"
        if channel == "target_moment" and arm and not arm.is_ur():
            file.evidence.exclude(block, "a torque that the controller of another arm commanded")
        elif channel in channels:
            file.evidence.exclude(block, f"it may be {channel}, as {channels[channel].title}")
        else:
            channels[channel] = block.scaled(1e-3) if unit == "mA" else block
    return channels


def _unit(block: Block, scores: Mapping[str, float], file: Contents) -> str | None:
    """Return the unit, A, mA, Nm or FREE: as told, named, or shown; None where nothing tells it.

    scores: log-likelihoods of the units by gravity, none without a motion.
    """
    evidence, meaning = file.evidence, block.meaning() or ""
    told, stated = file.stated.units.get(meaning), named_unit(block.names[0])
    if told in UNITS:
        return told
    named = stated if stated in UNITS else NAMED.get(meaning)
    peak = np.nanmedian(np.abs(block.rows).max(axis=1))
    if named == "A" and peak > CHANNELS_OF_RTDE[CURRENT].bound:
        evidence.proven.append(f"{block.title} in mA: no arm has as many amperes")
        return "mA"
    best, rival, *_ = [*sorted(scores, key=lambda unit: -scores[unit]), "", ""]
    lead = scores[best] - scores[rival] if scores else 0.0
    likelier = f"gravity tells {UNITS.get(best)} (log-likelihood greater by {lead:.3g})"
    if lead <= CLEAR_LEAD or (best == FREE and not named and meaning != "effort"):
        if named is None:
            evidence.exclude(
                block,
                "nothing tells its unit; record more postures, or name it with --columns and "
                "--unit",
            )
        else:
            evidence.assumed.append(f"{block.title} in {named}, by its name")
        return named
    unclear = meaning in ("effort", MEASURED_TORQUE) and stated not in UNITS
    if best == FREE and unclear:
        evidence.check.append(
            f"{block.title} in Nm, less gravity, which does not explain it as it explains every "
            "current and motor torque; the gravity of the arm is added again"
        )
        return FREE
    if named in (None, best):
        evidence.proven.append(f"{block.title} in {best}: {likelier}")
        return best
    if best == "mA" and named == "A" and stated != "A":
        evidence.check.append(f"{block.title} in mA, though RTDE's currents are in A: {likelier}")
        return best
    evidence.check.append(f"{block.title} in {named}, by its name; {likelier}")
    return named


def _targets(efforts: Sequence[Block], file: Contents) -> list[Block]:
    """Return the efforts that were computed: by their names, or nameless and without noise."""
    named = [one for one in efforts if (one.meaning() or "").startswith("target")]
    nameless = [one for one in efforts if one.is_nameless()]
    rough = [float(np.nanmedian(roughness(one.rows) / _spread(one))) for one in nameless]
    smooth = [one for one, own in zip(nameless, rough, strict=True) if own < SMOOTHER * max(rough)]
    file.evidence.proven.extend(f"{o.title} is a target: it is as smooth as one" for o in smooth)
    return [*named, *smooth]


def _spread(block: Block) -> Array:
    return np.asarray(np.nanstd(block.rows, axis=0) + TINY)
