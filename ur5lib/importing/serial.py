"""The arm of a file with more than six joints, and its torques: by what its links need."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.errors import InputError
from ur5lib.importing.blocks import Block
from ur5lib.importing.contents import Contents
from ur5lib.importing.motion import SMOOTHED, ImportedMotion
from ur5lib.recordings.block_means import SLOW, TINY
from ur5lib.recordings.entries import OPPOSITE
from ur5lib.recordings.stop_signs import described
from ur5lib.robots.description import Robot, robot_names
from ur5lib.timeseries.arrays import Array

LEFT = 0.2  # largest share of the torques' changes that links and friction leave
RIVAL = 2.0  # times the share of the best; arms that leave less are as good
TORQUES = ("actual_current_as_torque", "effort")


class Explained(NamedTuple):
    """A block as the torques of an arm, and the share of their changes that the arm leaves."""

    arm: str
    torque: Block
    left: float


def arms_of(file: Contents, arms: Sequence[str]) -> list[str]:
    """Return the arms with as many joints as a file: of those given, by default of all described.

    Raises InputError where there is none.
    """
    found = [name for name in arms or robot_names() if len(described(name).joints) == file.joints]
    if not found:
        asked = f"{', '.join(arms)} has not" if arms else "no described arm has"
        raise InputError(
            f"{file.path} holds {file.joints} joints, which {asked}; describe its arm by its URDF "
            "(`ur5 describe`), in the folder in which you import (docs/robots.md)"
        )
    return found


def arm_and_torque(moving: ImportedMotion, arms: Sequence[str]) -> tuple[str, Block | None]:
    """Return the arm, and the block of its joints' torques where gravity proves one.

    Raises InputError where several arms explain the torques as well, or nothing tells the arm.
    """
    file, evidence = moving.file, moving.file.evidence
    tried = [
        Explained(name, signed, left(described(name), *_means(moving, signed)))
        for name in arms
        for block in moving.beside(TORQUES)
        for signed in (block, block.scaled(np.full(file.joints, -1.0)))
    ]
    ranked = sorted(tried, key=lambda one: one.left)
    best = ranked[0] if ranked else None
    if best is not None and best.left < LEFT:
        rival = next((one for one in ranked if one.arm != best.arm), None)
        if rival is not None and rival.left < RIVAL * best.left:
            raise InputError(
                f"{file.path}: the arm is ambiguous: `robot: {best.arm}` and `robot: {rival.arm}` "
                f"explain its torques as well; name it, as with --robot {best.arm}"
            )
        sign = ", with the opposite sign" if best.torque.unit() == OPPOSITE else ""
        evidence.proven.append(
            f"{best.torque.title} is the torque of {best.arm}'s joints{sign}, gravity included: "
            f"the described arm explains {1 - best.left:.1%} of its changes"
        )
        return best.arm, best.torque
    if len(arms) > 1:
        raise InputError(
            f"{file.path}: the arm is ambiguous: no torque in it tells {' from '.join(arms)}; name "
            f"it, as with --robot {arms[0]}"
        )
    evidence.assumed.append(f"robot {arms[0]}: no other with {file.joints} joints is described")
    if best is not None:
        unexplained = min(best.left, 1.0)
        evidence.ambiguous.append(
            f"{best.torque.title}: as torques of {arms[0]}, it leaves {unexplained:.0%} of their "
            "changes to neither gravity, inertia nor friction; left out: check the description, "
            "`mounting` and the tool, or the order of the joints"
        )
    return arms[0], None


def left(arm: Robot, time: Array, q: Array, qd: Array, torque: Array) -> float:
    """Return the share of the changes of torques (N, n) [Nm] that an arm leaves unexplained.

    Inverse dynamics are as described; friction and an offset are fitted to each joint. time: (N,)
    [s]; q, qd: (N, n) [rad, rad/s]; all are means over SMOOTHED.
    """
    from ur5lib.dynamics.link_model import LinkModel  # slow to import; most files need none

    model = LinkModel(arm, arm.chosen_model)
    rest = torque - model.inverse_dynamics(q, qd, np.gradient(qd, time, axis=0))
    for joint, speed in enumerate(qd.T):
        columns = np.column_stack([np.tanh(speed / SLOW), speed, np.ones(len(speed))])
        rest[:, joint] -= columns @ np.linalg.lstsq(columns, rest[:, joint], rcond=None)[0]
    changes = torque - torque.mean(axis=0)
    return float((rest**2).sum() / max((changes**2).sum(), TINY))


def _means(moving: ImportedMotion, torque: Block) -> list[Array]:
    """Return time, positions, velocities and torques, as `left` takes them, without gaps."""
    si, time = moving.in_si(), moving.time
    q = si["actual_q"]
    qd = si.get("actual_qd", np.full_like(q, np.nan))
    if "actual_qd" not in si:
        qd[1:] = np.diff(q, axis=0) / np.maximum(np.diff(time), TINY)[:, None]
    table = np.column_stack([time, q, qd, torque.rows])
    table = table[np.isfinite(table).all(axis=1) & (np.diff(time, prepend=-np.inf) > 0)]
    width = max(1, round(SMOOTHED / float(np.median(np.diff(table[:, 0])))))
    whole = len(table) // width * width
    means = table[:whole].reshape(-1, width, table.shape[1]).mean(axis=1)
    return [means[:, 0], *np.split(means[:, 1:], 3, axis=1)]
