"""Whether each measured current belongs to the motion of its joint: by friction and gravity.

Each joint's current is explained by the dry and viscous friction of its own motion, by gravity or
the controller's target, and by inertia. Friction brakes, so that its coefficients have a sign. How
much of the current is left tells exchanged columns, delayed or turned ones from right ones.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np
import pandas as pd
from scipy.optimize import nnls

from ur5lib.recordings.block_means import INDEPENDENT, BlockMeans, combination
from ur5lib.recordings.quality import Finding, contradiction
from ur5lib.recordings.readings import IN_ORDER, Order, readings
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Mask

CURRENT = "actual_current"
MOVES = 0.05  # rad/s, root mean square; slower joints show no friction
SURE = 20.0  # difference of log-likelihoods; in right recordings of four arms, at most 16
NOISE = 0.02  # A; nothing is explained better
SURE_ARM = 40.0  # the same for another arm; in right recordings, at most 24
RECEIVED = 0.4  # share of a block's frames; in some recordings, half are lost
BRAKES = 4.0  # standard errors by which friction drives; in right recordings, at most 2
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
    if CURRENT not in means.currents or not is_driven(robot):
        return
    yield from delayed(robot, arm, step)
    exchanged = [*exchanged_currents(means, arm)]
    yield from exchanged or turned(means, arm)
    yield from scaled(means)


def is_driven(robot: pd.DataFrame) -> bool:
    """Return whether a joint is to move; friction does not brake a joint that a contact moves."""
    if "target_qd_0" not in robot:
        return True
    return bool((np.nanmean(channel(robot, "target_qd") ** 2, axis=0) > MOVES**2).any())


def moving(means: BlockMeans) -> Mask:
    """Return which joints (6,) move."""
    return np.asarray(np.sqrt((means.qd**2).mean(axis=0)) > MOVES)


def exchanged_currents(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find two joints, each of which explains the current of the other better by far."""
    score = means.log_likelihood(_left(means, arm) + NOISE**2)
    gains = {
        (j, k): score[j, k] + score[k, j] - score[j, j] - score[k, k]
        for j, k in combinations(np.flatnonzero(moving(means)).tolist(), 2)
    }
    j, k = max(gains, key=gains.__getitem__, default=(0, 0))
    if gains.get((j, k), 0.0) > SURE:
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
    target, moves = means.currents["target_current"], moving(means)
    bears = np.sqrt((target**2).mean(axis=0)) > BEARS
    for joint in np.flatnonzero((moves & bears)[:3]).tolist():  # wrists hardly bear anything
        own, friction = target[:, joint], means.friction(joint)
        load = np.abs(own) * friction[:, 0]
        columns = np.column_stack([own, friction, load, means.qdd[:, joint]])
        slope, error = combination(columns, means.currents[CURRENT][:, joint], [1.0])
        if slope + 5 * error < WEAK or slope - 5 * error > STRONG:
            yield contradiction("scaled current", joint=joint + 1, ratio=slope)


def delayed(robot: pd.DataFrame, arm: Robot, step: float) -> Iterator[Finding]:
    """Find currents that come later or earlier than the motion that they drive."""
    delay, gain = current_delay(robot, arm, step)
    if abs(delay) >= DELAYED and gain > SURE:
        yield contradiction("late current" if delay > 0 else "early current", seconds=abs(delay))


def current_delay(robot: pd.DataFrame, arm: Robot, step: float) -> tuple[float, float]:
    """Return by how much the currents are late [s], and its gain of log-likelihood over none.

    robot: a repaired table with a period `step` [s]. Zero where no joint moves.
    """
    # means over blocks, from positions and currents alone
    count = max(1, round(STEP / step))
    q, current = (_means(channel(robot, name), count) for name in ("actual_q", CURRENT))
    received = 1 - _means(robot[["interpolated"]].to_numpy(float), count)[:, 0]
    step *= count
    qd = np.gradient(q, step, axis=0)
    gravity, qdd = gravity_torque(arm, arm.chosen_model, q), np.gradient(qd, step, axis=0)
    # blocks whose current is known at every delay
    most = round(LONGEST / step)
    lags, rows = np.arange(-most, most + 1), np.arange(most, len(q) - most)
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
    best = int(np.argmax(scores))
    return float(lags[best] * step), float(scores[best] - scores[most])


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
