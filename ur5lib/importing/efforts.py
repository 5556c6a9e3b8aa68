"""Which channels a file's efforts are: currents or torques, measured or targets."""

from collections.abc import Mapping

import numpy as np

from ur5lib.errors import InputError
from ur5lib.importing.account import Account
from ur5lib.importing.blocks import Block
from ur5lib.recordings.block_means import BlockMeans, size
from ur5lib.recordings.exchanged import SMOOTHER, roughness
from ur5lib.recordings.readings import SURE, Order, own_order, slopes, unit_scores
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.timeseries.arrays import Array

FRICTION = 0.3  # share of a measured effort's residual that friction explains at least
UNITS = {"A": "A", "Nm": "Nm", "neither": "a torque from which a driver took gravity"}
CHANNELS = {  # by unit, and whether it is a target
    ("A", False): "actual_current",
    ("A", True): "target_current",
    ("Nm", False): "actual_current_as_torque",
    ("Nm", True): "target_moment",
}


def name_efforts(
    blocks: Mapping[str, Block], means: BlockMeans, arm: Robot, order: Order, account: Account
) -> dict[str, Block]:
    """Return the efforts by channel: those of which gravity tells the unit.

    blocks: by their names in `means`.
    """
    units = {name: _unit(name, block, means, arm, order, account) for name, block in blocks.items()}
    currents = [blocks[name] for name, unit in units.items() if unit == "A"]
    smooth = _smoothest(currents, account)
    for name, unit in units.items():
        if unit is not None:
            _expect_order(name, blocks[name], means, arm, order, account)
    found: dict[str, Block] = {}
    for name, block in blocks.items():
        unit = units[name]
        if unit is None:
            continue
        free = unit == "Nm" and _is_frictionless(name, means, order, arm, block, account)
        target = block is smooth or free if block.is_nameless() else block.is_target()
        channel = CHANNELS[unit, target]
        if channel in found:
            account.ambiguous.append(
                f"{block.title} may be {channel}, as {found[channel].title}; left out, name it"
            )
        else:
            found[channel] = block
    return found


def _unit(
    name: str, block: Block, means: BlockMeans, arm: Robot, order: Order, account: Account
) -> str | None:
    """Return A or Nm, None where gravity does not tell."""
    scores = unit_scores(means, name, arm, order)
    best, rival = sorted(scores, key=lambda unit: -scores[unit])[:2]
    gravity = gravity_torque(arm, arm.chosen_model, means.q[:, order])
    joint = int(np.argmax((gravity**2).mean(axis=0)))
    slope = slopes(means, name, arm, order)[joint]
    ratio = f"gravity on joint {joint + 1} is {1 / (slope or np.inf):.3g} Nm per unit of it"
    if best == "neither" or scores[best] - scores[rival] < SURE:
        account.ambiguous.append(
            f"{block.title}: its unit, {UNITS[best]} or {UNITS[rival]} ({ratio}); left out: record "
            "currents, or more postures"
        )
        return None
    account.proven.append(f"{block.title} in {best}: {ratio}")
    return best


def _expect_order(
    name: str, block: Block, means: BlockMeans, arm: Robot, order: Order, account: Account
) -> None:
    """Raise InputError where an effort's joints are in another order than the positions'."""
    margin = own_order(means, name, arm, order)
    if margin < -SURE:
        raise InputError(
            f"{block.title}: its joints are in another order than those of the positions: so "
            "gravity and friction explain it better by far; bring both into one order"
        )
    if margin < SURE:
        account.assumed.append(f"{block.title} has the joints' order of the positions")
    else:
        account.proven.append(f"{block.title} has the joints' order of the positions")


def _smoothest(currents: list[Block], account: Account) -> Block | None:
    """Return which of two currents is the target: it holds no noise."""
    if len(currents) != 2 or not all(block.is_nameless() for block in currents):
        return None
    first, second = (np.nanmedian(roughness(block.rows)) for block in currents)
    if max(first, second) * SMOOTHER < min(first, second):
        return None
    target = currents[int(second < first)]
    account.proven.append(f"{target.title} is a target: it is as smooth as only a target is")
    return target


def _is_frictionless(
    name: str, means: BlockMeans, order: Order, arm: Robot, block: Block, account: Account
) -> bool:
    """Return whether a torque holds no friction: then it is computed, not measured."""
    gravity = gravity_torque(arm, arm.chosen_model, means.q[:, order])
    effort = means.currents[name]
    shares = [_friction(means, effort[:, k], gravity[:, j], k) for j, k in enumerate(order)]
    if float(np.median(shares)) >= FRICTION:
        return False
    if block.is_nameless():
        account.proven.append(f"{block.title} is a target: it holds no friction")
    return True


def _friction(means: BlockMeans, effort: Array, gravity: Array, column: int) -> float:
    """Return the share of an effort, without gravity and inertia, that friction explains."""
    columns = np.column_stack([gravity, means.qdd])
    without, whole = (
        size(effort - every @ np.linalg.lstsq(every, effort, rcond=None)[0])
        for every in (columns, np.column_stack([columns, means.friction(column)]))
    )
    return 1 - (whole / without) ** 2
