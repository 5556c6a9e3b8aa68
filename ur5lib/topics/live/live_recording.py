"""The live estimator on a recording: the answers of `Live.step`, computed in blocks of samples.

Quantities that depend only on measured samples are computed for a whole chunk. Slow errors of the
run are learnt only while no contact is suspected: a block is computed as if it learnt throughout,
and is cut at the first suspected sample. Recordings that differ only in their currents, as by trial
pushes, are followed side by side, each at its own pace within a chunk.
"""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np

from ur5lib.records.measured import Measured
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import Span, chunks, runs
from ur5lib.topics.live.live import (
    LEAST_LOOKS,
    LIKELY,
    LOOK,
    MOVING,
    NORMAL95,
    STILL,
    Live,
    Weights,
)

CHUNK = 1024  # samples; quantities of measured samples are computed for this many at once
BLOCK = 128  # samples; slow errors are learnt from this many at once
ABREAST = 64  # recordings that are followed side by side, for their memory


class Followed(NamedTuple):
    """The answers to N samples: wrench, std (N, 6) [N, Nm]; evidence (N,), log-odds of a contact;
    contact (N,); known (N,), whether contact is decided; torque [Nm], shift [rad], state (N, n);
    untouched, hidden, hidden_at_all (N, 3) [N], link, off_flange (N,), as of `Answer`;
    before_flange (N,), as of `Live`. The last six are zero where they were not asked for, and then
    contacts before the flange are not looked for.

    Of R recordings side by side, (N, R, ...).
    """

    wrench: Array
    std: Array
    evidence: Array
    contact: Mask
    known: Mask
    torque: Array
    shift: Array
    state: Any
    untouched: Array
    hidden: Array
    hidden_at_all: Array
    link: Labels
    off_flange: Array
    before_flange: Array

    def alarms(self) -> list[Span]:
        """Return (first, last) rows of each contact; last is exclusive."""
        return [(first, last) for first, last in runs(self.contact).tolist()]

    def of(self, recording: int) -> Self:
        """Return the answers to one of several recordings."""
        return type(self)._make(own[:, recording] for own in self)


class Sensed(NamedTuple):
    """Quantities of M samples that depend only on what was measured, not on what was learnt.

    (M, ...) each, but for observed, friction: (M, R, n) [Nm], of R recordings.
    """

    time: Array
    passed: Array
    qd: Array
    slow_for: Array
    at_rest: Mask
    slow_ago: Array
    reach: Array
    stops: Mask
    shift: Array
    jacobian: Array
    place: Array
    observed: Array
    friction: Array

    def at(self, rows: Labels, recordings: Labels) -> Self:
        """Return the samples `rows` (B, R) of some recordings (R,), as (B, R, ...)."""
        shared = (own[rows] for own in self[:-2])
        return type(self)._make([*shared, *(own[rows, recordings] for own in self[-2:])])


class Learnt(NamedTuple):
    """What R recordings have learnt before a sample, (R, ...) each, with the names of `Live`;
    wrench, std: of the last answer.
    """

    suspected_at: Array
    below_at: Array
    above_at: Array
    felt_at: Array
    moved_at: Array
    touched: Array
    rested: Array
    pull: Array
    rest: Array
    settled: Array
    drift: Array
    scale: Array
    wrench: Array
    std: Array

    @classmethod
    def at_start(cls, estimator: Live, recordings: int) -> Self:
        """Return what is known at the start of a run."""
        since = [*[estimator.time] * 3, np.inf, -np.inf, 0.0, 0.0]
        joints, (wrench, std, *_) = np.zeros((5, len(estimator.mass))), estimator.answer
        parts = [*map(np.array, since), *joints, wrench, std]
        return cls(*(np.repeat(own[None], recordings, axis=0) for own in parts))

    def at(self, recordings: Labels) -> Self:
        """Return what some recordings (K,) have learnt."""
        return type(self)._make(own[recordings] for own in self)

    def put(self, recordings: Labels, later: Self) -> None:
        """Set what some recordings (K,) have learnt."""
        for own, new in zip(self, later, strict=True):
            own[recordings] = new


def follow(arm: Mapping[str, Any], run: Measured, limited: bool = False) -> Followed:
    """Return the estimator's answers to a recording; arm: its file; limited: whether what a contact
    could be, and which link is touched, is wanted, too. An unusable sample repeats the last answer;
    after more than `max_gap` s of such samples, the answer is that of an estimator that has just
    started.
    """
    estimator = LiveRecording(arm)
    estimator.limited = limited
    return estimator.abreast(run, run.current[:, None], *estimator.used(run)).of(0)


def alarms_of_each(arm: Mapping[str, Any], run: Measured, currents: Array) -> list[list[Span]]:
    """Return the rows of each contact of R recordings, which are `run` with other currents (R, N,
    n) [A]; arm: as of `follow`.
    """
    estimator, found = LiveRecording(arm), dict[int, list[Span]]()
    used = [estimator.used(run._replace(current=current)) for current in currents]
    alike = dict[bytes, list[int]]()
    for number, (rows, _) in enumerate(used):
        alike.setdefault(rows.tobytes(), []).append(number)
    for own in alike.values():
        for part in chunks(len(own), ABREAST):
            together = currents[own[part]].swapaxes(0, 1)
            followed = estimator.abreast(run, together, *used[own[0]])
            found |= {number: followed.of(k).alarms() for k, number in enumerate(own[part])}
    return [found[number] for number in range(len(used))]


class LiveRecording(Live):
    """The estimator, given many samples at once; limited: whether to state untouched, hidden and
    link.
    """

    limited = False

    def abreast(self, run: Measured, currents: Array, rows: Labels, restarts: Mask) -> Followed:
        """Return the answers to R recordings, which are `run` with other currents (N, R, n) [A];
        rows, restarts: as of `used`, the same of all.
        """
        starts = [0, *(np.flatnonzero(restarts) + 1).tolist(), len(rows)]
        self.restart()
        self.rates: list[Array] = []
        parts = [self._nothing(currents.shape[1])]
        for first, last in pairwise(starts):
            self.restart()
            for begin in range(first, last, CHUNK):
                some = rows[begin : min(begin + CHUNK, last)]
                parts.append(self.chunk(run.at(some), currents[some]))
        answers = Followed._make(map(np.concatenate, zip(*parts, strict=True)))  # 0: a fresh start
        if self.limited:
            for first, last in pairwise(starts):
                self._locate(answers, first, run.at(rows[first:last]))
            self._withhold(answers)
        at = np.arange(len(run.time))
        latest = np.searchsorted(rows, at, side="right")
        missed = at - np.concatenate([[-1], rows])[latest]
        latest[missed * self.set["period"] > self.set["max_gap"]] = 0
        return Followed._make(own[latest] for own in answers)

    def _nothing(self, recordings: int) -> Followed:
        """Return the answers of an estimator that has just started, as one row."""
        wrench, std, *limits = (own[None] for own in self.answer if isinstance(own, np.ndarray))
        no, joints = np.zeros(1, bool), np.zeros((1, len(self.mass)))
        parts = wrench, std, 0.0 * no, no, no, joints, joints, joints.astype(np.int8), *limits
        parts += no.astype(np.int64), 0.0 * no, np.full(1, -np.inf if self.limited else 0.0)
        return Followed._make(np.repeat(own[:, None], recordings, axis=1) for own in parts)

    def _locate(self, answers: Followed, first: int, run: Measured) -> None:
        """Set contacts before the flange, and which link each contact touches.

        answers: to a fresh start and all samples; run: samples without a restart, from `first` on.
        """
        span = slice(first, first + len(run.time))
        qd = np.concatenate(self.rates)[span] if self.rates else run.q
        doubtful = (run.time - run.time[:1] < self.set["settle"]) | self.is_fast(qd)
        own = slice(span.start + 1, span.stop + 1)
        for recording in range(answers.contact.shape[1]):
            at = own, recording
            state, torque = answers.state[at], answers.torque[at]
            looked, density, odds, touched = self._looks(
                run, qd, torque, state, ~doubtful & ~self.rests(state)
            )
            answers.before_flange[at] = odds
            answers.contact[at] |= touched
            answers.known[at] |= touched
            for begin, end in runs(answers.contact[at]).tolist():
                some = slice(*np.searchsorted(looked, [begin, end]))
                shown = looked[some][LEAST_LOOKS - 1 :]
                if not len(shown):
                    continue
                count = np.arange(1, some.stop - some.start + 1)[:, None, None]
                mean = (np.cumsum(density[some], axis=0) / count)[LEAST_LOOKS - 1 :]
                times = np.diff(shown, append=end)
                for whole, new in zip(answers[-3:-1], self.touched_link(mean), strict=True):
                    whole[at][shown[0] : end] = np.repeat(new, times)

    def _withhold(self, answers: Followed) -> None:
        """State no wrench where the flange is unlikely, and that nothing is hidden in contact."""
        elsewhere = answers.off_flange >= LIKELY
        answers.wrench[elsewhere], answers.std[elsewhere] = 0.0, self.sizes.max(axis=0)
        answers.untouched[elsewhere] = NORMAL95 * answers.std[elsewhere][:, :3]
        for limit in (answers.hidden, answers.hidden_at_all):
            limit[answers.contact] = 0.0

    def _looks(
        self, run: Measured, qd: Array, torque: Array, state: Any, moves: Mask
    ) -> tuple[Labels, Array, Array, Mask]:
        """Return the samples (L,) at which a moving arm is looked at, densities at its places then
        (L, P, K), and at each sample (N,) the log-odds of a contact before the flange and whether
        there is one.
        """
        candidates, looked = np.flatnonzero(moves), list[int]()
        times, k = run.time[candidates], 0
        while k < len(times):
            looked.append(int(candidates[k]))
            k = int(np.searchsorted(times, times[k] + LOOK))
        at, broken = np.array(looked, np.int64), np.cumsum(~moves)
        swept = self.sweep(run.q[at], qd[at])
        weights = self.weights(state[at], qd[at], swept.jacobian)
        density = self.at_places(torque[at], weights.variance, swept)
        odds = self.odds_before(density, torque[at], weights)
        both, touched = np.full(len(moves), -np.inf), np.zeros(len(moves), bool)
        last, was, then = -np.inf, False, -1
        for row, until, now in zip(at, np.append(at, len(moves))[1:], odds.tolist(), strict=True):
            if broken[row] != then:
                last, was, then = -np.inf, False, broken[row]
            lower = min(last, now)
            last, was = now, self.stays(lower, now, was)
            shown = np.flatnonzero(broken[row:until] == then) + row
            both[shown], touched[shown] = lower, was
        return at, density, both, touched

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

    def chunk(self, run: Measured, currents: Array) -> Followed:
        """Return the answers to usable samples without a restart, continuing the last chunk."""
        sensed, (count, recordings, _) = self._sense(run, currents), currents.shape
        weighed = _Weighed(self, sensed)
        nothing = self._nothing(recordings)
        answers = Followed._make(np.repeat(own, count, axis=0) for own in nothing)
        first = np.zeros(recordings, np.int64)
        while len(some := np.flatnonzero(first < count)):
            rows = first[some] + np.arange(min(BLOCK, count - int(first[some].min())))[:, None]
            within, rows = rows < count, np.minimum(rows, count - 1)
            late = sensed.time[rows] - self.learnt.suspected_at[some] >= self.set["thaw"]
            most = (within & (late == late[0])).sum(axis=0)  # it learns throughout, or not at all
            rows = rows[: most.max()]
            before = self.learnt.at(some)
            count_of, found, learnt = self._judged(
                sensed.at(rows, some), weighed, rows, before, late[0], most
            )
            self.learnt.put(some, learnt)
            inside = np.nonzero(np.arange(len(rows))[:, None] < count_of)
            at = rows[inside], some[inside[1]]
            for own, new in zip(answers, found, strict=True):
                own[at] = new[inside]
            first[some] += count_of
        return answers

    def _sense(self, run: Measured, currents: Array) -> Sensed:
        """Return the quantities that depend only on samples, and update the state; currents: (M, R,
        n) [A].
        """
        if first := bool(np.isnan(self.time)):
            self.start(run.time[0])
            self.learnt = Learnt.at_start(self, currents.shape[1])
        passed = np.diff(run.time, prepend=self.time)
        by_joint = passed[:, None]
        qd = self._velocities(run, passed, first) if run.qd is None else run.qd
        kept = np.exp(-(np.abs(qd) * by_joint)[:, None] / self.distance)
        direction = cascade(kept, (1 - kept) * np.sign(qd)[:, None], self.direction)
        load, friction = self.gears(run.q[:, None], qd[:, None], currents, direction[:, None])
        swept = self.sweep(run.q, qd)
        rate = load + swept.rate[:, None]
        if first:
            self.friction, self.momentum, self.rate = friction[0], swept.momentum[0], rate[0]
            self.anchor = self.low = self.high = run.q[0]
        change = self._unexplained(swept.momentum, rate, by_joint)
        gain = (self.set["gain"] * by_joint / (1 + self.set["gain"] * by_joint))[:, None]
        observed = cascade(1 - gain, gain * change, self.observed)
        friction = cascade(1 - gain, gain * friction, self.friction)
        share = by_joint / (self.set["window"] + by_joint)
        anchor = cascade(1 - share, share * run.q, self.anchor)
        share = by_joint / (self.set["duration"] + by_joint)
        speed = cascade(1 - share, share * np.abs(qd), self.speed)
        low = np.minimum.accumulate(np.vstack([self.low, run.q]))[1:]
        high = np.maximum.accumulate(np.vstack([self.high, run.q]))[1:]
        slow, time = np.abs(qd) < self.set["rest_speed"], run.time[:, None]
        fast_at, slow_at = (
            np.maximum.accumulate(np.vstack([since, np.where(own, time, -np.inf)]))[1:]
            for own, since in ((~slow, self.fast_at), (slow, self.slow_at))
        )
        self.direction, self.observed, self.friction = direction[-1], observed[-1], friction[-1]
        self.anchor, self.low, self.high, self.speed = anchor[-1], low[-1], high[-1], speed[-1]
        self.momentum, self.rate, self.fast_at, self.slow_at = (
            own[-1] for own in (swept.momentum, rate, fast_at, slow_at)
        )
        self.time, self.q, self.qd = run.time[-1], run.q[-1], qd[-1]
        self.rates.append(qd)
        moved = time - fast_at, (time - fast_at >= self.set["stop"]).all(axis=1), time - slow_at
        reach, stops = high - low, self.stops(qd, speed)
        further = run.q - anchor, swept.jacobian, swept.place, observed, friction
        return Sensed(run.time, passed, qd, *moved, reach, stops, *further)

    def _unexplained(self, momentum: Array, rate: Array, passed: Array) -> Array:
        """Return what a rate (M, R, n) [Nm] leaves of the momentum's change; passed: (M, 1) [s]."""
        change = np.diff(momentum, prepend=self.momentum[None], axis=0)
        change /= np.where(passed > 0, passed, 1.0)
        return change[:, None] - (rate + np.concatenate([self.rate[None], rate[:-1]])) / 2

    def _velocities(self, run: Measured, passed: Array, first: bool) -> Array:
        """Return q̇ (M, n) [rad/s] by the filter of positions, for runs without measured q̇."""
        found = np.empty_like(run.q)
        for k, q in enumerate(run.q):
            self.passed = passed[k]
            found[k] = self.qd = self.velocity(q, first and k == 0)
            self.q = q
        return found

    def _judged(
        self,
        part: Sensed,
        weighed: "_Weighed",
        rows: Labels,
        before: Learnt,
        learns: Mask,
        most: Labels,
    ) -> tuple[Labels, Followed, Learnt]:
        """Return how many samples (R,) count, the answers to all samples, and what is learnt.

        Of a recording that learns, samples count up to the first that is in contact or suspected;
        of all others, `most` (R,).
        """
        rested = self._rested(part, before.rested, learns)
        state, weights = weighed.at(rows, rested[:-1] >= self.set["settle"])
        # rested[1:] is 0 where the next sample moves
        resting = rested[:-1] + part.passed * (part.at_rest & learns)
        rest = self._rest(part, resting, before.rest, learns)
        settled = self._settled(rest, resting, before.settled, part.at_rest & learns)
        torque, drift, scale = self._slow(part, state, rest[:-1], before, learns)
        evidence, by_size, mean = self.judged(torque, state, weights)
        wrench, std, blind = self.stated(by_size, mean, weights, part.place)
        touched, doubtful, above_at = self._contacts(part, evidence, before)
        pull = self._pull(part, torque, state, before.pull)
        still = (state == STILL).all(axis=-1)
        felt, felt_at, moved_at = self._felt(part, still, pull, before)
        contact = touched | (felt & ~doubtful)
        suspected = contact | (evidence > self.set["freeze"])
        number = np.arange(len(rows))[:, None]
        cut = learns & (suspected & (number < most)).any(axis=0)
        count = np.where(cut, suspected.argmax(axis=0) + 1, most)
        recordings = np.arange(len(count))
        last, then = (count - 1, recordings), (count - suspected[count - 1, recordings], recordings)
        known = contact | ~(doubtful | (blind & still))
        unsure = known & ~suspected & self.is_large(wrench)
        wrench, std = (
            _sure(own, since, unsure) for own, since in ((wrench, before.wrench), (std, before.std))
        )
        suspected_at, below_at = (
            np.where((number < count) & own, part.time, since).max(axis=0)
            for own, since in (
                (suspected, before.suspected_at),
                (evidence < self.threshold, before.below_at),
            )
        )
        times = suspected_at, below_at, *(own[last] for own in (above_at, felt_at, moved_at))
        slow = (own[then] for own in (rest, settled, drift, scale))
        since = *times, touched[last], rested[then], pull[last], *slow, wrench[last], std[last]
        presses = np.stack([rest - settled, rest], axis=-2)[:-1]
        limits = self._limited(part, state, std, contact, known, presses)
        found = evidence, contact, known, torque, part.shift, state.astype(np.int8), *limits
        found += np.zeros(contact.shape, np.int64), *np.zeros((2, *contact.shape))
        return count, Followed(wrench, std, *found), Learnt(*since)

    def _pull(self, part: Sensed, torque: Array, state: Any, before: Array) -> Array:
        """Return the external torque (B, R, n) [Nm] at rest, low-passed: time constant `window`."""
        share = (part.passed / (self.set["window"] + part.passed))[..., None]
        return cascade(1 - share, share * np.where(state == STILL, torque, 0.0), before)

    def _felt(
        self, part: Sensed, still: Mask, pull: Array, before: Learnt
    ) -> tuple[Mask, Array, Array]:
        """Return whether encoders feel a contact at each sample (B, R), as of `feels`, and the
        times [s] since when they do and when joints moved last.
        """
        moved, pushed = self.shifts(part.shift, pull)
        moving = np.where(~still | moved, part.time, -np.inf)
        moved_at = np.maximum.accumulate(np.concatenate([before.moved_at[None], moving]))
        stays = part.time - moved_at[:-1] > self.set["stays"]
        begins = np.where(still & pushed & stays, part.time, np.inf)
        # felt since the first beginning after the last end
        begins = np.concatenate([before.felt_at[None], begins])
        next_at = np.minimum.accumulate(begins[::-1])[::-1]
        ends = np.where(~still | (~moved & stays), np.arange(1, len(still) + 1)[:, None], 0)
        felt_at = np.take_along_axis(next_at, np.maximum.accumulate(ends), axis=0)
        felt_at[felt_at > part.time] = np.inf
        return part.time - felt_at >= self.set["confirmed"], felt_at, moved_at[1:]

    def _rested(self, part: Sensed, before: Array, learns: Mask) -> Array:
        """Return the time (B + 1, R) [s] that the arm has rested before each sample, and after the
        last.
        """
        rested = [before]
        for still, passed in zip(part.at_rest, part.passed, strict=True):
            rested[-1] = rested[-1] * still
            rested.append(rested[-1] + passed * (still & learns))
        return np.stack(rested)

    def _rest(self, part: Sensed, rested: Array, before: Array, learns: Mask) -> Array:
        """Return the learnt torque at rest (B + 1, R, n) [Nm], before each sample, after the
        last.
        """
        settles = rested <= self.set["settle"]
        share = part.passed / np.where(settles & (rested > 0), rested, self.set["slow"])
        share = (share * (part.at_rest & learns))[..., None]
        return np.concatenate([before[None], cascade(1 - share, share * part.observed, before)])

    def _settled(self, rest: Array, rested: Array, before: Array, rests: Mask) -> Array:
        """Return the torque (B + 1, R, n) [Nm] that was learnt while the rest settled; arguments as
        of `_rest`, whose result is the first.
        """
        settles = rests & (rested <= self.set["settle"])
        rows = np.where(settles, np.arange(1, len(rests) + 1)[:, None], 0)
        rows = np.maximum.accumulate(np.concatenate([0 * rows[:1], rows]))[..., None]
        return np.where(rows > 0, np.take_along_axis(rest, rows, axis=0), before)

    def _limited(
        self,
        part: Sensed,
        state: Any,
        std: Array,
        contact: Mask,
        known: Mask,
        presses: Array,
    ) -> tuple[Array, ...]:
        """Return untouched, hidden, hidden_at_all (B, R, 3) [N] of each sample, zero if they are
        not wanted.
        """
        if not self.limited:
            return (np.zeros((*contact.shape, 3)),) * 3
        free = self.limits(state, part.qd, part.jacobian, std, presses)
        nothing, band = np.zeros_like(free[0]), NORMAL95 * std[..., :3]
        by_word = zip(free, self.unlimited(std), (band, nothing, nothing), strict=True)
        touched, decided = contact[..., None], known[..., None]
        return tuple(
            np.where(touched, during, np.where(decided, own, unknown))
            for own, unknown, during in by_word
        )

    def _slow(
        self, part: Sensed, state: Any, rest: Array, before: Learnt, learns: Mask
    ) -> tuple[Array, ...]:
        """Return the torque (B, R, n) [Nm] less slow errors, and their drift and scale (B + 1, R,
        n).

        Each sample changes the next: a Volterra equation, solved by fixed-point iteration.
        """
        per_scale = part.friction / (part.friction**2 + self.breakaway**2)
        moves = (state == MOVING) & learns[:, None]
        share = part.passed[..., None] * moves / self.set["slow"]
        drift, scale = before.drift[None], before.scale[None]
        last = np.full_like(rest, np.nan)
        while True:
            slow = drift[: len(rest)] + scale[: len(rest)] * part.friction
            torque = part.observed - np.where(state >= STILL, rest, slow)
            error = share * torque
            drift, scale = (
                np.cumsum(np.concatenate([since[None], own]), axis=0)
                for since, own in ((before.drift, error), (before.scale, error * per_scale))
            )
            if (np.abs(torque - last) <= 1e-12 + 1e-13 * np.abs(last)).all():
                return torque, drift, scale
            last = torque

    def _contacts(self, part: Sensed, evidence: Array, before: Learnt) -> tuple[Mask, Mask, Array]:
        """Return whether each sample (B, R) is in a contact, whether the evidence of a contact does
        not count at it, so that the answer may be unknown, and when [s] it last was enough.
        """
        doubtful = part.time - self.started < self.set["settle"]
        doubtful |= self.is_fast(part.qd)
        least = self.threshold - self.set["hysteresis"]
        below_at, above_at = (
            np.maximum.accumulate(np.maximum(np.where(own, part.time, -np.inf), since))
            for own, since in (
                (evidence < self.threshold, before.below_at),
                (evidence >= least, before.above_at),
            )
        )
        lasts = np.where(part.stops, self.set["stopping"], self.set["duration"])
        starts = 1.0 * (~doubtful & (part.time - below_at >= lasts))
        stays = part.time - above_at <= self.set["release"]
        # it stays where it was touched before, and starts elsewhere
        return cascade(stays - starts, starts, before.touched) > 0, doubtful, above_at


class _Weighed:
    """The states of joints at M samples, and the weights of their torques, each computed once.

    A state depends on what was learnt only by whether a resting arm has settled.
    """

    def __init__(self, estimator: Live, sensed: Sensed) -> None:
        self.estimator, self.sensed = estimator, sensed
        ago = sensed.slow_for[:, None], sensed.slow_ago[:, None]
        rested = np.array([[0.0], [np.inf]])
        self.states = estimator.states(*ago, rested, sensed.reach[:, None])
        self.known = np.zeros(self.states.shape[:2], bool)
        self.kept: Weights | None = None

    def at(self, rows: Labels, settled: Mask) -> tuple[Any, Weights]:
        """Return states (B, R, n) and weights at samples `rows` (B, R); settled: (B, R)."""
        which = rows, settled.astype(np.int8)
        wanted = np.zeros_like(self.known)
        wanted[which] = True
        self._keep(np.nonzero(wanted & ~self.known))
        assert self.kept is not None
        return self.states[which], Weights._make(own[which] for own in self.kept)

    def _keep(self, which: tuple[Labels, ...]) -> None:
        if not len(which[0]):
            return
        measured = self.sensed.qd[which[0]], self.sensed.jacobian[which[0]]
        weights = self.estimator.weights(self.states[which], *measured)
        if self.kept is None:
            shape = self.known.shape
            self.kept = Weights._make(np.empty((*shape, *own.shape[1:])) for own in weights)
        for own, new in zip(self.kept, weights, strict=True):
            own[which] = new
        self.known[which] = True


def _sure(stated: Array, before: Array, unsure: Mask) -> Array:
    """Return `stated` (B, R, 6) with the last sure row in place of unsure ones; before: (R, 6)."""
    rows = np.where(unsure, 0, np.arange(1, len(unsure) + 1)[:, None])
    both = np.concatenate([before[None], stated])
    return np.take_along_axis(both, np.maximum.accumulate(rows)[..., None], axis=0)


def cascade(kept: Array, added: Array, first: Array) -> Array:
    """Return x_k = kept_k x_(k-1) + added_k (M, ...) with x_(-1) = first (...), by doubling."""
    kept, found, step = kept.copy(), added + 0 * kept, 1
    found[0] += kept[0] * first
    while step < len(found):
        found[step:] = found[step:] + kept[step:] * found[:-step]
        kept[step:] = kept[step:] * kept[:-step]
        step *= 2
    return found
