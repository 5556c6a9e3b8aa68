"""The live estimator on a recording: the answers of `Live.step`, computed in blocks of samples.

Quantities that depend only on measured samples are computed for a whole chunk. Slow errors of the
run are learnt only while no contact is suspected: a block is computed as if it learnt throughout,
and is cut at the first suspected sample.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np

from ur5lib.records.measured import Measured
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import runs
from ur5lib.topics.live.live import MOVING, STILL, Answer, Live

CHUNK = 1024  # samples; quantities of measured samples are computed for this many at once
BLOCK = 128  # samples; slow errors are learnt from this many at once


class Followed(NamedTuple):
    """The answers to N samples: wrench, std (N, 6) [N, Nm]; evidence (N,), log-odds of a contact;
    contact (N,); known (N,), whether contact is decided; torque [Nm], shift [rad], state (N, n).
    """

    wrench: Array
    std: Array
    evidence: Array
    contact: Mask
    known: Mask
    torque: Array
    shift: Array
    state: Any

    def alarms(self) -> list[tuple[int, int]]:
        """Return (first, last) rows of each contact; last is exclusive."""
        return [(first, last) for first, last in runs(self.contact).tolist()]


class Sensed(NamedTuple):
    """Quantities of M samples that depend only on what was measured, not on what was learnt.

    (M, ...) each; observed, friction: [Nm].
    """

    time: Array
    passed: Array
    qd: Array
    observed: Array
    friction: Array
    slow_for: Array
    at_rest: Mask
    slow_ago: Array
    reach: Array
    shift: Array
    jacobian: Array
    place: Array

    def at(self, rows: slice) -> Self:
        """Return the samples `rows`."""
        return type(self)._make(own[rows] for own in self)


def follow(arm: Mapping[str, Any], run: Measured) -> Followed:
    """Return the estimator's answers to a recording; arm: its file. An unusable sample repeats the
    last answer; after more than `max_gap` s of such samples, the answer is that of an estimator
    that has just started.
    """
    estimator = LiveRecording(arm)
    rows, restarts = estimator.used(run)
    starts = [0, *(np.flatnonzero(restarts) + 1).tolist(), len(rows)]
    parts = [_nothing(estimator)]
    for first, last in pairwise(starts):
        estimator.restart()
        for begin in range(first, last, CHUNK):
            parts += estimator.chunk(run.at(rows[begin : min(begin + CHUNK, last)]))
    answers = Followed._make(map(np.concatenate, zip(*parts, strict=True)))  # row 0: a fresh start
    at = np.arange(len(run.time))
    latest = np.searchsorted(rows, at, side="right")
    missed = at - np.concatenate([[-1], rows])[latest]
    latest[missed * estimator.set["period"] > estimator.set["max_gap"]] = 0
    return Followed._make(own[latest] for own in answers)


def _nothing(estimator: Live) -> Followed:
    """Return the answer of an estimator that has just started, as one row."""
    wrench, std, _ = estimator.answer
    nothing, joints = np.zeros(1, bool), np.zeros((1, len(estimator.mass)))
    return Followed(
        wrench[None],
        std[None],
        np.zeros(1),
        nothing,
        nothing,
        joints,
        joints,
        joints.astype(np.int8),
    )


class LiveRecording(Live):
    """The estimator, given many samples at once."""

    def used(self, run: Measured) -> tuple[Labels, Mask]:
        """Return the usable rows (M,), and whether the run restarts after each of them (M - 1,)."""
        qd = np.zeros_like(run.q) if run.qd is None else run.qd
        rows = np.flatnonzero(self.possible(run.time, run.q, run.current, qd))
        last, now = rows[:-1], rows[1:]
        repeats = self.repeats(
            qd[now], run.q[now], run.current[now], run.q[last], run.current[last]
        )
        rows = np.concatenate([rows[:1], now[~repeats]])
        while True:
            passed, missed = np.diff(run.time[rows]), np.diff(rows) - 1
            restarts = np.maximum(np.abs(passed), missed * self.set["period"]) > self.set["max_gap"]
            most = self.set["margin"] * self.fastest * passed[:, None] + self.set["jump"]
            near = (np.abs(np.diff(run.q[rows], axis=0)) <= most).all(axis=1)
            usable = restarts | ((passed >= self.set["least_step"]) & near)
            if usable.all():
                return rows, restarts
            rows = np.delete(rows, np.argmin(usable) + 1)

    def chunk(self, run: Measured) -> Iterator[Followed]:
        """Yield the answers to usable samples without a restart, continuing the last chunk."""
        sensed, first = self._sense(run), 0
        while first < len(sensed.time):
            part = sensed.at(slice(first, first + BLOCK))
            late = part.time - self.suspected_at >= self.set["thaw"]
            learns = bool(late[0])
            if not learns and late.any():
                part = part.at(slice(int(np.argmax(late))))
            yield (answers := self._judged(part, learns))
            first += len(answers.wrench)

    def _sense(self, run: Measured) -> Sensed:
        """Return the quantities that depend only on samples, and update the state."""
        if first := bool(np.isnan(self.time)):
            self.start(run.time[0])
        passed = np.diff(run.time, prepend=self.time)
        by_joint = passed[:, None]
        qd = self._velocities(run, passed, first) if run.qd is None else run.qd
        kept = np.exp(-(np.abs(qd) * by_joint)[:, None] / self.distance)
        direction = cascade(kept, (1 - kept) * np.sign(qd)[:, None], self.direction)
        load, friction = self.gears(run.q, qd, run.current, direction)
        swept = self.sweep(run.q, qd)
        rate = load + swept.rate
        if first:
            self.friction, self.momentum, self.rate = friction[0], swept.momentum[0], rate[0]
            self.anchor = self.low = self.high = run.q[0]
        gain = self.set["gain"] * by_joint / (1 + self.set["gain"] * by_joint)
        change = np.diff(swept.momentum, prepend=self.momentum[None], axis=0)
        change /= np.where(by_joint > 0, by_joint, 1.0)
        change -= (rate + np.concatenate([self.rate[None], rate[:-1]])) / 2
        observed = cascade(1 - gain, gain * change, self.observed)
        friction = cascade(1 - gain, gain * friction, self.friction)
        share = by_joint / (self.set["window"] + by_joint)
        anchor = cascade(1 - share, share * run.q, self.anchor)
        low = np.minimum.accumulate(np.vstack([self.low, run.q]))[1:]
        high = np.maximum.accumulate(np.vstack([self.high, run.q]))[1:]
        slow, time = np.abs(qd) < self.set["rest_speed"], run.time[:, None]
        fast_at, slow_at = (
            np.maximum.accumulate(np.vstack([since, np.where(own, time, -np.inf)]))[1:]
            for own, since in ((~slow, self.fast_at), (slow, self.slow_at))
        )
        self.direction, self.observed, self.friction = direction[-1], observed[-1], friction[-1]
        self.anchor, self.low, self.high = anchor[-1], low[-1], high[-1]
        self.momentum, self.rate, self.fast_at, self.slow_at = (
            own[-1] for own in (swept.momentum, rate, fast_at, slow_at)
        )
        self.time, self.q, self.qd = run.time[-1], run.q[-1], qd[-1]
        moved = time - fast_at, (time - fast_at >= self.set["stop"]).all(axis=1), time - slow_at
        further = high - low, run.q - anchor, swept.jacobian, swept.place
        return Sensed(run.time, passed, qd, observed, friction, *moved, *further)

    def _velocities(self, run: Measured, passed: Array, first: bool) -> Array:
        """Return q̇ (M, n) [rad/s] by the filter of positions, for runs without measured q̇."""
        found = np.empty_like(run.q)
        for k, q in enumerate(run.q):
            self.passed = passed[k]
            found[k] = self.qd = self.velocity(q, first and k == 0)
            self.q = q
        return found

    def _judged(self, part: Sensed, learns: bool) -> Followed:
        """Return the answers to samples up to the first that is in contact or suspected; to all
        samples if nothing is learnt.
        """
        rested = self._rested(part, learns)
        before = np.array(rested[:-1])[:, None]
        state = self.states(part.slow_for, part.slow_ago, before, part.reach)
        # rested[1:] is 0 where the next sample moves
        rest = self._rest(part, before[:, 0] + part.passed * (part.at_rest & learns), learns)
        torque, drift, scale = self._slow(part, state, rest[:-1], learns)
        sensed = torque, state, part.qd, part.jacobian, part.place
        wrench, std, evidence, blind = self.weighed(*sensed)
        touched, doubtful = self._contacts(part, evidence)
        pull = self._pull(part, torque, state)
        felt, since = self._felt(part, state, pull)
        contact = touched | (felt & ~doubtful)
        suspected = contact | (evidence > self.set["freeze"])
        count = int(np.argmax(suspected)) + 1 if learns and suspected.any() else len(suspected)
        if suspected[:count].any():
            self.suspected_at = float(part.time[:count][suspected[:count]][-1])
        if (low := evidence[:count] < self.threshold).any():
            self.below_at = float(part.time[:count][low][-1])
        blind &= (state == STILL).all(axis=1)
        known, last = contact | ~(doubtful | blind), count - int(suspected[count - 1])
        self.touched, self.pull = bool(touched[count - 1]), pull[count - 1]
        self.felt_at, self.moved_at = since[count - 1]
        self.rested, self.rest = rested[last], rest[last]
        self.drift, self.scale = drift[last], scale[last]
        unsure = known & ~contact & (suspected | self.is_large(wrench))
        wrench, std = (
            self._sure(own, before, unsure)
            for own, before in ((wrench, self.answer.wrench), (std, self.answer.std))
        )
        self.answer = Answer(wrench[count - 1], std[count - 1], "")
        found = evidence, contact, known, torque, part.shift, state.astype(np.int8)
        return Followed._make(own[:count] for own in (wrench, std, *found))

    def _sure(self, stated: Array, before: Array, unsure: Mask) -> Array:
        """Return `stated` (M, 6) with the last sure row in place of unsure ones; before: (6,)."""
        rows = np.where(unsure, 0, np.arange(1, len(unsure) + 1))
        return np.vstack([before, stated])[np.maximum.accumulate(rows)]

    def _pull(self, part: Sensed, torque: Array, state: Any) -> Array:
        """Return the external torque (M, n) [Nm] at rest, low-passed: time constant `window`."""
        share = (part.passed / (self.set["window"] + part.passed))[:, None]
        return cascade(1 - share, share * np.where(state == STILL, torque, 0.0), self.pull)

    def _felt(
        self, part: Sensed, state: Any, pull: Array
    ) -> tuple[Mask, list[tuple[float, float]]]:
        """Return whether encoders feel a contact at each sample (M,), and at each sample the times
        [s] since when they do and when joints moved last.
        """
        moved, pushed = self.shifts(part.shift, pull)
        rests = (state == STILL).all(axis=1)
        felt, since = [], []
        for sample in zip(
            part.time.tolist(), rests.tolist(), moved.tolist(), pushed.tolist(), strict=True
        ):
            felt.append(self.feels(*sample))
            since.append((self.felt_at, self.moved_at))
        return np.array(felt), since

    def _rested(self, part: Sensed, learns: bool) -> list[float]:
        """Return the time (M + 1,) [s] that the arm has rested before each sample, and after the
        last.
        """
        rested = [self.rested]
        for still, passed in zip(part.at_rest, part.passed, strict=True):
            rested[-1] *= bool(still)
            rested.append(rested[-1] + float(passed) * bool(still and learns))
        return rested

    def _rest(self, part: Sensed, rested: Array, learns: bool) -> Array:
        """Return the learnt torque at rest (M + 1, n) [Nm], before each sample, after the last."""
        settles = rested <= self.set["settle"]
        share = part.passed / np.where(settles & (rested > 0), rested, self.set["slow"])
        share = (share * (part.at_rest & learns))[:, None]
        return np.vstack([self.rest, cascade(1 - share, share * part.observed, self.rest)])

    def _slow(self, part: Sensed, state: Any, rest: Array, learns: bool) -> tuple[Array, ...]:
        """Return the torque (M, n) [Nm] less slow errors, and their drift and scale (M + 1, n).

        Each sample changes the next: a Volterra equation, solved by fixed-point iteration.
        """
        per_scale = part.friction / (part.friction**2 + self.breakaway**2)
        share = part.passed[:, None] * (state == MOVING) * learns / self.set["slow"]
        drift, scale = self.drift + 0 * rest[:1], self.scale + 0 * rest[:1]
        before = np.full_like(rest, np.inf)
        while True:
            slow = drift[: len(rest)] + scale[: len(rest)] * part.friction
            torque = part.observed - np.where(state >= STILL, rest, slow)
            error = share * torque
            drift, scale = (
                np.cumsum(np.vstack([since, own]), axis=0)
                for since, own in ((self.drift, error), (self.scale, error * per_scale))
            )
            if np.allclose(torque, before, rtol=1e-13, atol=1e-12):
                return torque, drift, scale
            before = torque

    def _contacts(self, part: Sensed, evidence: Array) -> tuple[Mask, Mask]:
        """Return whether each sample (M,) is in a contact, and whether the evidence of a contact
        does not count at it, so that the answer may be unknown.
        """
        doubtful = part.time - self.started < self.set["settle"]
        doubtful |= self.is_fast(part.qd)
        low = np.where(evidence < self.threshold, part.time, -np.inf)
        below_at = np.maximum.accumulate(np.maximum(low, self.below_at))
        starts = ~doubtful & (part.time - below_at >= self.set["duration"])
        stays = evidence >= self.threshold - self.set["hysteresis"]
        contact, touched = [], self.touched
        for start, stay in zip(starts.tolist(), stays.tolist(), strict=True):
            touched = stay if touched else start
            contact.append(touched)
        return np.array(contact), doubtful


def cascade(kept: Array, added: Array, first: Array) -> Array:
    """Return x_k = kept_k x_(k-1) + added_k (M, ...) with x_(-1) = first (...), by doubling."""
    kept, found, step = kept.copy(), added + 0 * kept, 1
    found[0] += kept[0] * first
    while step < len(found):
        found[step:] = found[step:] + kept[step:] * found[:-step]
        kept[step:] = kept[step:] * kept[:-step]
        step *= 2
    return found
