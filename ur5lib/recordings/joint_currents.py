"""Whether each measured current belongs to the motion of its joint: by friction and gravity.

Each joint's current is explained by the dry and viscous friction of its own motion, by gravity or
the controller's target, and by inertia. Friction brakes, so that its coefficients have a sign. How
much of the current is left, and how it changes from frame to frame, tells exchanged columns and
delayed ones from right ones; friction tells turned ones.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np
import pandas as pd
from scipy.optimize import nnls

from ur5lib.recordings.block_means import INDEPENDENT, BlockMeans, combination
from ur5lib.recordings.innovations import CURRENT, innovation_likelihoods
from ur5lib.recordings.quality import Finding, contradiction
from ur5lib.recordings.readings import IN_ORDER, Order, readings
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Labels, Mask

MOVES = 0.05  # rad/s, root mean square; slower joints show no friction
SURE = 20.0  # difference of log-likelihoods; in right recordings of four arms, at most 9
SURE_PAIR = 60.0  # the same of two joints before all others; in right recordings, at most 5
SURE_BY_HAND = 40.0  # likewise of a led arm, before shorter delays; in right ones, at most 1
NOISE = 0.02  # A; nothing is explained better
SURE_ARM = 40.0  # the same for another arm; in right recordings, at most 31
RECEIVED = 0.4  # share of a block's frames; in some recordings, half are lost
BRAKES = 4.0  # standard errors by which friction drives; in right recordings, at most 2
LED = 3  # joints that move at least where a hand leads an arm; a strong push turns one
STEP, LONGEST = 0.02, 0.4  # s, of the delays that are tried; right recordings show none
DELAYED = 0.03  # s; a shorter delay changes nothing that is fitted below 2 Hz
WEAK, STRONG = 0.8, 2.0  # current per target; 0.87 to 1.5 in right recordings, loads included
BEARS = 1.0  # A, root mean square of the target of a joint that bears something


def strange_currents(
    robot: pd.DataFrame, means: BlockMeans, arm: Robot, step: float
) -> Iterator[Finding]:
    """Find currents that are delayed, exchanged, turned or scaled.

    robot: a repaired table; means: over its blocks; arm: with what it carries; step: [s].
    """
    driven = is_driven(robot)
    if CURRENT not in means.currents or moving(means).sum() < (1 if driven else LED):
        return
    count = max(1, round(STEP / step))
    most = round(LONGEST / (count * step))
    lags = np.arange(-most, most + 1)
    answers = innovation_likelihoods(robot, step, lags * count)
    motion, own = delay_scores(robot, arm, step, count, lags), np.einsum("ljj->l", answers)
    delays = np.asarray(lags * count * step)
    for scores in (motion, own):
        yield from delayed(delays, scores, driven)
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
    ahead = [[own[k] - np.delete(own, k).max() for k in range(6)] for own in score]
    gains = np.triu(np.add(ahead, np.transpose(ahead)), 1)
    j, k = np.argwhere(gains == gains.max())[0].tolist()
    if gains[j, k] > SURE_PAIR:
        yield contradiction("exchanged currents", joint=j + 1, other=k + 1)


def exchanged_joints(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find two of joints 1 to 3, all channels of which are exchanged: by gravity."""
    if CURRENT not in means.currents:
        return
    orders = {_exchanged(*pair): pair for pair in combinations(range(3), 2)}
    scores = {
        one.order: one.score for one in readings(means, [CURRENT], [arm], [IN_ORDER, *orders])
    }
    for order, (j, k) in orders.items():
        if scores[order] - scores[IN_ORDER] > SURE:
            yield contradiction("exchanged joints", joint=j + 1, other=k + 1)


def _exchanged(j: int, k: int) -> Order:
    return tuple({j: k, k: j}.get(joint, joint) for joint in IN_ORDER)


def foreign_arm(means: BlockMeans, arm: Robot, others: Sequence[Robot]) -> Iterator[Finding]:
    """Find another arm whose gravity explains the currents better by far; all under their load."""
    if CURRENT not in means.currents:
        return
    (own,) = readings(means, [CURRENT], [arm], [IN_ORDER])
    best = readings(means, [CURRENT], others, [IN_ORDER])[0]
    if best.score - own.score > SURE_ARM:
        yield contradiction("other arm's currents", arm=arm.name, other=best.arm)


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
    target = means.currents["target_current"]
    bears = moving(means) & (np.sqrt((target**2).mean(axis=0)) > BEARS)
    bears |= target.std(axis=0) > BEARS  # at rest, of a joint whose load others change
    for joint in np.flatnonzero(bears[:3]).tolist():  # wrists hardly bear anything
        own, friction = target[:, joint], means.friction(joint)
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
        left = _beside(np.column_stack(own)[rows], later[rows - most, joint])
        scores -= len(rows) * step / INDEPENDENT / 2 * np.log((left**2).mean(axis=0) + NOISE**2)
    return scores


def _beside(columns: Array, values: Array) -> Array:
    """Return what columns (n, m) do not explain of values (n, ...)."""
    basis, _ = np.linalg.qr(columns)
    return np.asarray(values - basis @ (basis.T @ values))


def _left(means: BlockMeans, arm: Robot) -> Array:
    """Return the mean squares (6, 6) that the motion of each joint leaves of each current.

    Row j: the current of joint j; column k: the motion and the target of joint k.
    """
    targets = means.currents.get("target_current")
    expected = means.gravity(arm) if targets is None else targets
    current = means.currents[CURRENT]
    columns = [_columns(means, expected[:, k], k, inertia=targets is None) for k in range(6)]
    return np.array([[_rest(own, current[:, j]) for own in columns] for j in range(6)])


def _columns(means: BlockMeans, expected: Array, joint: int, inertia: bool) -> Array:
    """Return what a current contains (M, n), each with a coefficient that is not negative."""
    free = np.column_stack([means.qdd[:, joint]] * inertia + [np.ones(len(expected))])
    return np.column_stack([means.friction(joint), expected, free, -free])


def _rest(columns: Array, current: Array) -> float:
    """Return the mean square that columns with positive coefficients leave of a current."""
    return float(nnls(columns, current)[1] ** 2 / len(current))


def _means(values: Array, count: int) -> Array:
    """Return the means of each `count` rows (N // count, n)."""
    whole = len(values) // count * count
    return np.asarray(values[:whole].reshape(-1, count, values.shape[1]).mean(axis=1))
