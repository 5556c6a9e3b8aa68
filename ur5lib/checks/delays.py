"""Checks of when currents and torques come: the delay after the motion that they drive."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.channels import CURRENT, TORQUE
from ur5lib.checks.block_means import DECORRELATION_TIME
from ur5lib.checks.channels import MIN_MOVING_SPEED
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import PRESLIDING_DISTANCE, friction_direction
from ur5lib.robots.newton_euler import torque_regressor
from ur5lib.robots.statics import gravity_columns
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import correlation

# A difference of log-likelihoods. In right recordings of real and drawn arms, it is at most 12 of
# all joints, 15 of one.
MIN_LEAD_OF_DELAY = 20.0
# The lead before shorter delays, which friction that follows the reversal looks like, by drives
# and without friction. In right recordings, it is at most 1, of all of a sensor's torques 31, of
# one 16.
MIN_LEAD_BEFORE_SHORTER, MIN_LEAD_WITHOUT_FRICTION, MIN_LEAD_OF_TORQUE = 8.0, 40.0, 25.0
# These are the step and the largest of the tried delays; right recordings show none.
DELAY_STEP, MAX_DELAY = 0.02, 0.4  # s
# A delay of fewer periods of the currents' low-pass changes nothing that it leaves.
DELAY_IN_PERIODS = 0.06
CURRENT_NOISE = 0.02  # A, or Nm of torques; nothing is explained better
# Distances [rad] over which friction may reverse: the usual one, and those that look like a delay.
REVERSALS = (PRESLIDING_DISTANCE, 1e-3, 2e-3)
MAX_ROWS = 5000  # of torques that are looked at
SMALLEST_SHARE = 1e-3  # of the largest singular value; smaller columns fit noise
MIN_ALIKE = 0.9  # correlation of velocities with the slopes of their positions
MIN_SHARE_RECEIVED = 0.4  # share of a block's frames; in some recordings, half are lost


class Delays(NamedTuple):
    """Log-likelihoods of delays between a motion and its currents, or torques.

    seconds: (L,) the delays, zero in the middle, positive where currents come later; scores: (F, n,
    L) log-likelihoods by friction, joint and delay, zero of joints at rest; of the frictions, the
    first two are usual ones, the others reverse over a long distance; shortest: delay that matters
    [s]; moves: (n,) which joints move.
    """

    seconds: Array
    scores: Array
    shortest: float
    moves: Mask

    @property
    def likelihoods(self) -> Array:
        """Return the log-likelihoods (L,) of delays by all joints, with the likelier of the usual
        frictions.
        """
        return np.asarray(self.scores[:2].sum(axis=1).max(axis=0))

    @property
    def of_slow_reversal(self) -> Array:
        """Return the log-likelihoods (L,) of delays by all joints, with friction that reverses over
        a long distance.
        """
        return np.asarray(self.scores[2:].sum(axis=1).max(axis=0))

    def given(self, likelihoods: Array) -> "Delays":
        """Return the delays with log-likelihoods (n, L) of further evidence added."""
        return self._replace(scores=self.scores + likelihoods)

    def of_joint(self, joint: int) -> "Delays":
        """Return the delays of a joint, from 0, alone."""
        return self._replace(scores=self.scores[:, joint : joint + 1])

    def late_joint(self, rubs: bool) -> tuple[int, float] | None:
        """Return the only moving joint, from 0, with a delay, and that delay [s]; None if there is
        no such joint, or the others may have that delay, too. rubs: whether friction brakes what
        the efforts drive.

        What a joint at rest holds against the motion of others does not show when its efforts come.
        """
        least = MIN_LEAD_BEFORE_SHORTER if rubs else MIN_LEAD_OF_TORQUE
        moving = np.flatnonzero(self.moves).tolist()
        found = [(joint, self.of_joint(joint).ahead_by(least)) for joint in moving]
        shown = [(joint, delay) for joint, delay in found if delay is not None]
        if len(shown) != 1:
            return None
        ((joint, delay),) = shown
        others = self._replace(scores=np.delete(self.scores, joint, axis=1)).likelihoods
        ahead = others[~self.late()].max() - others[np.isclose(self.seconds, delay)].max()
        return (joint, delay) if ahead > MIN_LEAD_OF_DELAY else None

    def behind(self) -> Array:
        """Return by how much the log-likelihood of no delay exceeds that of each delay (L,)."""
        return np.asarray(self.likelihoods[len(self.seconds) // 2] - self.likelihoods)

    def late(self) -> Mask:
        """Return which delays (L,) are long enough to matter; none at 1 Hz, where zero alone is
        tried.
        """
        return np.asarray(np.abs(self.seconds) >= self.shortest)

    def longest_unnoticed(self) -> float:
        """Return the longest delay [s] that is almost as likely as none, and so would not be
        noticed.
        """
        if not self.late().any():
            return MAX_DELAY
        return float(np.abs(self.seconds[self.behind() <= MIN_LEAD_OF_DELAY]).max())

    def shown(self, driven: bool) -> float | None:
        """Return the delay [s] that is far likelier than none, None if no delay is; driven: whether
        motors move the arm, so that friction shows it.
        """
        return self.ahead_by(MIN_LEAD_BEFORE_SHORTER if driven else MIN_LEAD_WITHOUT_FRICTION)

    def ahead_by(self, least: float) -> float | None:
        """Return the delay [s] that is far likelier than none, and by `least` than any short one;
        None if no delay is.
        """
        late, behind = self.late(), self.behind()
        if not late.any() or behind[late].min() >= -MIN_LEAD_OF_DELAY:
            return None
        shown = behind[~late].min() - behind[late].min() > least
        return float(self.seconds[late][np.argmin(behind[late])]) if shown else None

    def is_doubtful(self) -> bool:
        """Return whether friction that reverses over a long distance explains the currents as well
        as a delay.
        """
        slowly = self.of_slow_reversal[~self.late()].max()
        return bool(slowly > self.likelihoods.max() - MIN_LEAD_BEFORE_SHORTER)


def delayed_currents(delays: Delays, driven: bool, name: str) -> Iterator[Finding]:
    """Find currents, or torques, that come later or earlier than the motion that they drive.

    name: of their channel. A warning where slowly reversing friction explains as much.
    """
    if (delay := delays.shown(driven)) is None:
        return
    late, early = (CauseCode.LATE_CURRENT, "later"), (CauseCode.EARLY_CURRENT, "earlier")
    cause, side = late if delay > 0 else early
    seen = f"{name} comes {abs(delay):.2f} s {side} than the motion"
    if delays.is_doubtful():
        detail = f"{seen}, or friction reverses over {1e3 * max(REVERSALS):g} mrad: check the clock"
        yield Finding("robot", Found.POSSIBLE_DELAY, "warning", 1, detail, cause=cause)
    else:
        detail = f"{seen}; record both with one clock, or correct the time of one"
        yield contradiction(cause, "delay", detail)


def delayed_joint(delays: Delays, rubs: bool, name: str, robot: pd.DataFrame) -> Iterator[Finding]:
    """Find the one joint where the current, or torque, comes later or earlier than the motion, or
    its positions than both.

    rubs: whether friction brakes what the efforts drive; name: of their channel; robot: a repaired
    table. A warning where slowly reversing friction explains as much, and of torques whose
    velocities do not bear it out.
    """
    if (found := delays.late_joint(rubs)) is None:
        return
    (joint, delay), rate = found, late_positions(robot, found[0])
    late, early = (CauseCode.LATE_JOINT, "later"), (CauseCode.EARLY_JOINT, "earlier")
    if rate is not None and abs(rate + delay) < abs(rate):  # nearer to that than to none
        (cause, side), whose = late if rate > 0 else early, "actual_q"
        seen, rest = f"actual_qd and {name} of it", "those of the others do not"
    else:
        (cause, side), whose, seen = late if delay > 0 else early, name, "its motion"
        agrees = ", and actual_qd agrees with actual_q" if rate is not None else ""
        rest = f"those of the others do not{agrees}"
    detail = (
        f"{whose} of joint {joint + 1} comes {abs(delay):.2f} s {side} than {seen}, {rest}; "
        "correct the time of this column"
    )
    sign = contradiction(cause, "delay", detail, [joint + 1])
    alone = rate is None and name != CURRENT.channel
    yield as_warning(sign) if alone or delays.of_joint(joint).is_doubtful() else sign


def late_positions(robot: pd.DataFrame, joint: int) -> float | None:
    """Return by how long [s] the slopes of a joint's positions, from 0, come after its velocities;
    None where these are not recorded, or no delay makes them alike. robot: a repaired table.
    """
    if f"actual_qd_{joint}" not in robot:
        return None
    step = float(robot["time"].diff().median())
    count = max(1, round(DELAY_STEP / step))
    names = [f"{name}_{joint}" for name in ("actual_q", "actual_qd")]
    q, qd = np.nan_to_num(_means(robot[names].to_numpy(float), count)).T
    slope, most = np.gradient(q), round(MAX_DELAY / (count * step))
    if len(slope) < 4 * most or not most:
        return None
    later = np.lib.stride_tricks.sliding_window_view(slope, len(slope) - 2 * most)
    alike = correlation(later.T, np.broadcast_to(qd[most:-most, None], later.T.shape))
    best = int(np.nanargmax(alike)) if np.isfinite(alike).any() else 0
    return (best - most) * count * step if alike[best] > MIN_ALIKE else None


def as_warning(delay: Finding) -> Finding:
    """Return the stop sign of a delay as the warning of a possible one."""
    return replace(delay, code=Found.POSSIBLE_DELAY, severity="warning", kind="")


def delays_by_motion(robot: pd.DataFrame, arm: Robot, step: float, cutoff: float) -> Delays:
    """Return the log-likelihoods of delays of all currents, from the joints that move.

    robot: a repaired table with a period `step` [s]; arm: with what it carries; cutoff: of the
    currents' low-pass [Hz].
    """
    count = max(1, round(DELAY_STEP / step))
    most = round(MAX_DELAY / (count * step))
    lags = np.arange(-most, most + 1)
    # means over blocks, from positions and currents alone
    names = "actual_q", arm.measured.channel
    q, current = (_means(channel(robot, name), count) for name in names)
    received = 1 - _means(robot[["interpolated"]].to_numpy(float), count)[:, 0]
    step *= count
    qd = np.gradient(q, step, axis=0)
    qdd = np.gradient(qd, step, axis=0)
    # blocks with a current at every delay
    rows = np.arange(most, len(q) - most)
    later = np.lib.stride_tricks.sliding_window_view(current, len(lags), axis=0)  # (n, 6, lags)
    rows = rows[np.isfinite(later).all(axis=(1, 2)) & np.isfinite(q[rows]).all(axis=1)]
    rows = rows[received[rows] >= MIN_SHARE_RECEIVED]
    independent = len(rows) * step / DECORRELATION_TIME
    if arm.measured == TORQUE:  # of whose links any have many columns
        rows = rows[:: 1 + len(rows) // MAX_ROWS]
    links = _links(arm, q[rows], qd[rows], qdd[rows])
    # the log-likelihood of each delay
    shortest = DELAY_IN_PERIODS / cutoff
    scores = np.zeros((1 + len(REVERSALS), q.shape[1], len(lags)))
    moves = (qd[rows] ** 2).sum(axis=0) > MIN_MOVING_SPEED**2 * max(len(rows), most)
    for joint in np.flatnonzero(moves):
        terms = [qd[rows, joint], links[joint], np.ones(len(rows))]
        currents, left = later[rows - most, joint], []
        for friction in _frictions(q[:, joint], qd[:, joint]):
            basis, _ = np.linalg.qr(np.column_stack([*terms, friction[rows]]))
            left.append(((currents - basis @ (basis.T @ currents)) ** 2).mean(axis=0))
        scores[:, joint] = -independent / 2 * np.log(np.array(left) + CURRENT_NOISE**2)
    return Delays(np.asarray(lags * step), scores, shortest, moves)


def _links(arm: Robot, q: Array, qd: Array, qdd: Array) -> list[Array]:
    """Return for each joint the columns (N, c) that its links' torque combines: gravity and the
    joint's acceleration, of measured torques those of any links.
    """
    if arm.measured == CURRENT:
        gravity = gravity_columns(arm, q)
        return [np.column_stack([own, qdd[:, joint]]) for joint, own in enumerate(gravity)]
    return [column_basis(own) for own in torque_regressor(arm, q, qd, qdd).swapaxes(0, 1)]


def _frictions(q: Array, qd: Array) -> Iterator[Array]:
    """Yield the directions (N,) of dry friction that reverses at once, or over a distance."""
    yield np.tanh(qd / MIN_MOVING_SPEED)
    known = pd.Series(q).ffill().bfill().to_numpy()
    for distance in REVERSALS:
        yield friction_direction(known, np.zeros(len(q), int), distance)


def column_basis(columns: Array) -> Array:
    """Return an orthonormal basis (N, r) of columns (N, c), but for what is small among them."""
    basis, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(basis[:, sizes > SMALLEST_SHARE * sizes.max(initial=0.0)])


def _means(values: Array, count: int) -> Array:
    """Return the means (N // count, n) over `count` rows each."""
    whole = len(values) // count * count
    return np.asarray(values[:whole].reshape(-1, count, values.shape[1]).mean(axis=1))
