"""The frame and the sign of a wrench: those in which it explains the efforts."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations
from typing import NamedTuple

import numpy as np

from ur5lib.checks.block_means import (
    BLOCK_LENGTH,
    SMALLEST_SIZE,
    BlockMeans,
    size,
)
from ur5lib.importing.blocks import ColumnBlock
from ur5lib.importing.contents import TABLE_FORMAT, FileContents
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, link_frames
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

COLUMN_ORDERS = [
    (*axes, *(3 + k for k in axes)) for axes in permutations(range(3))
]  # in order first
COLUMN_ORDERS.append((3, 4, 5, 0, 1, 2))  # moments before forces
SENSOR_STEM = "ft_f"  # this project's own name of a sensor's force
CLEAR_LEAD_OF_FRAME = 6.0  # difference of log-likelihoods of independent samples
CONTACT_FORCE = 10.0  # N; a wrench that changes by more is a contact
CLEAR_WORK = 2.0  # a work of this many standard errors shows who leads
# Efforts that balance a force alone bear this share of it; 0.4 to 0.6 where a hand led.
MIN_BORNE_SHARE = 0.75


class WrenchFrame(NamedTuple):
    """The frame of a wrench. axes: "base" or "flange"; by_arm: whether it is that of the arm on its
    surroundings.
    """

    axes: str
    by_arm: bool

    def is_opposite(self, arm: Robot) -> bool:
        """Return whether a wrench has the sign opposite to that of the channel with these axes."""
        return self.by_arm == (self.axes == "flange" or arm.wrist_sensor)

    def turned(self) -> "WrenchFrame":
        """Return the frame of the wrench with the opposite sign."""
        return self._replace(by_arm=not self.by_arm)


def with_parted_wrench(file: FileContents) -> FileContents:
    """Return a file with force and torque as two blocks, where one of six columns has both."""
    parts = [
        part
        for block in file.blocks
        for part in (_parted(block) if block.meaning() == "wrench" else [block])
    ]
    return replace(file, blocks=parts)


def _parted(wrench: ColumnBlock) -> list[ColumnBlock]:
    return [
        replace(wrench.only(range(k, k + 3)), stated=meaning)
        for k, meaning in ((0, "force"), (3, "torque"))
    ]


def wrench_blocks(file: FileContents, clock: str) -> list[ColumnBlock]:
    """Return the blocks of force and torque on a clock, of force alone, or none without a force."""
    force, torque = (file.meant(meaning, clock) for meaning in ("force", "torque"))
    return [block for block in (force, torque) if block is not None] if force else []


def change(wrench: Sequence[ColumnBlock]) -> float:
    """Return the largest distance [N] of a force from its median."""
    force = wrench[0].rows
    return float(np.nanmax(np.linalg.norm(force - np.nanmedian(force, axis=0), axis=1)))


def frame_of(
    wrench: Sequence[ColumnBlock],
    means: BlockMeans | None,
    values: Array,
    arm: Robot | None,
    file: FileContents,
    doubt: str = "",
) -> WrenchFrame | None:
    """Return the frame and the sign of a wrench, None where neither names nor efforts show it.

    means: with the joints in order and one effort that may prove the frame, None without one;
    values: force and torque (M, 6) [N, Nm] at the blocks; doubt: why the arm may be another one.
    """
    frame, lead = likeliest_frame(means, values, arm) if means and arm else (None, 0.0)
    if wrench[0].stem() == SENSOR_STEM and (frame is None or frame.axes == "flange"):
        alone = "" if frame else ", by its name alone: some drivers write the base's axes"
        for block in wrench:
            sensor = f"a force sensor in the flange's axes{alone}"
            file.account.hold("check" if alone else "assumed", block, "name", sensor)
        return WrenchFrame("flange", by_arm=False)
    if means is None or arm is None or frame is None:
        either = "in the base's frame or the flange's, by the arm or on it: the best two "
        unproven = f"{either}log-likelihoods are {lead:.1f} apart"
        unproven = unproven if means else "no effort beside it tells its frame"
        _leave_out(wrench, f"{unproven}; it changes by up to {change(wrench):.0f} N", file)
        return None
    if len(wrench) == 1 and frame.axes == "base":
        moments = "in the base's frame, in which a force is read only together with its moments"
        remedy = "record these, too, or the force in the flange's axes"
        file.account.exclude(wrench[0], f"{moments}: {remedy}")
        return None
    for block in wrench:
        explains = f"in the {frame.axes}'s frame: it explains the efforts better than in others"
        likelier = f"{explains} (log-likelihood greater by {lead:.3g})"
        if doubt:
            file.account.hold("check", block, "numbers", doubt)
        file.account.hold("proven", block, "numbers", likelier)
    return _by_work(wrench[0], frame, means, values, arm, file)


def _leave_out(wrench: Sequence[ColumnBlock], reason: str, file: FileContents) -> None:
    """Leave a wrench out; the reason in the account has the line of an entry that would add it as a
    sensor.
    """
    named = dict(zip(("ft_f", "ft_t"), (block.names for block in wrench), strict=False))
    channels = ", ".join(f"{name}: [{', '.join(names)}]" for name, names in named.items())
    line = f"`force_sensor: {{channels: {{time: {wrench[0].clock}, {channels}}}}}`"
    is_table = file.format == TABLE_FORMAT
    line = "`ft_fx … ft_tz` for its columns in `columns`" if is_table else line
    for block in wrench:
        reads = f"{reason}; record a push in several postures, or, in the flange's axes, {line}"
        file.account.exclude(block, reads)


def _by_work(
    block: ColumnBlock,
    frame: WrenchFrame,
    means: BlockMeans,
    values: Array,
    arm: Robot,
    file: FileContents,
) -> WrenchFrame:
    """Return a frame with its sign corrected by the work of the force on the arm.

    A hand that leads an arm puts work in. Friction takes up the hand, or drives help it, and then
    efforts may have the sign of the force on the arm. Where they bear it as they bear gravity, a
    force against the motion is one that the arm overcomes.
    """
    work, errors = _work_on_arm(frame, means, values, arm)
    share, error = _borne_share(frame, means, values, arm)
    is_led = share + NORMAL95 * error < MIN_BORNE_SHARE
    actor = "of the arm on its surroundings" if frame.by_arm else "of the surroundings on the arm"
    told = f"the force {actor}, by the efforts, which bear {share:.0%} of it; as such it does "
    told += f"{work:.3g} J on the arm ({errors:.2g} standard errors)"
    if errors <= -CLEAR_WORK and is_led:
        led = f"the other way than {told}: a hand that leads the arm puts work in; check its sign"
        file.account.hold("check", block, "numbers", led)
        return frame.turned()
    if frame.axes == "base" and frame.by_arm and arm.wrist_sensor:
        led = f"it has the sign of actual_TCP_force, as where a hand leads: {told}"
        file.account.hold("check", block, "numbers", led)
        return frame.turned()
    is_doubted = errors <= -CLEAR_WORK
    told += ", as where a hand leads: check its sign" if is_doubted else ""
    file.account.hold("check" if is_doubted else "proven", block, "numbers", told)
    return frame


def likeliest_frame(
    means: BlockMeans, wrench: Array, arm: Robot
) -> tuple[WrenchFrame | None, float]:
    """Return the frame of a wrench (M, 6), None if not proven, and its lead in log-likelihood.

    Efforts increase with the wrench of the arm on its surroundings. The frame is compared with the
    other frames and with exchanged columns.
    """
    gains = {
        (frame, columns): _gain(means, torque, arm)
        for columns in COLUMN_ORDERS
        for frame, torque in _torques(means.q, wrench[:, columns], arm).items()
    }
    best, second = sorted(gains, key=lambda reading: gains[reading], reverse=True)[:2]
    lead = gains[best] - gains[second]
    return (best[0] if lead >= CLEAR_LEAD_OF_FRAME and best[1] == COLUMN_ORDERS[0] else None), lead


def _torques(q: Array, wrench: Array, arm: Robot) -> dict[WrenchFrame, Array]:
    """Return, by possible frame, the joint torques (M, n) [Nm] of a wrench (M, 6)."""
    jacobian, rotation = geometric_jacobian(arm, q), link_frames(arm, q)[0][:, -1]
    turned = np.einsum("nij,nkj->nki", rotation, wrench.reshape(-1, 2, 3)).reshape(-1, 6)
    return {
        WrenchFrame(axes, sign > 0): sign * np.einsum("nij,ni->nj", jacobian, values)
        for axes, values in (("base", wrench), ("flange", turned))
        for sign in (1, -1)
    }


def _gain(means: BlockMeans, torque: Array, arm: Robot) -> float:
    """Return by how much the log-likelihood of the efforts grows when joint torques (M, n) [Nm] are
    added to their model.
    """
    (effort,), gravity, total = means.currents.values(), means.gravity(arm), 0.0
    for joint, measured in enumerate(effort.T):
        terms = [gravity[:, joint], *means.friction(joint).T, *means.qdd.T, np.ones(len(measured))]
        columns = np.column_stack([torque[:, joint], *terms])
        solution = np.linalg.lstsq(columns, measured, rcond=None)[0]
        without = np.linalg.lstsq(columns[:, 1:], measured, rcond=None)[0]
        if solution[0] > 0:
            error = size(measured - columns @ solution)
            error_without = size(measured - columns[:, 1:] @ without)
            total += float(means.log_likelihood(np.array((error / error_without) ** 2)))
    return total


def _work_on_arm(
    frame: WrenchFrame, means: BlockMeans, values: Array, arm: Robot
) -> tuple[float, float]:
    """Return the work of a force on the arm [J], W = ∫ F·v dt, and the same in its standard errors.

    The errors are those of spans taken as independent. Of the force as read and the force less its
    median, as of a sensor that was never zeroed, the work with fewer errors is returned; 0 errors
    if their signs differ.
    """
    force = -values[:, :3] if frame.by_arm else values[:, :3]
    if frame.axes == "flange":
        force = np.einsum("nij,nj->ni", link_frames(arm, means.q)[0][:, -1], force)
    velocity = np.einsum("nij,nj->ni", geometric_jacobian(arm, means.q)[:, :3], means.qd)
    starts = np.arange(0, len(force), round(1 / means.independent))
    works = list[tuple[float, float]]()
    for acting in (force, force - np.median(force, axis=0)):
        spans = BLOCK_LENGTH * np.add.reduceat((acting * velocity).sum(axis=1), starts)
        works.append((float(spans.sum()), float(spans.sum() / size(spans))))
    if works[0][1] * works[1][1] < 0:
        return works[0][0], 0.0
    return min(works, key=lambda work: abs(work[1]))


def _borne_share(
    frame: WrenchFrame, means: BlockMeans, values: Array, arm: Robot
) -> tuple[float, float]:
    """Return the share of a force that the efforts bear, relative to gravity's, and its standard
    error.
    """
    torque, gravity = _torques(means.q, values, arm)[frame], means.gravity(arm)
    force, force_error = _pooled_gain(torque, gravity, means, arm)
    weight, weight_error = _pooled_gain(gravity, torque, means, arm)
    return force / weight, float(np.hypot(force_error, force / weight * weight_error) / weight)


def _pooled_gain(
    torque: Array, beside: Array, means: BlockMeans, arm: Robot
) -> tuple[float, float]:
    """Return the coefficient of a torque (M, n) in the efforts [Nm], one for all joints, and its
    standard error.

    The efforts become torques by the maker's constants; `beside`: another torque (M, n) that is
    fitted, too.
    """
    (effort,), products, squares = means.currents.values(), 0.0, SMALLEST_SIZE
    for joint, constant in enumerate(arm.maker_torque_constants()):
        motion = [*means.friction(joint).T, *means.qdd.T, np.ones(len(effort))]
        explained = np.column_stack([beside[:, joint], *motion])
        pair = np.column_stack([torque[:, joint], effort[:, joint] * constant])
        if np.isfinite(constant):
            cause, held = (pair - explained @ np.linalg.lstsq(explained, pair, rcond=None)[0]).T
            products += float(cause @ held) / size(held) ** 2
            squares += float(cause @ cause) / size(held) ** 2
    independent = len(effort) * means.independent
    return products / squares or SMALLEST_SIZE, float((independent * squares) ** -0.5)
