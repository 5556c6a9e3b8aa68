"""The channels of a file's efforts, and the frame of a wrench that explains them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np

from ur5lib.errors import InputError
from ur5lib.importing.blocks import Block
from ur5lib.importing.contents import Evidence
from ur5lib.recordings.block_means import BLOCK, INDEPENDENT, TINY, BlockMeans, combination, size
from ur5lib.recordings.checks import MOVES
from ur5lib.recordings.readings import SURE, likeliest, own_order, slope, unit_scores
from ur5lib.recordings.stop_signs import SMOOTHER, roughness
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, link_frames
from ur5lib.timeseries.arrays import Array

FRICTION = 0.3  # least share of a measured effort's residual that friction explains
MEASURED_TORQUE = "actual_current_as_torque"
FREE = "neither"  # current nor torque: a torque less gravity, as some drivers write
UNITS = {"A": "A", "mA": "mA", "Nm": "Nm", FREE: "Nm less gravity"}
MILLIAMPERES = re.compile(r"(^|[^A-Za-z])mA([^A-Za-z]|$)")
ROUNDED = 1e-3  # A; URScript gives currents with three decimals
COUNTED = (100, 100_000)  # multiples of a rounded current's step that it reaches
CHANNELS = {  # by unit, and whether it is a target
    ("A", False): "actual_current",
    ("A", True): "target_current",
    ("Nm", False): "actual_current_as_torque",
    ("Nm", True): "target_moment",
    (FREE, False): "actual_torque_less_gravity",
}
NAMED = {channel: unit for (unit, _), channel in CHANNELS.items() if unit != FREE}
EXCHANGED = [(*axes, *(3 + k for k in axes)) for axes in permutations(range(3))]  # in order first
EXCHANGED.append((3, 4, 5, 0, 1, 2))  # moments before forces
SURE_FRAME = 6.0  # difference of log-likelihoods of independent samples that proves a frame


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

    Only where gravity agrees: it explains the turned effort far better.
    """
    effort = means.currents[name]
    brakes = []
    for column in range(6):
        friction, speed = means.friction(column), np.abs(means.qd[:, column]).mean()
        terms = np.column_stack([friction, means.qdd, np.ones(len(effort))])
        force, error = combination(terms, effort[:, column], [1.0, float(speed)])
        brakes.append(force / max(error, TINY))
    if sum(brakes) >= 0:
        return False
    ways = [replace(means, currents={name: sign * effort}) for sign in (1, -1)]
    as_read, turned = (likeliest(way, arms)[0].score for way in ways)
    return turned - as_read > SURE


def name_efforts(
    blocks: Mapping[str, Block], means: BlockMeans, arm: Robot, evidence: Evidence
) -> dict[str, Block]:
    """Return the efforts by channel, without those whose unit gravity does not determine.

    blocks: by their names in `means`, which have the joints in order.
    """
    units = {name: _unit(name, block, means, arm, evidence) for name, block in blocks.items()}
    currents = [blocks[name] for name, unit in units.items() if unit in ("A", "mA")]
    smooth = _smoothest(currents, evidence)
    for name, unit in units.items():
        if unit == FREE:
            evidence.assumed.append(f"{blocks[name].title} has the joints' order of the positions")
        elif unit is not None:
            _expect_order(name, blocks[name], means, arm, evidence)
    channels: dict[str, Block] = {}
    for name, block in blocks.items():
        unit = units[name]
        if unit is None:
            continue
        free = unit == "Nm" and _is_frictionless(name, block, means, arm, evidence)
        if unit == "Nm" and not free and _is_smoother(block, currents, smooth):
            evidence.proven.append(
                f"{block.title} is a target: it is as smooth as only a target is"
            )
            free = True
        meaning = block.meaning() or ""
        target = block is smooth or free if block.is_nameless() else meaning.startswith("target")
        target |= free and meaning == MEASURED_TORQUE
        target = target and unit != FREE
        channel = CHANNELS[unit.replace("mA", "A"), target]
        if channel in channels:
            evidence.ambiguous.append(
                f"{block.title} may be {channel}, as {channels[channel].title}; left out, name it"
            )
        else:
            channels[channel] = block.scaled(np.full(6, 1e-3)) if unit == "mA" else block
    return channels


def _unit(name: str, block: Block, means: BlockMeans, arm: Robot, evidence: Evidence) -> str | None:
    """Return the unit, A, mA, Nm or FREE, None where neither gravity nor a name determines it."""
    scores = unit_scores(means, name, arm)
    best, rival = sorted(scores, key=lambda unit: -scores[unit])[:2]
    joint = int(np.argmax((means.gravity(arm) ** 2).mean(axis=0)))
    per_torque = slope(means, name, arm, joint)
    ratio = f"gravity on joint {joint + 1} is {1 / (per_torque or np.inf):.3g} Nm per unit of it"
    ratio = "gravity does not change" if np.isnan(per_torque) else ratio
    sure, named = scores[best] - scores[rival] > SURE, NAMED.get(block.meaning() or "")
    named = "mA" if named == "A" and MILLIAMPERES.search(block.names[0]) else named
    if sure and best == FREE and block.meaning() in ("effort", "actual_current_as_torque"):
        evidence.assumed.append(
            f"{block.title} in Nm, less gravity, which does not explain it as it explains every "
            "current and motor torque; the gravity of the arm is added again"
        )
        return FREE
    if not sure and named and scores[best] - scores[named] < SURE:
        evidence.assumed.append(f"{block.title} in {named}, by its name")
        return named
    if best == FREE or not sure:
        evidence.ambiguous.append(
            f"{block.title}: its unit is {UNITS[best]} or {UNITS[rival]} ({ratio}); left out: "
            "record more postures, or import it with a recording of the same columns that has them"
        )
        return None
    evidence.proven.append(f"{block.title} in {best}: {ratio}")
    return best


def _expect_order(
    name: str, block: Block, means: BlockMeans, arm: Robot, evidence: Evidence
) -> None:
    """Raise InputError where the joints of an effort have another order than the positions'."""
    margins = [own_order(replace(means, offset=may), name, arm) for may in (False, True)]
    if max(margins) < -SURE:
        raise InputError(
            f"{block.title}: its joints are in another order than those of the positions, or are "
            "those of another arm: gravity and friction explain it far better so; bring both into "
            "one order, and give each arm a file"
        )
    if min(margins) < SURE:
        evidence.assumed.append(f"{block.title} has the joints' order of the positions")
    else:
        evidence.proven.append(f"{block.title} has the joints' order of the positions")


def _smoothest(currents: list[Block], evidence: Evidence) -> Block | None:
    """Return which of two currents is the target: the one without noise."""
    if len(currents) != 2 or not all(block.is_nameless() for block in currents):
        return None
    first, second = (np.nanmedian(roughness(block.rows)) for block in currents)
    if max(first, second) * SMOOTHER < min(first, second):
        return None
    target = currents[int(second < first)]
    evidence.proven.append(f"{target.title} is a target: it is as smooth as only a target is")
    return target


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


def _is_frictionless(
    name: str, block: Block, means: BlockMeans, arm: Robot, evidence: Evidence
) -> bool:
    """Return whether a torque contains no friction: then it was computed, not measured."""
    gravity, effort = means.gravity(arm), means.currents[name]
    moving = np.flatnonzero(means.qd.std(axis=0) > MOVES).tolist()
    shares = [_friction(means, effort[:, k], gravity[:, k], k) for k in moving]
    if not shares or float(np.median(shares)) >= FRICTION:
        return False
    if block.is_nameless() or block.meaning() == MEASURED_TORQUE:
        evidence.proven.append(f"{block.title} is a target: it contains no friction")
    return True


def _friction(means: BlockMeans, effort: Array, gravity: Array, column: int) -> float:
    """Return the share of an effort, without gravity and inertia, that friction explains."""
    columns = np.column_stack([gravity, means.qdd])
    whole = np.column_stack([columns, means.friction(column)])
    without, rest = (size(_solved(terms, effort)[1]) for terms in (columns, whole))
    return 1 - (rest / without) ** 2


class Frame(NamedTuple):
    """Axes of a wrench (base or flange), and whether it is that of the arm on its surroundings."""

    axes: str
    by_arm: bool


def wrench_frame(
    means: BlockMeans, effort: str, wrench: Array, arm: Robot
) -> tuple[Frame | None, float]:
    """Return the frame of a wrench, None if not proven, and its lead in log-likelihood.

    means: with the joints in order; wrench: force and torque (M, 6) [N, Nm] at the blocks. Efforts
    increase with the wrench of the arm on its surroundings, and decrease with the wrench of the
    surroundings on the arm. Rivals are the other frames, and exchanged columns.
    """
    gains = {
        (frame, columns): _gain(means, effort, torque, arm)
        for columns in EXCHANGED
        for frame, torque in _torques(means.q, wrench[:, columns], arm).items()
    }
    best, second = sorted(gains, key=lambda reading: gains[reading], reverse=True)[:2]
    lead = gains[best] - gains[second]
    return (best[0] if lead >= SURE_FRAME and best[1] == EXCHANGED[0] else None), lead


def _torques(q: Array, wrench: Array, arm: Robot) -> dict[Frame, Array]:
    """Return the joint torques (M, 6) [Nm] of a wrench (M, 6) by its frame."""
    jacobian, rotation = geometric_jacobian(arm, q), link_frames(arm, q)[0][:, 6]
    halves = np.einsum("nij,nkj->nki", rotation, wrench.reshape(-1, 2, 3))
    torques: dict[Frame, Array] = {}
    for name, values in (("base", wrench), ("flange", halves.reshape(-1, 6))):
        torque = np.einsum("nij,ni->nj", jacobian, values)
        torques |= {Frame(name, True): torque, Frame(name, False): -torque}
    return torques


def _gain(means: BlockMeans, effort: str, torque: Array, arm: Robot) -> float:
    """Return the log-likelihood that torques (M, 6) [Nm] add to a model of the efforts."""
    gravity, total = means.gravity(arm), 0.0
    for joint, measured in enumerate(means.currents[effort].T):
        terms = [gravity[:, joint], *means.friction(joint).T, *means.qdd.T, np.ones(len(measured))]
        without = _solved(np.column_stack(terms), measured)[1]
        solution, left = _solved(np.column_stack([*terms, torque[:, joint]]), measured)
        if solution[-1] > 0:
            total += _independent(left) * np.log(size(without) / size(left))
    return float(total)


def _independent(error: Array) -> float:
    """Return the number of independent samples in correlated errors (M,), by an AR(1)."""
    rho = float(np.clip(error[1:] @ error[:-1] / size(error) ** 2, 0.0, 1.0))
    return len(error) * min(BLOCK / INDEPENDENT, (1 - rho) / (1 + rho))


def _solved(columns: Any, values: Any) -> tuple[Array, Array]:
    """Return the coefficients of least squares, and the residuals."""
    solution = np.linalg.lstsq(columns, values, rcond=None)[0]
    return solution, np.asarray(values - columns @ solution)
