"""Loads that are taken up or put down within a recording, found by gravity over time.

Efforts are explained by any links on the described axes, with friction and an offset of each joint:
what is constant is a part of these. A load from one time to another is not. Its rivals are a force
at the flange, and joints that take more or less on their own, as friction does, each for a while.
All are compared by their likelihood, over all sizes that they may have.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.channels import TARGET_CURRENT
from ur5lib.checks.block_means import FULL_FRICTION_SPEED, BlockMeans
from ur5lib.checks.whole_motion import WholeMotion
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, load_torque
from ur5lib.timeseries.arrays import Array, Labels

MIN_HELD = 3.0  # s; a load is held for longer, a push rarely
SAME_TIME = 1.0  # s
EDGES = 80  # times at which a cause may change, before the best ones are refined
MIN_MASS, MAX_MASS = 0.8, 40.0  # kg; friction that drifts looks like up to 0.6
MIN_ERRORS = 1.5  # of the mass, in standard errors
# Of log-likelihood, over nothing and over the best rival: `python -m benchmarks.grasps`
MIN_GAIN, MIN_LEAD = 12.0, 5.0
MASS_STD, MOMENT_STD = 5.0, 0.1  # kg, kg m, of loads before anything is seen
FORCE_STD, TURN_STD = 50.0, 5.0  # N, Nm, of pushes
RUBBING_SHARE = 0.05  # friction, and a rival's offset, of a motor's largest torque
MIN_REST = 3  # blocks; a joint that rests for so long may have any part of its friction
RIDGE = 1e-3  # of columns of unit size
MAX_LOADS = 5  # in one recording
NOISE_ROUNDS, MEDIAN_OF_NORMAL = 2, 0.6745
TORQUE_NOISE = 0.05  # Nm
SMALL = 1e-9


class HeldLoad(NamedTuple):
    """A load that is held from one time to another [s]: mass and its standard error [kg], and its
    lead in log-likelihood. start, end: None at the ends of the recording.
    """

    start: float | None
    end: float | None
    mass: float
    std_error: float
    lead: float

    def in_words(self, first: float) -> str:
        """Return mass and times in words; first: time of the first frame [s]."""
        begin = "" if self.start is None else f" from {number(self.start - first, '.1f')} s"
        end = "" if self.end is None else f" to {number(self.end - first, '.1f')} s"
        return f"{number(self.mass, '.1f')} ± {number(self.std_error, '.1f')} kg{begin}{end}"


class Cause(NamedTuple):
    """What may act for a while: columns (M, n, K) [Nm], standard deviations (K,) of coefficients
    before anything is seen, and how long it lasts at least [s].
    """

    columns: Array
    prior: Array
    lasts: float = 0.0


class Acting(NamedTuple):
    """A cause that acts on blocks from `first` until before `end`: its coefficients (K,) with
    standard errors, log-likelihood over nothing, and lead over the best rival.
    """

    first: int
    end: int
    solution: Array
    errors: Array
    gain: float
    lead: float = 0.0


class Spans:
    """A cause that acts in spans of blocks, and what always acts."""

    def __init__(self, cause: Cause, weight: Array, basis: Array, left: Array) -> None:
        """Sum the products up to each block; weight: (n,); basis: (M, n, P), of what always acts;
        left: (M, n), what it leaves of the efforts, both weighted.
        """
        columns, zero = cause.columns * weight[:, None], [(1, 0), (0, 0)]
        self.prior, self.lasts = cause.prior, cause.lasts
        self.right = np.pad(np.einsum("mjk,mj->mk", columns, left).cumsum(axis=0), zero)
        squares, shared = columns.mT @ columns, basis.mT @ columns
        self.squares = np.pad(squares.cumsum(axis=0), [*zero, (0, 0)])
        self.shared = np.pad(shared.cumsum(axis=0), [*zero, (0, 0)])

    def fits(self, first: Labels, end: Labels) -> tuple[Array, Array, Array]:
        """Return marginal log-likelihoods (S,) over nothing, coefficients (S, K) and standard
        errors (S, K) of spans of blocks from `first` until before `end`.

        Each change within the recording may be at any block, which makes it less likely.
        """
        right = self.right[end] - self.right[first]
        shared = self.shared[end] - self.shared[first]
        squares = self.squares[end] - self.squares[first] - shared.mT @ shared
        precision = squares + np.diag(self.prior**-2)
        covariance = np.linalg.inv(precision)
        solution = (covariance @ right[..., None])[..., 0]
        errors = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        widths = np.linalg.slogdet(precision)[1] / 2 + np.log(self.prior).sum()
        count = len(self.right) - 1
        changes = (first > 0).astype(float) + (end < count)
        gain = (right * solution).sum(axis=1) / 2 - widths - changes * np.log(count)
        return gain, solution, errors


class Search:
    """A search for loads that are held for a while, and their rivals."""

    def __init__(self, motion: WholeMotion, time: Array) -> None:
        """Take the motion of an arm with what it always carries, and its times (M,) [s]."""
        means, arm = motion.means, motion.arm
        self.time, self.independent = time, means.independent
        self.torque = motion.torque - motion.links
        rubbing = RUBBING_SHARE * np.array(arm.torque_limits())
        own = np.broadcast_to(np.eye(len(rubbing)), (*self.torque.shape, len(rubbing)))
        push = geometric_jacobian(arm, means.q).mT
        widths = np.array([MASS_STD, *[MOMENT_STD] * 3])
        self.load = Cause(load_torque(arm, means.q), widths, MIN_HELD)
        self.rivals = Cause(push, np.repeat([FORCE_STD, TURN_STD], 3)), Cause(own, rubbing)
        self.always = np.concatenate([motion.regressor, motion.friction, *_targets(motion)], axis=2)
        self.rests = _rests(means, rubbing)

    def likeliest(self, known: Sequence[Acting]) -> Acting | None:
        """Return the likeliest load in addition to known ones, None if none leads.

        The noise is what the load leaves, too, so that it does not hide itself.
        """
        one: Acting | None = None
        noise = np.ones(self.torque.shape[1])
        for _ in range(NOISE_ROUNDS):
            with_load = [*known, one] if one else known
            noise = _noise(self._columns(with_load), self.rests, self.torque, noise)
            weight = np.sqrt(self.independent) / noise
            left = weight, *beside(self._columns(known), self.rests, self.torque, weight)
            one = self._best(Spans(self.load, *left))
            if one is None or one.gain < 0:
                return None
        if one is None or one.gain < MIN_GAIN:
            return None
        others = (self._best(Spans(rival, *left), one) for rival in self.rivals)
        lead = one.gain - max(0.0, *(own.gain for own in others if own))
        return one._replace(lead=lead) if lead > MIN_LEAD else None

    def is_of(self, one: Acting, other: Acting) -> bool:
        """Return whether two loads change at the same times."""
        at = np.append(self.time, self.time[-1])
        return all(abs(at[a] - at[b]) < SAME_TIME for a, b in zip(one[:2], other[:2], strict=True))

    def _columns(self, known: Sequence[Acting]) -> Array:
        """Return the columns of what always acts, and of known loads, each in its time."""
        columns, blocks = [self.always], np.arange(len(self.time))[:, None, None]
        for one in known:
            columns.append(self.load.columns * ((blocks >= one.first) & (blocks < one.end)))
        return np.concatenate(columns, axis=2)

    def _best(self, spans: Spans, near: Acting | None = None) -> Acting | None:
        """Return a cause in its likeliest span, at first of few; near: a load, for a rival that
        acts at the same time.
        """
        count = len(self.time)
        edges = np.unique(np.linspace(0, count, EDGES + 1).astype(np.intp))
        coarse = self._best_of(spans, near, edges, edges)
        if coarse is None:
            return None
        step = int(np.diff(edges).max())
        around = np.arange(-step, step + 1)
        first, end = (np.clip(at + around, 0, count) for at in (coarse.first, coarse.end))
        return self._best_of(spans, near, np.unique(first), np.unique(end))

    def _best_of(
        self, spans: Spans, near: Acting | None, starts: Labels, ends: Labels
    ) -> Acting | None:
        """Return a cause in the likeliest span from one of some blocks to one of others."""
        at = np.append(self.time, self.time[-1])
        first, end = (part.ravel() for part in np.meshgrid(starts, ends, indexing="ij"))
        kept = (end > first) & ((first > 0) | (end < len(self.time)))
        kept &= at[end] - at[first] >= spans.lasts
        if near is None:  # what is there but for a moment does not change
            kept &= at[-1] - at[0] - (at[end] - at[first]) >= SAME_TIME
        else:
            kept &= (first < near.end) & (end > near.first)
        if not kept.any():
            return None
        first, end = first[kept], end[kept]
        gain, solution, errors = spans.fits(first, end)
        if near is None:
            mass, least = solution[:, 0], np.maximum(MIN_MASS, MIN_ERRORS * errors[:, 0])
            gain = np.where((mass > least) & (mass < MAX_MASS), gain, -np.inf)
        best = int(np.argmax(gain))
        if gain[best] == -np.inf:
            return None
        span = int(first[best]), int(end[best])
        return Acting(*span, solution[best], errors[best], float(gain[best]))


def held_loads(means: BlockMeans, arm: Robot) -> list[HeldLoad]:
    """Return the loads that are held for a part of a recording, in the order of their times.

    means: with `time`; arm: with the payload that it always carries. Empty where the recording is
    too short, or no gravity is described.
    """
    if not means.has_efforts() or not arm.tells_gravity():
        return []
    motion = WholeMotion(means, arm)
    time = motion.means.time
    if time is None or time[-1] - time[0] < 2 * MIN_HELD:
        return []
    search, found = Search(motion, time), list[Acting]()
    while len(found) < MAX_LOADS and (one := search.likeliest(found)):
        if any(search.is_of(one, own) for own in found):  # the ridge leaves a part of a load
            break
        found.append(one)
    return [_held(one, time) for one in sorted(found, key=lambda one: one.first)]


def _held(one: Acting, time: Array) -> HeldLoad:
    start = float(time[one.first]) if one.first > 0 else None
    end = float(time[one.end]) if one.end < len(time) else None
    return HeldLoad(start, end, float(one.solution[0]), float(one.errors[0]), one.lead)


def changed_loads(means: BlockMeans, arm: Robot, fitted: bool) -> Iterator[Finding]:
    """Find loads that are held for a part of a recording; a fit to it would take them for friction
    and constants. arm: with the declared payload.
    """
    loads = held_loads(means, arm)
    if not loads or means.time is None:
        return
    parts = ", ".join(one.in_words(float(means.time[0])) for one in loads)
    if fitted:
        detail = (
            f"the load changes: {parts}; cut it into entries with `from_s` and `to_s`, each with "
            "its `payload`, or give it the role validate"
        )
        yield contradiction(CauseCode.LOAD_CHANGES, "payload", detail)
        return
    detail = f"{parts}, unless the arm is pushed for so long: by gravity over time"
    yield Finding("robot", Found.LOAD_CHANGES, "warning", len(loads), detail)


def _targets(motion: WholeMotion) -> Iterator[Array]:
    """Yield columns (M, n, n) of the torques that the controller expects, if they were recorded."""
    means, joints = motion.means, np.eye(len(motion.joints))
    if TARGET_CURRENT in means.currents:
        torque = means.currents[TARGET_CURRENT] * motion.arm.maker_torque_constants()
        yield np.nan_to_num(torque)[:, :, None] * joints
    if means.torque is not None:
        yield means.torque[:, :, None] * joints


def _rests(means: BlockMeans, rubbing: Array) -> Array:
    """Return columns (M, n, R) of each joint's friction while it rests, in standard deviations."""
    columns = [np.zeros((0, *means.q.shape))]
    for joint, size in enumerate(rubbing):
        rests = np.abs(means.qd[:, joint]) < FULL_FRICTION_SPEED
        edges = np.flatnonzero(np.diff(rests, prepend=False, append=False)).reshape(-1, 2)
        for low, high in edges[edges[:, 1] - edges[:, 0] >= MIN_REST]:
            column = np.zeros((1, *means.q.shape))
            column[0, low:high, joint] = size
            columns.append(column)
    return np.moveaxis(np.concatenate(columns), 0, 2)


def _noise(columns: Array, rests: Array, torque: Array, noise: Array) -> Array:
    """Return the noise (n,) [Nm] of a torque (M, n) without columns (M, n, P): the median size of
    what they leave, so that a load of some seconds counts little. noise: a first guess.
    """
    for _ in range(NOISE_ROUNDS):
        basis, left = beside(columns, rests, torque, 1 / noise)
        free = 1 - (basis**2).sum() / torque.size
        sizes = np.median(np.abs(left), axis=0) / MEDIAN_OF_NORMAL / np.sqrt(max(free, 0.1))
        noise = np.hypot(noise * sizes, TORQUE_NOISE)
    return noise


def beside(columns: Array, rests: Array, torque: Array, weight: Array) -> tuple[Array, Array]:
    """Return a basis B (M, n, P) and what I - B Bᵀ leaves of a weighted torque (M, n): the best fit
    of columns (M, n, C), with a ridge, and rests (M, n, R), with coefficients of 0 ± 1.

    weight: (n,); rests do not overlap, so that each is taken out by itself: with the covariance
    I + r rᵀ, S = I - (1 - 1 / √(1 + r²)) r rᵀ / r² is the root of its inverse.
    """
    own = (rests * weight[:, None]).reshape(torque.size, rests.shape[2])
    length = np.sqrt((own**2).sum(axis=0)) + SMALL
    own /= length
    rest, root = length / np.sqrt(1 + length**2), 1 - 1 / np.sqrt(1 + length**2)
    flat = (columns * weight[:, None]).reshape(torque.size, columns.shape[2])
    flat -= own @ (root[:, None] * (own.T @ flat))
    size = np.sqrt((flat**2).mean(axis=0))
    unit = flat[:, size > SMALL] / size[size > SMALL]
    lower = np.linalg.cholesky(unit.T @ unit + RIDGE * torque.size * np.eye(unit.shape[1]))
    white = np.linalg.solve(lower, unit.T).T
    white -= own @ (root[:, None] * (own.T @ white))
    basis, values = np.concatenate([own * rest, white], axis=1), (torque * weight).ravel()
    left = values - basis @ (basis.T @ values)
    return basis.reshape(*torque.shape, -1), left.reshape(torque.shape)
