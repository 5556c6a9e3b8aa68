"""Efforts that are torques in no unit alone: of the motors' side of gears, and following errors."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5lib.checks.arm import torque_constants
from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.readings import Order, usual_orders
from ur5lib.importing.account import Account
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.motion import ImportedMotion
from ur5lib.importing.spellings import TORQUES, is_of_motors, named_unit
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

MAX_MISFIT = 1.2  # of a torque behind the gears to gravity's
MIN_BEARING_JOINTS = 2  # this many show a gear together
MIN_FOLLOWING_JOINTS = 3  # that lag by one time
MIN_SHARE_FOLLOWED = 0.9  # of an error's squares
MAX_LAG_RATIO = 1.15  # of the longest to the shortest lag of a joint


def following_error(block: ColumnBlock, moving: ImportedMotion) -> str:
    """Return in words why an effort is a following error, "" if nothing shows it.

    It is one factor times target less position, or times the velocities, if a controller lags by
    one time on all joints. No torque of motors is one, since its gravity depends on the posture.
    """
    if named_unit(block.names[0]) or not np.isfinite(np.diff(moving.time)).any():
        return ""
    motion, target, position = moving.in_si(), moving.blocks.get("target_q"), moving.position
    if target is not None and (factor := _common_factor(block.rows, target.rows - position.rows)):
        times = "" if np.isclose(abs(factor), 1, atol=0.02) else f"{abs(factor):.3g} times "
        less = f"{times}the difference of {target.title} and {position.title}"
        return f"no torque, but a following error: {less}"
    step = float(np.nanmedian(np.diff(moving.time))) or 1.0
    qd = motion.get("actual_qd", np.gradient(motion["actual_q"], axis=0) / step)
    if lag := _common_factor(block.rows, qd):
        lags = f"all joints by {abs(lag):.2g} s times their velocity, in every posture"
        return f"no torque, for it follows no gravity; as a following error, it lags behind {lags}"
    return ""


def _common_factor(effort: Array, quantity: Array) -> float:
    """Return the factor, one for all joints, by which a quantity (N, n) explains efforts (N, n), 0
    if none does.
    """
    whole = np.isfinite(effort).all(axis=1) & np.isfinite(quantity).all(axis=1)
    effort, quantity = effort[whole], quantity[whole]
    moves = np.any(effort, axis=0) & np.any(quantity, axis=0)
    if np.count_nonzero(moves) < MIN_FOLLOWING_JOINTS:
        return 0.0
    effort, quantity = effort[:, moves], quantity[:, moves]
    factors = (effort * quantity).sum(axis=0) / (quantity**2).sum(axis=0)
    missed = ((effort - factors * quantity) ** 2).sum(axis=0) / (effort**2).sum(axis=0)
    sizes = factors * np.sign(factors[0])
    alike = sizes.min() > 0 and sizes.max() < MAX_LAG_RATIO * sizes.min()
    followed = (missed < 1 - MIN_SHARE_FOLLOWED).all()
    return float(np.median(factors)) if alike and followed else 0.0


def behind_gears(
    name: str, block: ColumnBlock, means: BlockMeans, arms: Sequence[Robot], account: Account
) -> Array | None:
    """Return the gear ratios (n,) to multiply an effort's columns by, None if it is not a torque of
    the motors' side.

    It is one if gravity shows an arm's own torque on several joints with the ratios, and no arm's
    without them.
    """
    geared = [arm for arm in arms if min(arm.gear_ratios()) > MAX_MISFIT]
    named = block.meaning() in TORQUES and is_of_motors(block.stem())
    pairs = [(arm, order) for order in usual_orders(block.rows.shape[1]) for arm in geared]
    if not named or not pairs or any(_shares(means, name, *pair, geared=False) for pair in pairs):
        return None
    told = [(pair, shares) for pair in pairs if (shares := _shares(means, name, *pair))]
    if not told:
        unknown = "of the motors' side by its name: multiply it by the gear ratios"
        account.hold("check", block, "name", unknown)
        return None
    (arm, order), shares = min(told, key=lambda one: np.abs(np.log([*one[1].values()])).max())
    gears = np.array(arm.gear_ratios())
    ratios = ", ".join(f"{ratio:g}" for ratio in dict.fromkeys(gears))
    each = ", ".join(f"{share:.3g}" for share in shares.values())
    joints = ", ".join(str(joint + 1) for joint in shares)
    times = f"it is then {each} times the torque of gravity of {arm.name} on joints {joints}"
    before = f"of the motors' side by its name, and multiplied by the gear ratio, {ratios}: {times}"
    account.hold("check", block, "numbers", before)
    return gears[np.argsort(order)]


def _shares(
    means: BlockMeans, name: str, arm: Robot, order: Order, geared: bool = True
) -> dict[int, float]:
    """Return, by joint that bears gravity, the ratio of an effort (times the gear ratios if
    `geared`) to gravity's torque; empty if they are too few, or one is far from 1.
    """
    ordered = means.part(columns=order)
    effort = ordered.currents[name] * (np.array(arm.gear_ratios()) if geared else 1.0)
    fit = torque_constants(replace(ordered, currents={name: effort}), arm, name)
    shares = {joint: 1 / (ratio * fit.known[joint]) for joint, ratio in fit.ratio.items()}
    near = all(1 / MAX_MISFIT < share < MAX_MISFIT for share in shares.values())
    return shares if near and len(shares) >= MIN_BEARING_JOINTS else {}
