"""The frame and the sign of a wrench: those in which it explains the efforts."""

from collections.abc import Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np

from ur5lib.importing.blocks import Block
from ur5lib.importing.contents import Contents
from ur5lib.importing.efforts import solved
from ur5lib.recordings.block_means import BLOCK, INDEPENDENT, BlockMeans, size
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, link_frames
from ur5lib.timeseries.arrays import Array

EXCHANGED = [(*axes, *(3 + k for k in axes)) for axes in permutations(range(3))]  # in order first
EXCHANGED.append((3, 4, 5, 0, 1, 2))  # moments before forces
CLEAR_LEAD_OF_FRAME = 6.0  # difference of log-likelihoods of independent samples
CONTACT_FORCE = 10.0  # N; a wrench that changes by more is a contact
MOVING = 0.01  # m/s, of the flange
ONE_SIDED = 0.67  # share of the moving time in which a force acts along the motion, or against it


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
    return (best[0] if lead >= CLEAR_LEAD_OF_FRAME and best[1] == EXCHANGED[0] else None), lead


def _torques(q: Array, wrench: Array, arm: Robot) -> dict[Frame, Array]:
    """Return the joint torques (M, 6) [Nm] of a wrench (M, 6) by its frame."""
    jacobian, rotation = geometric_jacobian(arm, q), link_frames(arm, q)[0][:, -1]
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
        without = solved(np.column_stack(terms), measured)[1]
        solution, left = solved(np.column_stack([*terms, torque[:, joint]]), measured)
        if solution[-1] > 0:
            total += _independent(left) * np.log(size(without) / size(left))
    return float(total)


def _independent(error: Array) -> float:
    """Return the number of independent samples in correlated errors (M,), by an AR(1)."""
    rho = float(np.clip(error[1:] @ error[:-1] / size(error) ** 2, 0.0, 1.0))
    return len(error) * min(BLOCK / INDEPENDENT, (1 - rho) / (1 + rho))


def wrench_blocks(file: Contents, clock: str) -> list[Block]:
    """Return the blocks of force and torque, that of a force alone, or none."""
    whole = file.meant("wrench", clock)
    if whole is not None and len(whole.names) == 6:
        parts = [(whole.names[k : k + 3], whole.rows[:, k : k + 3]) for k in (0, 3)]
        return [Block(names, rows, whole.clock) for names, rows in parts]
    force, torque = (file.meant(meaning, clock) for meaning in ("force", "torque"))
    return [block for block in (force, torque) if block is not None] if force else []


def change(wrench: Sequence[Block]) -> float:
    """Return by how much a force changes [N]."""
    force = wrench[0].rows
    return float(np.nanmax(np.linalg.norm(force - np.nanmedian(force, axis=0), axis=1)))


def proven_frame(
    wrench: Sequence[Block],
    effort: str | None,
    means: BlockMeans | None,
    values: Array,
    arm: Robot | None,
    file: Contents,
) -> Frame | None:
    """Return the frame of a wrench with values (M, 6), None where no effort proves it."""
    title, left_out = " and ".join(block.title for block in wrench), file.evidence.left_out
    known = effort and means and arm
    frame, lead = wrench_frame(means, effort, values, arm) if known else (None, 0.0)  # type: ignore[arg-type]
    if frame is None:
        left_out.append(
            f"{title}: in the base's frame or the flange's, by the arm or on it (the best two "
            f"log-likelihoods are {lead:.1f} apart, changes up to {change(wrench):.0f} N); record "
            "a push in several postures, or name them, as with --columns"
        )
        return None
    if len(wrench) == 1 and frame.axes == "base":
        left_out.append(
            f"{title}: in the base's frame, in which a force is read only together with its "
            "moments: record these, too, or the force in the flange's axes"
        )
        return None
    file.evidence.proven.append(
        f"{title} in the {frame.axes}'s frame: it explains the efforts better than in others "
        f"(log-likelihood greater by {lead:.3g})"
    )
    return frame


def is_opposite_wrench(
    frame: Frame,
    wrench: Sequence[Block],
    means: BlockMeans,
    values: Array,
    arm: Robot,
    file: Contents,
) -> bool:
    """Return whether the sign of a wrench is opposite to that of its channel.

    Where a hand leads an arm, friction takes up the hand, and efforts may have the sign of the
    force on the arm. A force that mostly acts along the motion, or against it, proves no sign.
    """
    title, evidence = " and ".join(block.title for block in wrench), file.evidence
    along = _share_along_motion(frame, means, values, arm)
    actor = "of the arm on its surroundings" if frame.by_arm else "of the surroundings on the arm"
    if frame.axes == "base" and arm.wrist_sensor and frame.by_arm:
        evidence.check.append(f"{title} has the sign of actual_TCP_force, as where a hand leads")
        return False
    if max(along, 1 - along) > ONE_SIDED:
        evidence.check.append(
            f"{title} is the force {actor}, by the efforts; but it acts along the motion in "
            f"{along:.0%} of the moving time, as where a hand leads the arm: check its sign"
        )
    else:
        evidence.proven.append(f"{title} is the force {actor}, by the efforts")
    return frame.by_arm == (frame.axes == "flange" or arm.wrist_sensor)


def _share_along_motion(frame: Frame, means: BlockMeans, values: Array, arm: Robot) -> float:
    """Return the share of the moving time in which a force acts along the flange's velocity."""
    velocity = np.einsum("nij,nj->ni", geometric_jacobian(arm, means.q)[:, :3], means.qd)
    force = values[:, :3]
    if frame.axes == "flange":
        force = np.einsum("nij,nj->ni", link_frames(arm, means.q)[0][:, -1], force)
    moving = np.linalg.norm(velocity, axis=1) > MOVING
    return float(np.mean((force * velocity).sum(axis=1)[moving] > 0)) if moving.any() else 0.5
