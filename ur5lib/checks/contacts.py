"""Contacts in a recording that should be free of them, by its force sensor and its currents.

While a joint moves, gravity, friction and inertia explain its current but for a small share of its
motor's largest torque. While the arm rests, friction may carry any part of gravity, but that part
barely changes. What lasts for half a second and exceeds that is a contact, or a load.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view

from ur5lib.checks.block_means import FULL_FRICTION_SPEED, BlockMeans
from ur5lib.checks.channels import MIN_MOVING_SPEED
from ur5lib.records.codes import Found
from ur5lib.records.phrases import as_written, number
from ur5lib.records.quality import CONTACT_TORQUE_SHARE, Finding
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import STANDARD_GRAVITY
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import runs

WINDOW_BLOCKS = 5  # blocks, 0.5 s; shorter deviations are those of friction
SETTLING_BLOCKS = 5  # blocks after a stop until friction no longer changes
MIN_MOVING_BLOCKS = 100  # blocks in which a joint moves, which its friction is fitted to
REGRESSION_ROUNDS = 10  # least squares are reweighted this often
OUTLIER_DISTANCE = 1.5  # from this many robust standard deviations on, a block counts less
CONTACT_FORCE = 15.0  # N; a sensor's drift and the weight of its own half stay below
CONTACT_TIME = 0.5  # s; all samples beyond that force together last this long


def sensed_contacts(table: pd.DataFrame, mass: float) -> list[Finding]:
    """Find contacts at the force sensor of a recording that should be free of them.

    table: `time` and ft_* as read; mass: [kg], behind the sensor; its weight turns with it.
    """
    if "ft_fx" not in table:
        return []
    force = table[["ft_fx", "ft_fy", "ft_fz"]].to_numpy(float)
    size = np.linalg.norm(force - np.nanmedian(force, axis=0), axis=1)
    time = table["time"].to_numpy()
    beyond = size > CONTACT_FORCE + 2 * STANDARD_GRAVITY * mass
    if not beyond.sum() * np.median(np.diff(time)) > CONTACT_TIME:
        return []
    detail = (
        f"the force differs from its median by up to {number(np.nanmax(size), '.0f')} N, but the "
        "recording's role means that nothing touches the arm; give it the role contact, or declare "
        "`payload`"
    )
    return [Finding("force", Found.CONTACT, "warning", int(beyond.sum()), detail)]


class FeltContact(NamedTuple):
    """A contact that motors feel: the joint, from 1, on which it is strongest, its torque [Nm]
    there, and when it occurs [s] after the start.
    """

    joint: int
    torque: float
    at: float

    def finding(self, is_doubted: bool) -> Finding:
        """Return the warning of this contact; is_doubted: whether the links of its joint are in
        doubt, too, which may be the cause.
        """
        differs = (
            f"{number(self.at, '.1f')} s after the start, the torque of joint {self.joint} differs "
            f"by {number(self.torque, '.2g')} Nm from what gravity, friction and inertia explain"
        )
        detail = (
            f"{differs}; the likely cause is the description of this joint, whose links are in "
            "doubt: correct it first. If this finding stays, something touches the arm: give the "
            "recording the role contact"
            if is_doubted
            else f"{differs}, but the recording's role means that nothing touches the arm; give it "
            "the role contact, cut the contact off by `from_s` and `to_s`, or declare `payload`; "
            "until then, fits leave it out"
        )
        return Finding("robot", Found.CONTACT, "warning", 1, detail)


def felt_contact(means: BlockMeans, arm: Robot) -> FeltContact | None:
    """Return the strongest contact that the currents show; None if there is none.

    means: of a recording, with currents; arm: with what it carries.
    """
    assert means.time is not None
    shares = torque_shares(means, arm)
    if not (shares > CONTACT_TORQUE_SHARE).any():
        return None
    window, joint = np.unravel_index(np.nanargmax(shares), shares.shape)
    torque = float(shares[window, joint] * arm.torque_limits()[joint])
    at = float(means.time[window] - means.time[0])
    return FeltContact(int(joint) + 1, torque, at)


def felt_contacts(means: BlockMeans, arm: Robot) -> list[tuple[float, float]]:
    """Return from and to [s], since the first block, of all contacts that the currents show;
    arguments as of `felt_contact`.
    """
    assert means.time is not None
    since = means.time - means.time[0]
    beyond = np.asarray((torque_shares(means, arm) > CONTACT_TORQUE_SHARE).any(axis=1))
    felt = runs(beyond).tolist()
    ends = [(first, min(last - 1 + WINDOW_BLOCKS, len(since) - 1)) for first, last in felt]
    return [(float(since[first]), float(since[last])) for first, last in ends]


def torque_shares(means: BlockMeans, arm: Robot) -> Array:
    """Return `deviations` (W, n) as shares of the motors' largest torques."""
    constants = np.array(arm.maker_torque_constants())
    return deviations(means, arm) * constants / np.array(arm.torque_limits())


def unfelt_contacts(arm: Robot) -> Finding:
    """Return a note on how large a contact's torques must be to be noticed."""
    torques = as_written([CONTACT_TORQUE_SHARE * torque for torque in arm.torque_limits()], ".2g")
    detail = (
        f"contacts that change the motors' torques by less than {torques} Nm could not be noticed; "
        "the report finds weaker ones"
    )
    return Finding("robot", Found.CONTACT_NOT_CHECKED, "note", 1, detail)


def deviations(means: BlockMeans, arm: Robot) -> Array:
    """Return the sizes (W, n) [A] of the part of each joint's current that is unexplained, by
    window.

    While the joint moves, it is what gravity, friction and inertia leave; while the arm rests, the
    change of the current. NaN in other windows, and where blocks are too few.
    """
    assert means.time is not None
    assert means.segment is not None
    gravity, current = means.gravity(arm), means.effort
    steps = np.diff(means.time, prepend=means.time[0])
    same = np.diff(means.segment, prepend=means.segment[0]) == 0
    follows = same & (steps < 1.5 * np.median(steps))  # directly after the block before
    whole = np.asarray(_windows(follows)[:, 1:].all(axis=1))
    moves = np.abs(means.qd) > MIN_MOVING_SPEED
    sizes = np.full((len(whole), current.shape[1]), np.nan)
    for joint, moving in enumerate(moves.T):
        if np.count_nonzero(moving) >= MIN_MOVING_BLOCKS:
            residual = _unexplained_current(means, gravity[:, joint], joint, moving)
            rows = whole & _windows(moving).all(axis=1)
            sizes[rows, joint] = np.abs(_windows(residual).mean(axis=1)[rows])
    resting = (np.abs(means.qd) < FULL_FRICTION_SPEED).all(axis=1)
    for start, end in runs(resting & follows):
        changes = current[start + SETTLING_BLOCKS : end]
        if len(changes) > WINDOW_BLOCKS:
            mean = sliding_window_view(changes, WINDOW_BLOCKS, axis=0).mean(axis=2)
            sizes[start + SETTLING_BLOCKS :][: len(mean)] = mean - mean.min(axis=0)
    return sizes


def _unexplained_current(means: BlockMeans, gravity: Array, joint: int, moving: Mask) -> Array:
    """Return what gravity, friction and inertia leave of a joint's current (M,) [A].

    They are fitted by a robust regression to the blocks in which the joint moves (`moving`).
    """
    friction, speed = means.friction(joint), means.qd[:, joint]
    terms = [gravity, friction, np.abs(gravity) * friction[:, 0], np.abs(speed) * speed, means.qdd]
    columns = np.column_stack([*terms, np.ones(len(gravity))])
    current = means.effort[:, joint]
    weight = moving.astype(float)
    residual = current
    for _ in range(REGRESSION_ROUNDS):
        scaled = columns * weight[:, None]
        residual = current - columns @ np.linalg.lstsq(scaled, current * weight, rcond=None)[0]
        spread = OUTLIER_DISTANCE * 1.48 * np.median(np.abs(residual[moving])) + 1e-9
        weight = moving * np.sqrt(1 / np.maximum(1, np.abs(residual) / spread))
    return np.asarray(residual)


def _windows(values: Array | Mask) -> Array:
    """Return the windows (W, WINDOW_BLOCKS) of consecutive blocks of (M,)."""
    return sliding_window_view(values, WINDOW_BLOCKS)
