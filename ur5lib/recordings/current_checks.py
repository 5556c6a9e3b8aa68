"""Checks of measured currents: their unit, their joints' motion, and loads that nothing declares.

Each joint's current is explained by the dry and viscous friction of its own motion, by gravity or
the controller's target, and by inertia. Friction brakes, so that its coefficients have a sign. How
much of the current is left, and how it changes from frame to frame, distinguishes exchanged columns
and delayed ones from right ones; friction distinguishes turned ones.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import nnls

from ur5lib.recordings.block_means import INDEPENDENT, BlockMeans, combination, fitted_load, size
from ur5lib.recordings.checks import MOVES
from ur5lib.recordings.innovations import CURRENT, innovation_likelihoods
from ur5lib.recordings.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque, load_torque
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Labels, Mask

SURE = 20.0  # difference of log-likelihoods; in right recordings of real and drawn arms, at most 12
SURE_PAIR = 60.0  # the same of two joints before all others; in right recordings, at most 5
SURE_BY_HAND = 40.0  # likewise of a led arm, before shorter delays; in right ones, at most 1
NOISE = 0.02  # A; nothing is explained better
RECEIVED = 0.4  # share of a block's frames; in some recordings, half are lost
BRAKES = 4.0  # standard errors by which friction drives; in right recordings, at most 2
STEP, LONGEST = 0.02, 0.4  # s, of the delays that are tried; right recordings show none
DELAYED = 0.03  # s; a shorter delay changes nothing that is fitted below 2 Hz
WEAK, STRONG = 0.8, 2.0  # current per target; 0.87 to 1.5 in right recordings, loads included
BEARS = 1.0  # A, root mean square of the target of a joint that bears something
BEARING = 3.0  # Nm; a joint with less gravity torque does not show the unit of its current
CONSTANTS = (2.5, 40.0)  # Nm/A; the torque constants of all arms lie between
ONE = (0.5, 2.0)  # Nm per “A” where the current is a torque
ERRORS = 5.0  # standard errors that are no chance
UNEXPLAINED = 0.5  # share of a current's square that gravity, friction and inertia may leave
UNDECLARED = 1.0  # kg; right recordings show up to 0.3 kg, all of it friction
LEAST = 30  # blocks of a joint in motion that show a load
SEEN = 0.2  # least share of the difference of the currents that such a load explains


def strange_currents(
    robot: pd.DataFrame, means: BlockMeans, arm: Robot, step: float, driven: bool
) -> Iterator[Finding]:
    """Find currents that are delayed, exchanged, turned or scaled, of an arm that moves.

    robot: a repaired table; means: over its blocks; arm: with what it carries; step: [s]; driven:
    whether by its motors.
    """
    if CURRENT not in means.currents:
        return
    count = max(1, round(STEP / step))
    most = round(LONGEST / (count * step))
    lags = np.arange(-most, most + 1)
    answers = innovation_likelihoods(robot, step, lags * count)
    motion, own = delay_scores(robot, arm, step, count, lags), np.einsum("ljj->l", answers)
    delays = np.asarray(lags * count * step)
    yield from delayed(delays, motion + own, driven)
    exchanged = [*exchanged_currents(means, arm, answers[most])]
    yield from exchanged
    if driven:
        yield from [] if exchanged else turned(means, arm)
        yield from scaled(means)


def is_driven(robot: pd.DataFrame) -> bool:
    """Return whether a joint is to move; friction does not brake a joint that a contact moves."""
    if "target_qd_0" not in robot:
        return True
    return bool((np.nanmean(channel(robot, "target_qd") ** 2, axis=0) > MOVES**2).any())


def moving(means: BlockMeans) -> Mask:
    """Return which joints (6,) move."""
    return np.asarray(np.sqrt((means.qd**2).mean(axis=0)) > MOVES)


def exchanged_currents(means: BlockMeans, arm: Robot, answers: Array) -> Iterator[Finding]:
    """Find two joints, each of which explains the current of the other better than all others do.

    answers: log-likelihoods (6, 6) of each current as an answer to each joint's motion.
    """
    score = answers + means.log_likelihood(_left(means, arm) + NOISE**2)
    ahead = [[own[k] - np.delete(own, k).max() for k in range(len(own))] for own in score]
    gains = np.triu(np.add(ahead, np.transpose(ahead)), 1)
    j, k = np.argwhere(gains == gains.max())[0].tolist()
    if gains[j, k] > SURE_PAIR:
        yield contradiction("exchanged currents", joint=j + 1, other=k + 1)


def turned(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find currents whose friction drives the motion instead of braking it."""
    gravity, rest = means.gravity(arm), [means.qdd, np.ones((len(means.q), 1))]
    speed = np.sqrt((means.qd**2).mean(axis=0))  # usual
    for joint in np.flatnonzero(moving(means)).tolist():
        columns = np.column_stack([means.friction(joint), gravity[:, joint], *rest])
        friction = combination(columns, means.currents[CURRENT][:, joint], [1.0, speed[joint]])
        if friction[0] < -BRAKES * friction[1]:
            yield contradiction("turned current", joint=joint + 1)


def scaled(means: BlockMeans) -> Iterator[Finding]:
    """Find currents that are a fraction or a multiple of their targets, in joints that bear."""
    if "target_current" not in means.currents:
        return
    moves = moving(means)
    for joint in range(3):  # wrists hardly bear anything
        own, friction = means.currents["target_current"][:, joint], means.friction(joint)
        # without friction, which targets of some arms contain, and inertia: only a load shows it
        others = np.column_stack([friction, means.qdd[:, joint]])
        borne = own - others @ np.linalg.lstsq(others, own, rcond=None)[0]
        # at rest, of a joint whose load others change
        if not (moves[joint] and np.sqrt((borne**2).mean()) > BEARS) and borne.std() <= BEARS:
            continue
        load = np.abs(own) * friction[:, 0]
        columns = np.column_stack([own, friction, load, means.qdd[:, joint]])
        slope, error = combination(columns, means.currents[CURRENT][:, joint], [1.0])
        if slope + 5 * error < WEAK or slope - 5 * error > STRONG:
            yield contradiction("scaled current", joint=joint + 1, ratio=slope)


def delayed(delays: Array, scores: Array, driven: bool) -> Iterator[Finding]:
    """Find currents that come later or earlier than the motion that they drive.

    delays: that are tried [s], none in the middle; scores: their log-likelihoods.
    """
    late = np.abs(delays) >= DELAYED
    if not late.any():  # of a recording at 1 Hz, steps are longer than any delay that is tried
        return
    most, shorter, none = scores[late].max(), scores[~late].max(), scores[len(scores) // 2]
    if most - none > SURE and most - shorter > (0.0 if driven else SURE_BY_HAND):
        delay = float(delays[late][np.argmax(scores[late])])
        code = "late current" if delay > 0 else "early current"
        yield contradiction(code, seconds=abs(delay))


def delay_scores(robot: pd.DataFrame, arm: Robot, step: float, count: int, lags: Labels) -> Array:
    """Return the log-likelihoods of delays of all currents, from the joints that move.

    robot: a repaired table with a period `step` [s]; lags: in blocks of `count` frames.
    """
    # means over blocks, from positions and currents alone
    q, current = (_means(channel(robot, name), count) for name in ("actual_q", CURRENT))
    received = 1 - _means(robot[["interpolated"]].to_numpy(float), count)[:, 0]
    step *= count
    qd = np.gradient(q, step, axis=0)
    gravity, qdd = gravity_torque(arm, arm.chosen_model, q), np.gradient(qd, step, axis=0)
    # blocks whose current is known at every delay
    most = int(lags.max())
    rows = np.arange(most, len(q) - most)
    later = np.lib.stride_tricks.sliding_window_view(current, len(lags), axis=0)  # (n, 6, lags)
    rows = rows[np.isfinite(later).all(axis=(1, 2)) & np.isfinite(q[rows]).all(axis=1)]
    rows = rows[received[rows] >= RECEIVED]
    # the log-likelihood of each delay
    scores = np.zeros(len(lags))
    for joint in np.flatnonzero((qd[rows] ** 2).sum(axis=0) > MOVES**2 * max(len(rows), most)):
        friction = np.tanh(qd[:, joint] / MOVES)
        own = [friction, qd[:, joint], gravity[:, joint], qdd[:, joint], np.ones(len(qd))]
        basis, _ = np.linalg.qr(np.column_stack(own)[rows])
        currents = later[rows - most, joint]
        left = currents - basis @ (basis.T @ currents)
        scores -= len(rows) * step / INDEPENDENT / 2 * np.log((left**2).mean(axis=0) + NOISE**2)
    return scores


def _left(means: BlockMeans, arm: Robot) -> Array:
    """Return the mean squares (6, 6) that the motion of each joint leaves of each current.

    Row j: the current of joint j; column k: the motion and the target of joint k.
    """
    targets = means.currents.get("target_current")
    expected = means.gravity(arm) if targets is None else targets
    current = means.currents[CURRENT]
    joints = range(current.shape[1])
    columns = [_columns(means, expected[:, k], k, inertia=targets is None) for k in joints]
    sizes = np.array([[nnls(own, current[:, j])[1] for own in columns] for j in joints])
    return np.asarray(sizes**2 / len(current))


def _columns(means: BlockMeans, expected: Array, joint: int, inertia: bool) -> Array:
    """Return what a current contains (M, n), each with a coefficient that is not negative."""
    free = np.column_stack([means.qdd[:, joint]] * inertia + [np.ones(len(expected))])
    return np.column_stack([means.friction(joint), expected, free, -free])


def _means(values: Array, count: int) -> Array:
    """Return the means of each `count` rows (N // count, n)."""
    whole = len(values) // count * count
    return np.asarray(values[:whole].reshape(-1, count, values.shape[1]).mean(axis=1))


class Held(NamedTuple):
    """Current per torque of gravity [A/Nm], its standard error, and the share left unexplained."""

    slope: float
    error: float
    left: float


def foreign_currents(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find currents that are not in A: too many or too few of them hold gravity.

    arm: with what it carries.
    """
    if arm.senses_torque():
        return
    gravity = means.gravity(arm)
    joint = int(np.argmax((gravity**2).mean(axis=0)))
    if np.sqrt((gravity[:, joint] ** 2).mean()) < BEARING:
        return
    for name, current in means.currents.items():
        held = _held(means, gravity, current, joint)
        away = ERRORS * held.error
        if held.left < UNEXPLAINED and not (
            1 / CONSTANTS[1] < held.slope + away and held.slope - away < 1 / CONSTANTS[0]
        ):
            constant = 1 / (held.slope or 1e-9)
            code = "torque as current" if ONE[0] <= constant <= ONE[1] else "no current"
            yield contradiction(code, name=name, joint=joint + 1, constant=constant)


def undeclared_load(means: BlockMeans, known: Robot, carrying: Robot) -> Iterator[Finding]:
    """Find a load that neither the study nor the controller knows, by which currents differ.

    known: the arm with the payload that the controller knows; carrying: with the declared one.
    """
    if {"actual_current", "target_current"} - means.currents.keys():
        return
    columns, torque = _unexpected(means, known, means.gravity(carrying) - means.gravity(known))
    if len(torque):
        mass, left = fitted_load(columns, torque)
        _, error = combination(columns, torque, [1.0])  # large where only a wrist moves
        if mass > max(UNDECLARED, ERRORS * error) and left**2 < (1 - SEEN) * size(torque) ** 2:
            yield contradiction("undeclared load", mass=mass)


def _held(means: BlockMeans, gravity: Array, current: Array, joint: int) -> Held:
    """Return how much of a joint's current holds gravity, beside friction and inertia."""
    own = current[:, joint]
    columns = np.column_stack([gravity[:, joint], means.friction(joint), means.qdd])
    inverse = np.linalg.pinv(columns)
    solution = inverse @ own
    left = size(own - columns @ solution)
    error = left / np.sqrt(max(1, len(own) - columns.shape[1])) * np.linalg.norm(inverse[0])
    return Held(float(solution[0]), float(error), (left / size(own)) ** 2)


def _unexpected(means: BlockMeans, known: Robot, declared: Array) -> tuple[Array, Array]:
    """Return torque per load (n, 4), and the torque (n,) that measured currents hold beyond
    target_current, both without friction and in units of its spread, of all joints that bear.

    Only of joints in motion: at rest, stiction bears an unknown part of what a posture demands,
    which looks like a load. declared: torque (M, 6) [Nm] that is known to be in it.
    """
    gravity, loads = means.gravity(known), load_torque(known, means.q)
    measured, target = means.currents["actual_current"], means.currents["target_current"]
    rows = [np.empty((0, 5))]
    for joint in range(gravity.shape[1]):
        own = np.abs(means.qd[:, joint]) > MOVES
        if np.count_nonzero(own) < LEAST:
            continue
        held = _held(means, gravity, target, joint)
        if held.left < UNEXPLAINED and 1 / CONSTANTS[1] < held.slope < 1 / CONSTANTS[0]:
            torque = (measured - target)[own, joint] / held.slope - declared[own, joint]
            pair = np.column_stack([loads[own, joint], torque])
            friction = means.friction(joint)[own]
            pair -= friction @ np.linalg.lstsq(friction, pair, rcond=None)[0]
            rows.append(pair / max(pair[:, -1].std(), 0.1))
    every = np.vstack(rows)
    return every[:, :-1], every[:, -1]
