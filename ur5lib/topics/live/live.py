"""The force on a running arm from its motor currents, sample by sample, without any look ahead.

This file needs NumPy alone and may be copied away. `ur5 export --format live` writes what it
needs to know of an arm, and `--format live.hpp` the same estimator for C++.

    estimator = Live.load("arm.json")
    answer = estimator.step(time, q, qd, current)  # answer.wrench, answer.std, answer.contact

A momentum observer follows the external torque: of p = M q̇ and the torque l that the gears pass on,
dp/dt = l + Cᵀ q̇ - g + τ_ext. Less the slow errors of this run, τ_ext = Jᵀ F + noise; the noise is
that of each joint's state of motion, and F has a prior of several sizes. docs/live.md says what
`step` answers to which sample.
"""

import json
import re
from collections.abc import Mapping
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
STATES = ("moving", "reversing", "settling", "resting", "still", "unmoved")  # of a joint
MOVING, REVERSING, SETTLING, RESTING, STILL, UNMOVED = range(6)
STRIBECK_SPEEDS = {"slow": 0.01, "middle": 0.05, "fast": 0.2}  # rad/s, as of the study
TERMS = ["coulomb", "viscous", "velocity_root", "velocity_square", "periodic_sin", "periodic_cos"]
STRIBECK = {f"velocity_stribeck_{part}": speed for part, speed in STRIBECK_SPEEDS.items()}
TERMS += ["balance_sin", "balance_cos", *STRIBECK, "load"]  # of friction
FORMAT, DEEPEST, LEAST, MOST = "ur5lib live 5", 16, 1e-9, 1e9  # of a file: brackets, numbers
CONSTANTS = ["gain", "wide", "doubt", "duration", "slows", "stopping", "release", "thaw", "slow"]
CONSTANTS += ["settle", "stop", "reversal", "missed", "press", "rest_speed", "moved", "dead_zone"]
CONSTANTS += ["max_gap", "margin", "jump", "turns", "encoder", "acceleration", "window"]
CONSTANTS += ["confirmed", "stays", "large", "blind", "faster", "least_step", "period"]
FREE, SUSPECTED, CONTACT, UNKNOWN = "free", "suspected", "contact", "unknown"
NORMAL95, NORMAL99 = 1.96, 2.576  # so many standard deviations to either side have 95 %, 99 %
LOOK, LEAST_LOOKS = 0.05, 4  # s between looks at which link is touched; so many show it
# m between places on a link; of a tool beyond the flange; of a surface from the line of its link
SPACING, TOOL, SURFACE, MOST_PLACES = 0.1, 0.2, 0.05, 16
LOST = 0.15  # share of a contact's torque that a joint's gears lose or gain
AT_FLANGE, LIKELY = 0.75, 0.5  # probabilities: before torques are seen, and from which on it is not
PLACE_SIZES = 1.0, 3.0  # of contacts, in typical forces
FIRST_MOTION, LONGEST_MOTION = 1.0, 2.0  # s of motion, after and of which efforts are judged
CLEAR = 0.5  # of the mean loss of efforts
KINDS = {  # of effort, in words
    "current": "currents [A]",
    "torque": "torques [Nm]",
    "torque_less_gravity": "torques less gravity [Nm]",
}
UNUSABLE, STARTED, FAST, BLIND, ELSEWHERE = (  # why nothing is known, or no wrench
    "no usable sample came: all were lost, late, frozen, no numbers, or beyond what the arm can",
    "the run has just begun, so that friction may still settle",
    "a joint is faster than any that the study saw",
    "in this pose, resting joints hardly feel a force along some axis",
    "the arm is touched before its flange, so that no wrench at the flange is stated",
)
NEXT, LAST = np.array([1, 2, 0]), np.array([2, 0, 1])  # a × b = a[NEXT] b[LAST] - a[LAST] b[NEXT]


class Answer(NamedTuple):
    """The estimator's answer to a sample: the wrench, its standard deviation, and whether there is
    a contact.

    wrench: [F, n] (6,) [N, Nm], the environment acting on the arm, base axes, at the origin of the
    last frame; std: (6,); contact: "contact", "suspected", "free" or "unknown"; while the size of
    the force alone is suspect, wrench and std are those of the last sample without suspicion.

    link: the likeliest link of a contact in motion, from 1, after a few looks at it; off_flange:
    the probability that it is not the last one. Both are 0 until then. From LIKELY on, no wrench is
    stated: it is zero, with the widest band.

    Without a contact, along the axes of the base (3,) [N]: untouched, half of the 95 % band of the
    force if nothing has touched the arm since it came to rest; hidden, up to which a contact since
    then could be hidden, and hidden_at_all, also one that began before. In contact, half of the
    95 % band, and zero.
    """

    wrench: Array
    std: Array
    contact: str
    untouched: Array
    hidden: Array
    hidden_at_all: Array
    link: int
    off_flange: float


class Sweep(NamedTuple):
    """What one sweep along the arm yields for positions and velocities (...).

    momentum: p = M q̇ (..., n) [Nm s]; rate: Cᵀ q̇ - g (..., n) [Nm]; jacobian: (..., 6, n), of the
    place where contacts are assumed; place: (..., 3) [m], that place seen from the last frame's
    origin, base axes; gravity: g (..., n) [Nm]; frames: (..., n + 2, 3) [m], the origins of frames
    0 to n and the tip of a tool, seen from that place.
    """

    momentum: Array
    rate: Array
    jacobian: Array
    place: Array
    gravity: Array
    frames: Array


class Hidden(NamedTuple):
    """How the noise of torques hides a wrench, by K sizes P^½ of the wrench.

    weighted: S⁻¹ Jᵀ (..., n, 6); variance: diagonal of S (..., n) [N²m²]; covariance: of the wrench
    given a torque, (P⁻¹ + Λ)⁻¹ (..., K, 6, 6), Λ = J S⁻¹ Jᵀ; volume: log det(P⁻¹ + Λ) (..., K).
    """

    weighted: Array
    variance: Array
    covariance: Array
    volume: Array


class Weights(NamedTuple):
    """How noise hides a wrench: of a free arm (..., 2, ...), usual and wide; and of a contact."""

    free_weighted: Array
    free_variance: Array
    free_covariance: Array
    free_volume: Array
    weighted: Array
    variance: Array
    covariance: Array
    volume: Array


class Live:
    """The estimator of one arm of n joints.

    After each step, evidence is log p(τ | contact at the flange) / p(τ | free); before_flange: the
    same of a contact before it, as far as both of the last looks at a moving arm show one;
    observed, torque: the external torque (n,) [Nm], and the same less the slow errors of the run;
    state: (n,), of the joints.
    """

    def __init__(self, arm: Mapping[str, Any], input: str = "auto") -> None:
        """Take the content of an arm's file, which `ur5 export --format live` wrote.

        input: what is given as effort, one of KINDS; "auto": what the file states. Raises
        ValueError where the arm was identified in another unit.
        """
        names = ["rotation", "position", "mass", "center_of_mass", "inertia"]
        turns, tails, self.mass, self.center, self.inertia = (
            np.array([link[name] for link in arm["links"]], float) for name in names
        )
        self.joint = np.arange(len(self.mass))
        self.tail = np.tile(np.eye(4), (len(self.mass), 1, 1))
        self.tail[:, :3, :3], self.tail[:, :3, 3] = turns, tails
        self.weight = self.mass[:, None] * np.array(arm["gravity"], float)
        names = ["rotor_inertia", "torque_constant", "offset", "breakaway", "speed", "current"]
        self.rotor, self.constant, self.offset, self.breakaway, self.fastest, self.strongest = (
            np.array(arm[name], float) for name in names
        )
        rubs, parts = arm["friction"], arm["friction"]["presliding"]
        self.terms = {name: np.array(values, float) for name, values in rubs["terms"].items()}
        self.held = np.array([one["held"] for one in parts], float)
        self.distance, self.share = (
            np.array([[one[name]] for one in parts], float) for name in ("distance", "share")
        )
        self.noise, self.hidden, self.absorbed = (
            np.array([arm["noise"][name][state] for state in STATES], float)
            for name in ("std", "hidden", "absorbed")
        )
        self.threshold, contacts = float(arm["threshold"]["log_odds"]), arm["contacts"]
        self.threshold_before = float(arm["threshold"].get("before_flange", np.inf))
        self.shift = float(arm["noise"]["shift"])
        self.set, self.place = {**arm["constants"], **contacts}, np.array(contacts["place"], float)
        axes = [1, 1, 1, *[self.set["lever"]] * 3]
        self.sizes, self.quiet = (np.outer(self.set[name], axes) for name in ("sizes", "quiet"))
        self.usual = np.outer([self.set["typical"]], axes)
        some = self.set["typical"] * np.array(PLACE_SIZES)
        self.surface = np.outer(some, [1, 1, 1, *[SURFACE] * 3])
        self.spots, self.link_of, shares = spots(tails)
        self.likely = np.log(shares)[:, None] - 2 * np.log(some)  # p(size) falls as its square
        self.likely -= np.log(np.exp(self.likely).sum())
        self.is_before = self.link_of < len(self.mass)
        self.last: tuple[Array, Array] | None = None  # positions and currents
        self.input = arm.get("input", "") if input == "auto" else input
        self.efforts = Efforts(self, arm) if "input" in arm else None
        self.restart()

    @classmethod
    def load(cls, path: str | Path, input: str = "auto") -> "Live":
        """Return the estimator of a file. Raises ValueError where it is not as it was exported, or
        as of `Live`.
        """
        return cls(read_arm(Path(path).read_text(encoding="utf-8")), input)

    def restart(self) -> None:
        """Forget all that was learnt since the start: where the arm was, its contact, friction and
        background, and whether its efforts fit.
        """
        if self.efforts is not None:
            self.efforts.restart()
        self.forget()

    @property
    def refused(self) -> str:
        """Return why efforts are refused, "" if they are not."""
        return "" if self.efforts is None else self.efforts.refused

    def forget(self) -> None:
        """Begin a new run: forget all but whether the efforts fit."""
        n = len(self.mass)
        self.time, self.passed, self.run = np.nan, 0.0, 0.0  # [s]
        self.q, self.qd, self.lag, self.momentum, self.rate, self.observed = np.zeros((6, n))
        self.friction, self.drift, self.scale, self.torque = np.zeros((4, n))
        self.rest, self.settled = np.zeros((2, n))  # settled: the mean as a rest began
        self.anchor, self.pull, self.low, self.high, self.speed = np.zeros((5, n))
        self.direction = np.zeros((len(self.share), n))
        self.evidence, self.rested = 0.0, 0.0  # rested: seconds of the whole arm's rest
        self.touched, self.missed, self.state = False, 0, np.zeros(n, np.int64)
        self.moved_at, self.felt_at = -np.inf, np.inf
        self.look_at, self.looks, self.seen = -np.inf, 0, 0.0 * self.likely
        self.odds, self.before_flange, self.touched_before = -np.inf, -np.inf, False
        self.answer, self.reason = self.nothing(), UNUSABLE
        self.sure = self.answer.wrench, self.answer.std

    def nothing(self) -> Answer:
        """Return the answer where nothing is known."""
        widest = self.sizes.max(axis=0)
        return Answer(np.zeros(6), widest, UNKNOWN, *self.unlimited(widest), 0, 0.0)

    def start(self, time: float) -> None:
        """Begin a run at a time [s], as if all joints had just been fast, the evidence low, and a
        contact suspected.
        """
        self.time = self.started = self.below_at = self.above_at = self.suspected_at = time
        self.fast_at, self.slow_at = np.full((2, len(self.mass)), [[time], [-np.inf]])

    @np.errstate(all="ignore")
    def step(self, time: float, q: Any, qd: Any, current: Any) -> Answer:
        """Return the force after a sample: time [s]; q, qd, current (n,) [rad, rad/s, A].

        qd: None where the controller states no velocity; current: of the kind `input`, in Nm for
        torques. Never raises, and states no NaN; `reason` is why nothing is known. The arrays are
        the caller's own.
        """
        try:
            none = np.zeros(len(self.mass)) if qd is None else qd
            now, *values = float(real(time)), *map(real, (q, current, none))
        except Exception:  # a conversion of the caller's own may raise anything
            now, values = np.nan, [np.zeros(0)] * 3
        usable = self._usable(now, *values)
        self.missed = 0 if usable else self.missed + 1
        rates = None if qd is None else values[2]
        if usable:
            self._take(now, values[0], rates, values[1])
            rates = self.qd
        elif self.missed * self.set["period"] > self.set["max_gap"]:
            self.forget()
        if self.efforts is not None and rates is not None:
            self.efforts.step(now, values[0], rates, values[1])
        if self.refused:
            self.answer, self.reason = self.nothing(), self.refused
        parts = (own.copy() if isinstance(own, np.ndarray) else own for own in self.answer)
        return Answer._make(parts)

    def _usable(self, time: float, q: Array, current: Array, qd: Array) -> bool:
        """Return whether a sample is new and possible; restart where the clock jumped."""
        if not all(one.shape == self.mass.shape for one in (q, current, qd)):
            return False
        if not self.possible(time, q, current, qd):
            return False
        repeats = self.last is not None and bool(self.repeats(qd, q, current, *self.last))
        self.last = q, current
        if repeats or np.isnan(self.time):
            return not repeats
        passed = time - self.time
        if abs(passed) > self.set["max_gap"]:
            self.forget()
            return True
        most = self.set["margin"] * self.fastest * passed + self.set["jump"]
        return bool(passed >= self.set["least_step"] and (np.abs(q - self.q) <= most).all())

    def possible(self, time: Any, q: Array, current: Array, qd: Array) -> Any:
        """Return whether samples (...) are in the range of what this arm can show."""
        usual = (np.abs(time) < 1e12) & (np.abs(q) < self.set["turns"]).all(axis=-1)
        usual &= (np.abs(current) <= self.set["margin"] * self.strongest).all(axis=-1)
        return usual & (np.abs(qd) <= self.set["margin"] * self.fastest).all(axis=-1)

    def repeats(self, qd: Array, q: Array, current: Array, last_q: Array, last: Array) -> Any:
        """Return whether positions or currents (..., n) stay the same while the arm moves."""
        moves = (np.abs(qd) > self.set["rest_speed"]).any(axis=-1)
        return moves & ((q == last_q).all(axis=-1) | (current == last).all(axis=-1))

    def _take(self, time: float, q: Array, qd: Array | None, current: Array) -> None:
        """Update the state by a usable sample, and give the answer to it."""
        first = bool(np.isnan(self.time))
        if first:
            self.start(time)
        self.passed, self.run = time - self.time, time - self.started
        self.qd = self.velocity(q, first) if qd is None else qd
        self.time, self.q = time, q
        # Dahl: dz = |dq| / distance (sign dq - z), solved exactly; dq by q̇, as encoders are coarse
        kept = np.exp(-np.abs(self.qd) * self.passed / self.distance)
        self.direction = kept * self.direction + (1 - kept) * np.sign(self.qd)
        swept = self.sweep(q, self.qd)
        given = current + swept.gravity if self.input == "torque_less_gravity" else current
        load, friction = self.gears(q, self.qd, given, self.direction)
        rate = load + swept.rate
        if first:
            self.friction, self.momentum, self.rate = friction, swept.momentum, rate
            self.anchor = self.low = self.high = q
        share = self.passed / (self.set["window"] + self.passed)
        self.anchor = self.anchor + share * (q - self.anchor)
        self.low, self.high = np.minimum(self.low, q), np.maximum(self.high, q)
        share = self.passed / (self.set["duration"] + self.passed)
        self.speed = self.speed + share * (np.abs(self.qd) - self.speed)
        gain = self.set["gain"] * self.passed / (1 + self.set["gain"] * self.passed)
        change = (swept.momentum - self.momentum) / (self.passed or 1.0)
        change = change - (rate + self.rate) / 2
        self.observed = self.observed + gain * (change - self.observed)
        self.friction = self.friction + gain * (friction - self.friction)
        self.momentum, self.rate = swept.momentum, rate
        slow = np.abs(self.qd) < self.set["rest_speed"]
        self.fast_at = np.where(slow, self.fast_at, time)
        self.slow_at = np.where(slow, time, self.slow_at)
        self.stopped = bool((time - self.fast_at >= self.set["stop"]).all())
        self.rested *= self.stopped
        ago = time - self.fast_at, time - self.slow_at
        self.state = self.states(*ago, self.rested, self.high - self.low)
        self._judge(swept)
        self._learn()

    def velocity(self, q: Array, first: bool) -> Array:
        """Return q̇ (n,) [rad/s] by the steady Kalman filter of a joint of constant velocity, zero
        at the first sample.
        """
        if first:
            return np.zeros(len(q))
        # of Kalata's index λ = T² σ_a / σ_q, with r² = 1 - α, β = 2 (1 - r)²
        index = self.passed**2 * self.set["acceleration"] / self.set["encoder"]
        root = (4 + index - np.sqrt(index * (8 + index))) / 4
        innovation = self.lag + q - self.q - self.passed * self.qd
        self.lag = root**2 * innovation
        return np.asarray(self.qd + 2 * (1 - root) ** 2 / self.passed * innovation)

    def gears(self, q: Array, qd: Array, current: Array, direction: Array) -> tuple[Array, Array]:
        """Return the torque l that gears pass on to the links, and their friction (..., n) [Nm]."""
        z, sin, cos = (self.share * direction).sum(axis=-2), np.sin(q), np.cos(q)
        root, square = np.sqrt(np.abs(qd)) * np.sign(qd), np.abs(qd) * qd
        held = (self.held * direction).sum(axis=-2)
        friction = held * (1 - np.abs(np.tanh(qd / self.set["dead_zone"])))
        columns = z, qd, root, square, sin, cos, sin, cos  # of the first of TERMS
        for name, column in zip(TERMS, columns, strict=False):
            if name in self.terms:
                friction = friction + self.terms[name] * column
        for name, speed in STRIBECK.items():
            if name in self.terms:
                friction = friction + self.terms[name] * z * np.exp(-np.abs(qd) / speed)
        # k i = b + f + l + c z |l|
        motor = self.constant * current - self.offset
        load = (motor - friction) / (1 + self.terms["load"] * z * np.sign(motor - friction))
        return load, motor - load

    def sweep(self, q: Array, qd: Array) -> Sweep:
        """Return momentum, its rate but for the motors' part, and Jacobian, by one velocity sweep.

        Of the axes S_k of the joints, the twist V_k of link k, and the momentum H_k and weight W_k
        of the links from k on, about the base's origin: p_k = S_k · H_k,
        (Cᵀ q̇)_k = H_k · (V_k × S_k), g_k = -S_k · W_k.
        """
        n, turn = len(self.mass), np.zeros((*q.shape, 4, 4)) + np.eye(4)
        turn[..., 0, 0] = turn[..., 1, 1] = np.cos(q)
        turn[..., 0, 1], turn[..., 1, 0] = -np.sin(q), np.sin(q)
        poses, joints = np.zeros((*q.shape[:-1], n + 1, 4, 4)), turn @ self.tail
        poses[..., 0, :, :] = np.eye(4)
        for k in range(n):
            poses[..., k + 1, :, :] = poses[..., k, :, :] @ joints[..., k, :, :]
        axis, origin = poses[..., :n, :3, 2], poses[..., :n, :3, 3]
        axes = poses[..., :n, :3, :3] @ turn[..., :3, :3]
        arm = cross(origin, axis)
        omega, v = (np.cumsum(own * qd[..., None], axis=-2) for own in (axis, arm))
        center = origin + (axes @ self.center[..., None])[..., 0]
        linear = self.mass[:, None] * (v + cross(omega, center))
        spin = (axes @ (self.inertia @ (transposed(axes) @ omega[..., None])))[..., 0]
        spin += cross(center, linear)
        weight = np.broadcast_to(self.weight, center.shape)
        link = np.concatenate([spin, linear, cross(center, weight), weight], axis=-1)
        beyond = np.cumsum(link[..., ::-1, :], axis=-2)[..., ::-1, :]
        angular, linear = beyond[..., :3], beyond[..., 3:6]
        momentum = (axis * angular + arm * linear).sum(axis=-1) + self.rotor * qd
        rate = angular * cross(omega, axis) + linear * (cross(omega, arm) + cross(v, axis))
        gravity = -(axis * beyond[..., 6:9] + arm * beyond[..., 9:]).sum(axis=-1)
        place = poses[..., n, :3, :3] @ self.place
        lift = arm + cross(axis, poses[..., n:, :3, 3] + place[..., None, :])
        jacobian = transposed(np.concatenate([lift, axis], axis=-1))
        tip = poses[..., n:, :3, 3] + TOOL * poses[..., n:, :3, 2]
        frames = np.concatenate([poses[..., :3, 3], tip], axis=-2)
        frames -= poses[..., n:, :3, 3] + place[..., None, :]
        return Sweep(momentum, rate.sum(axis=-1) - gravity, jacobian, place, gravity, frames)

    def states(self, slow_for: Array, slow_ago: Array, rested: Any, reach: Array) -> Any:
        """Return the state (..., n) of each joint, as far as past samples show it; all in [s], but
        for reach: range of positions (..., n) [rad] since the start of the run.
        """
        stopped, slow = slow_for >= self.set["stop"], (slow_for > 0).all(axis=-1, keepdims=True)
        at_rest = np.where(slow, np.where(rested >= self.set["settle"], STILL, SETTLING), RESTING)
        moves = np.where(slow_ago <= self.set["reversal"], REVERSING, MOVING)
        state = np.where(stopped | slow, at_rest, moves)
        waits = ((state == REVERSING) | (state == RESTING)) & (reach <= self.set["moved"])
        return np.where(waits, UNMOVED, state)

    def _judge(self, swept: Sweep) -> None:
        """Set the answer: the wrench, its deviation, whether there is a contact, and where."""
        slow = self.drift + self.scale * self.friction
        self.torque = self.observed - np.where(self.state >= STILL, self.rest, slow)
        weights = self.weights(self.state, self.qd, swept.jacobian)
        evidence, touched, mean = self.judged(self.torque, self.state, weights)
        wrench, std, blind = self.stated(touched, mean, weights, swept.place)
        self.evidence = float(evidence)
        fast, rests = bool(self.is_fast(self.qd)), bool((self.state == STILL).all())
        doubtful = self.run < self.set["settle"] or fast
        self.at_flange = self._touches(doubtful, rests)
        likely, large = self.evidence > self.set["freeze"], bool(self.is_large(wrench))
        if self.at_flange:
            word = CONTACT
        elif doubtful or (rests and blind):
            word = UNKNOWN
        else:
            word = SUSPECTED if likely or large else FREE
        if word != SUSPECTED or likely:
            self.sure = wrench, std
        density = self._look(swept, weights, doubtful)
        if self.touched_before:
            word = CONTACT
        link, off_flange = self._located(word == CONTACT, density)
        wrench, std = self.sure if off_flange < LIKELY else (np.zeros(6), self.sizes.max(axis=0))
        limits = self._limits(word, swept.jacobian, std)
        self.answer = Answer(wrench, std, word, *limits, link, off_flange)
        self.reason = ELSEWHERE if off_flange >= LIKELY else ""
        if word == UNKNOWN:
            self.reason = FAST if fast else STARTED if doubtful else BLIND

    def _touches(self, doubtful: bool, rests: bool) -> bool:
        """Return whether torques or encoders show a contact at the flange; rests: whether all
        joints are still.
        """
        if self.evidence < self.threshold:
            self.below_at = self.time
        if self.evidence >= self.threshold - self.set["hysteresis"]:
            self.above_at = self.time
        if self.touched:
            self.touched = self.time - self.above_at <= self.set["release"]
        else:
            lasts = self.set["stopping" if self.stops(self.qd, self.speed) else "duration"]
            self.touched = not doubtful and self.time - self.below_at >= lasts
        share = self.passed / (self.set["window"] + self.passed)
        held = np.where(self.state == STILL, self.torque, 0.0)
        self.pull = self.pull + share * (held - self.pull)
        moved, pushed = self.shifts(self.q - self.anchor, self.pull)
        felt = self.feels(self.time, rests, bool(moved), bool(pushed))
        return bool(self.touched or (felt and not doubtful))

    def _look(self, swept: Sweep, weights: Weights, doubtful: bool) -> Array | None:
        """Update whether a moving arm is touched before its flange, each LOOK s; return the
        densities of the torque at all places then, None in between.
        """
        if doubtful or self.rests(self.state):
            self.odds, self.before_flange, self.touched_before = -np.inf, -np.inf, False
            return None
        if self.time < self.look_at:
            return None
        density = self.at_places(self.torque, weights.variance, swept)
        odds = float(self.odds_before(density, self.torque, weights))
        self.look_at, self.odds, self.before_flange = self.time + LOOK, odds, min(odds, self.odds)
        self.touched_before = self.stays(self.before_flange, odds, self.touched_before)
        return density

    def stays(self, both: float, last: float, before: bool) -> bool:
        """Return whether a contact before the flange begins, by the lower log-odds of the last two
        looks, or goes on, by those of the last one; before: whether there was one.
        """
        least = self.threshold_before - self.set["hysteresis"]
        return both >= self.threshold_before or (before and last >= least)

    def _located(self, contact: bool, density: Array | None) -> tuple[int, float]:
        """Return the likeliest link of a contact in motion, from 1, and the probability that it is
        not the last one, by the mean of what LEAST_LOOKS or more show; zeros without these.
        """
        if not contact:
            self.looks, self.seen = 0, 0.0 * self.likely
        elif density is not None:
            self.looks, self.seen = self.looks + 1, self.seen + density
        if self.looks < LEAST_LOOKS:
            return 0, 0.0
        link, off_flange = self.touched_link(self.seen / self.looks)
        return int(link), float(off_flange)

    def rests(self, state: Any) -> Any:
        """Return whether the whole arm is at rest; state: (..., n) of joints."""
        return (state[..., 0] == STILL) | (state[..., 0] == SETTLING)

    def at_places(self, torque: Array, variance: Array, swept: Sweep) -> Array:
        """Return log p(τ | place, size) (..., P, K), up to a constant, of a torque (..., n) [Nm]
        with noise of a variance (..., n) [N²m²].
        """
        point = self.spots @ swept.frames  # (..., P, 3), from where `jacobian` is
        column = transposed(swept.jacobian)[..., None, :, :]
        turn = column[..., 3:] + 0.0 * point[..., None, :]
        lift = column[..., :3] + cross(turn, point[..., None, :])
        loads = self.joint < self.link_of[:, None]  # joints before the place
        there = transposed(np.concatenate([lift, turn], axis=-1) * loads[..., None])
        noise = variance + (LOST * torque) ** 2
        hidden = hidden_by(noise[..., None, :], there, self.surface)
        return self._by_size(torque[..., None, :], hidden, self.surface)[0]

    def odds_before(self, density: Array, torque: Array, weights: Weights) -> Array:
        """Return log p(τ | contact before the flange) / p(τ | free) (...); density: as of
        `at_places`.
        """
        prior = self.likely[self.is_before]
        shown = density[..., self.is_before, :] + prior
        most = shown.max(axis=(-2, -1), initial=-np.inf)
        share = np.exp(shown - most[..., None, None]).sum(axis=(-2, -1)) / np.exp(prior).sum()
        return most + np.log(share) - self.free(torque, weights)

    def touched_link(self, density: Array) -> tuple[Any, Array]:
        """Return the likeliest link (...), from 1, and the probability (...) that it is not the
        last one, which counts as a link before it from LIKELY on; density: as of `at_places`, mean
        of a contact's samples.
        """
        shown = density + self.likely
        weight = np.exp(shown - shown.max(axis=(-2, -1), keepdims=True)).sum(axis=-1)
        links = np.arange(1, len(self.mass) + 1)
        by_link = weight @ (self.link_of[:, None] == links)
        off_flange = np.asarray(1 - by_link[..., -1] / by_link.sum(axis=-1))
        by_link[..., -1] *= off_flange < LIKELY
        return by_link.argmax(axis=-1) + 1, off_flange

    def _limits(self, word: str, jacobian: Array, std: Array) -> tuple[Array, Array, Array]:
        """Return the limits (3,) [N] of an answer: untouched, hidden, hidden_at_all."""
        if word == UNKNOWN:
            return self.unlimited(std)
        if word == CONTACT:
            return NORMAL95 * std[:3], np.zeros(3), np.zeros(3)
        presses = np.stack([self.rest - self.settled, self.rest])
        return self.limits(self.state, self.qd, jacobian, std, presses)

    def unlimited(self, std: Array) -> tuple[Array, Array, Array]:
        """Return the limits (..., 3) [N] of an answer that knows nothing; std: (..., 6)."""
        most = NORMAL99 * self.sizes.max(axis=0)[:3] + 0.0 * std[..., :3]
        return NORMAL95 * std[..., :3], most, most.copy()

    def limits(
        self, state: Any, qd: Array, jacobian: Array, std: Array, presses: Array
    ) -> tuple[Array, Array, Array]:
        """Return the limits (..., 3) [N] of an answer without contact: untouched, hidden,
        hidden_at_all.

        presses: (..., 2, n) [Nm], the torque of a slow press since the arm came to rest, and since
        before, if the background at rest is one.
        """
        joints, still = (state, self.joint), (state == STILL).all(axis=-1)
        noise = self.noise[joints] * np.maximum(np.abs(qd) / self.fastest, 1.0)
        sticks = np.hypot(self.hidden[joints], self.absorbed[joints]) * still[..., None]
        hiding = self.set["missed"] * self.set["doubt"] * np.hypot(noise, sticks)
        # along one axis, with the torque x = Jᵀ F: 1 / C = 1 / P + Σ (x / κ σ)²
        seen = ((jacobian[..., :3, :] / hiding[..., None, :]) ** 2).sum(axis=-1)
        missed = (self.set["typical"] ** -2.0 + seen) ** -0.5
        untouched, press = NORMAL95 * std[..., :3], np.zeros((*presses.shape[:-1], 3))
        rests, doubt, settled = jacobian[still], self.set["doubt"], self.noise[STILL] ** 2
        spread = np.diagonal(hidden_by(settled, rests, self.usual).covariance, axis1=-2, axis2=-1)
        own = NORMAL95 * doubt * np.sqrt(spread[:, 0, :3])
        untouched[still] = np.minimum(untouched[still], own)
        slow = hidden_by(settled, rests, self.set["press"] * self.usual)
        told = transposed(slow.weighted) @ transposed(presses[still])
        press[still] = transposed(slow.covariance[:, 0] @ told)[..., :3]
        hidden = NORMAL99 * np.hypot(missed[..., None, :], doubt * press)
        return untouched, hidden[..., 0, :], hidden[..., 1, :]

    def stops(self, qd: Array, speed: Array) -> Any:
        """Return whether a joint (...) is much slower than its mean speed until now (..., n)."""
        moved = speed > self.set["rest_speed"]
        return (moved & (np.abs(qd) < self.set["slows"] * speed)).any(axis=-1)

    def is_fast(self, qd: Array) -> Any:
        """Return whether a joint is faster (..., n) than the noise that the study saw covers."""
        return (np.abs(qd) > self.set["faster"] * self.fastest).any(axis=-1)

    def is_large(self, wrench: Array) -> Any:
        """Return whether the force of a wrench (..., 6) is more than that of a free arm."""
        return np.linalg.norm(wrench[..., :3], axis=-1) > self.set["large"] * self.set["typical"]

    def shifts(self, shift: Array, pull: Array) -> tuple[Any, Any]:
        """Return whether any joint moved, and whether one moved without a pull of its motor in that
        direction.

        shift: (..., n) [rad] of a resting arm, within a fraction of a second; pull: external torque
        (..., n) [Nm] before. A joint that its motor pulls to breakaway creeps, or hunts.
        """
        moved = np.abs(shift) > self.shift
        alone = -pull * np.sign(shift) < self.breakaway
        return moved.any(axis=-1), (moved & alone).any(axis=-1)

    def feels(self, time: float, rests: bool, moved: bool, pushed: bool) -> bool:
        """Return whether encoders of a resting arm feel a contact: from a first push until its
        joints stay, so that the release ends it.
        """
        if not rests:
            self.felt_at, self.moved_at = np.inf, time
        elif moved:
            if pushed and time - self.moved_at > self.set["stays"]:
                self.felt_at = min(self.felt_at, time)
            self.moved_at = time
        elif time - self.moved_at > self.set["stays"]:
            self.felt_at = np.inf
        return bool(time - self.felt_at >= self.set["confirmed"])

    def weights(self, state: Any, qd: Array, jacobian: Array) -> Weights:
        """Return what joints show of a contact by their states, speeds and posture, whatever their
        torques.
        """
        own, unseen = (state, self.joint), np.maximum(np.abs(qd) / self.fastest, 1.0)
        variance = (self.noise[own] * unseen) ** 2
        # a free arm: its noise, and now and then a wider one
        both = np.stack([variance, self.set["wide"] ** 2 * variance], axis=-2)
        free = hidden_by(both, jacobian[..., None, :, :], self.quiet)
        # of a contact at rest, dry friction takes a part
        touched = hidden_by(variance + self.hidden[own] ** 2, jacobian, self.sizes)
        return Weights(*free, *touched)

    def judged(self, torque: Array, state: Any, weights: Weights) -> tuple[Array, Array, Array]:
        """Return the evidence (...) of a contact; by size of the contact, the log-density of the
        torque (..., K), and the wrench (..., K, 6).
        """
        carried = torque + self.absorbed[state, self.joint] * np.tanh(torque / self.breakaway)
        touched, mean = self._by_size(carried, Hidden(*weights[4:]), self.sizes)
        largest = touched.max(axis=-1)
        evidence = largest + np.log(np.exp(touched - largest[..., None]).mean(axis=-1))
        return evidence - self.free(torque, weights), touched, mean

    def free(self, torque: Array, weights: Weights) -> Array:
        """Return log p(τ | free) (...), up to a constant."""
        both = self._by_size(torque[..., None, :], Hidden(*weights[:4]), self.quiet)[0]
        free, wide = both[..., 0, 0], both[..., 1, 0]
        return np.logaddexp(np.log(1 - self.set["rare"]) + free, np.log(self.set["rare"]) + wide)

    def stated(
        self, touched: Array, mean: Array, weights: Weights, place: Array
    ) -> tuple[Array, Array, Any]:
        """Return the wrench and its deviation (..., 6), and whether the joints would not notice
        even a large force along some axis; touched, mean: as of `judged`.
        """
        spread = np.diagonal(weights.covariance, axis1=-2, axis2=-1)
        blind = spread[..., -1, :3].max(axis=-1) > (self.set["blind"] * self.set["typical"]) ** 2
        weight = np.exp(touched - touched.max(axis=-1)[..., None])
        weight *= self.sizes[:, 0] >= self.set["typical"]
        weight = (weight / weight.sum(axis=-1, keepdims=True))[..., None]
        wrench, square = (weight * mean).sum(axis=-2), (weight * (spread + mean**2)).sum(axis=-2)
        variance = np.maximum(square - wrench**2, 0.0)
        # from the place of the contact to the last frame: n + p × F
        force, spread = wrench[..., :3], variance[..., :3]
        wrench[..., 3:] += cross(place, force)
        lifted = (
            place[..., NEXT] ** 2 * spread[..., LAST] + place[..., LAST] ** 2 * spread[..., NEXT]
        )
        variance[..., 3:] += lifted
        return wrench, self.set["doubt"] * np.sqrt(variance), blind

    def _by_size(self, torque: Array, hidden: Hidden, sizes: Array) -> tuple[Array, Array]:
        """Return the log-density of the torque (..., K), and the mean wrench (..., K, 6).

        F = (P⁻¹ + Λ)⁻¹ J S⁻¹ τ.
        """
        told = transposed(hidden.weighted) @ torque[..., None]
        mean = (hidden.covariance @ told[..., None, :, :])[..., 0]
        variance = hidden.variance
        alone = (torque**2 / variance + np.log(variance)).sum(axis=-1)[..., None]
        misfit = alone - (mean @ told)[..., 0] + 2 * np.log(sizes).sum(axis=-1)
        return -(misfit + hidden.volume) / 2, mean

    def _learn(self) -> None:
        """Adapt the run's friction and background to a sample, unless a contact is suspected or was
        until shortly before.
        """
        if self.at_flange or self.evidence > self.set["freeze"]:
            self.suspected_at = self.time
        if self.time - self.suspected_at < self.set["thaw"]:
            return
        share = self.passed / self.set["slow"]
        error = np.where(self.state == MOVING, share * self.torque, 0.0)
        self.drift = self.drift + error
        self.scale = self.scale + error * self.friction / (self.friction**2 + self.breakaway**2)
        # at rest: the mean of what settles, then a slow one
        if self.stopped:
            self.rested += self.passed
            settles = self.rested <= self.set["settle"]
            share = self.passed / self.rested if settles else share
            self.rest = self.rest + share * (self.observed - self.rest)
            self.settled = self.rest if settles else self.settled


class Efforts:
    """Which kind of effort is given: the one that is expected, or one that fits far better.

    Of each kind, the observer of `Live`, without what the run learns, gives an external torque τ,
    which is nearly zero for the right one: by the mean of log(1 + (τ / σ)²) over motion, which a
    contact or a wrong load changes little. refused: why efforts do not fit, "" if they do, or
    nobody knows yet.
    """

    def __init__(self, arm: Live, file: Mapping[str, Any]) -> None:
        """Take the arm's estimator and file. Raises ValueError where `input` is of another unit."""
        self.arm, names = arm, [*KINDS]
        both = {arm.input, file["input"]}
        if arm.input not in names or ("current" in both and len(both) > 1):
            raise ValueError(misfit(arm.input, file["input"]))
        self.own, in_amperes = names.index(arm.input), file["input"] == "current"
        motor = np.array(file["motor_constant"], float)
        ones = np.ones_like(motor)
        factors = [ones, 1 / motor, 1 / motor] if in_amperes else [motor, ones, ones]
        self.factors = np.array(factors)  # (kinds, n), to the unit of the arm's constants
        self.restart()

    def restart(self) -> None:
        """Forget all samples."""
        n, kinds = len(self.arm.mass), len(KINDS)
        self.time, self.motion, self.loss = np.nan, 0.0, np.zeros(kinds)
        self.direction, self.momentum = np.zeros((len(self.arm.share), n)), np.zeros(n)
        self.rate, self.observed = np.zeros((2, kinds, n))
        self.fit, self.refused = False, ""

    def step(self, time: float, q: Array, qd: Array, effort: Array) -> None:
        """Take a sample, as of `Live.step`, whether or not its effort can be the arm's."""
        arm = self.arm
        if not all(one.shape == arm.mass.shape for one in (q, qd, effort)):
            return
        if not (np.isfinite(effort).all() and arm.possible(time, q, 0 * effort, qd)):
            return
        if abs(time - self.time) > arm.set["max_gap"]:
            self.restart()
        passed, first = time - self.time, np.isnan(self.time)
        if self.fit or passed < arm.set["least_step"]:
            self.time = time if passed > 0 else self.time
            return
        self.time = time
        kept = np.exp(-np.abs(qd) * (0.0 if first else passed) / arm.distance)
        self.direction = kept * self.direction + (1 - kept) * np.sign(qd)
        swept = arm.sweep(q, qd)
        given = self.factors * [effort, effort, effort + swept.gravity]
        rate = arm.gears(q, qd, given, self.direction)[0] + swept.rate
        if not first:
            gain = arm.set["gain"] * passed / (1 + arm.set["gain"] * passed)
            change = (swept.momentum - self.momentum) / passed - (rate + self.rate) / 2
            self.observed = self.observed + gain * (change - self.observed)
            self._weigh(passed, qd)
        self.momentum, self.rate = swept.momentum, rate

    def _weigh(self, passed: float, qd: Array) -> None:
        """Add a sample to the loss of each kind, and decide."""
        arm, slow = self.arm, np.abs(qd) < self.arm.set["rest_speed"]
        if slow.all():
            return
        std = np.where(slow, arm.noise[RESTING] + arm.breakaway, arm.noise[MOVING])
        self.motion += passed
        self.loss = self.loss + passed * np.log1p((self.observed / std) ** 2).mean(axis=1)
        if self.motion < FIRST_MOTION:
            return
        mean = self.loss / self.motion
        best = int(np.where(np.arange(len(mean)) == self.own, np.inf, mean).argmin())
        if mean[best] - mean[self.own] > CLEAR:
            self.fit, self.refused = True, ""
        elif mean[self.own] - mean[best] > CLEAR:
            names = [*KINDS]
            self.refused = misfit(names[best], names[self.own])
        if self.motion > LONGEST_MOTION:
            self.motion, self.loss = LONGEST_MOTION, LONGEST_MOTION * mean


def misfit(given: str, own: str) -> str:
    """Return why efforts of a kind are refused where `own` is expected, and what to do."""
    if given not in KINDS:
        return f"unknown input {given!r}; available: auto, {', '.join(KINDS)}"
    remedy = f"give `input` as {given}"
    if "current" in (given, own):
        wanted = "currents (a UR's: use_currents_as_efforts)" if own == "current" else "torques"
        remedy = f"let the driver publish {wanted}, or identify the arm by such efforts"
    return f"efforts are {KINDS[given]}, but {KINDS[own]} are expected; {remedy}"


def real(values: Any) -> Array:
    """Return numbers as a new array. Raises TypeError for complex ones."""
    found = np.asarray(values)
    if found.dtype == object:
        found = np.array(found.tolist())
    if np.iscomplexobj(found):
        raise TypeError
    return np.array(found, float)


def hidden_by(variance: Array, jacobian: Array, sizes: Array) -> Hidden:
    """Return how noise of these variances (..., n) [N²m²] hides a wrench; sizes: P^½ (K, 6)."""
    lift = transposed(jacobian)
    weighted = lift / variance[..., None]
    seen = (transposed(weighted) @ lift)[..., None, :, :]
    information = seen + sizes[:, None] ** -2.0 * np.eye(6)
    covariance = np.asarray(np.linalg.inv(information), np.float64)
    return Hidden(weighted, variance, covariance, np.log(np.linalg.det(information)))


def spots(tails: Array) -> tuple[Array, Any, Array]:
    """Return P places on an arm's links, as weights (P, n + 2) of the origins of frames 0 to n and
    a tool's tip, their links (P,), from 1, and probabilities (P,) before torques are seen.

    tails: (n, 3) [m], from each frame to the next. Places are middles of equal parts of the line
    between frames, on the last link of that of a tool: parts of at most SPACING, or MOST_PLACES.
    """
    last, rows, links, shares = len(tails), [], [], []
    for link, length in enumerate([*np.linalg.norm(tails[:-1], axis=1), TOOL], start=1):
        count = int(min(np.ceil(length / SPACING - 1e-9), MOST_PLACES))
        for part in (np.arange(count) + 0.5) / count:
            first = link if link == last else link - 1
            rows.append((1 - part) * np.eye(last + 2)[first] + part * np.eye(last + 2)[first + 1])
            links.append(link)
            own = AT_FLANGE if link == last else (1 - AT_FLANGE) / max(1, last - 1)
            shares.append(own / count)
    return np.array(rows), np.array(links), np.array(shares)


def transposed(matrix: Array) -> Array:
    """Return the transpose of matrices (..., m, n); NumPy before 2.0 has no `mT`."""
    return matrix.swapaxes(-1, -2)


def cross(a: Array, b: Array) -> Array:
    """Return a × b of vectors (..., 3)."""
    return np.asarray(a.take(NEXT, -1) * b.take(LAST, -1) - a.take(LAST, -1) * b.take(NEXT, -1))


def read_arm(text: str) -> dict[str, Any]:
    """Return the content of an arm's file; text: of the file. Raises ValueError where a number is
    missing, or cannot be right.
    """
    bare = re.sub(r'"(?:[^"\\]|\\.)*"', "", text, flags=re.DOTALL)
    if max(accumulate((c in "[{") - (c in "]}") for c in bare), default=0) > DEEPEST:
        refuse("brackets in brackets")
    once = lambda pairs: dict(pairs) if len(dict(pairs)) == len(pairs) else refuse("a key, twice")  # noqa: E731
    hooks: Any = {"parse_int": float, "parse_constant": refuse, "object_pairs_hook": once}
    arm: dict[str, Any] = json.loads(text, **hooks)
    try:
        rubs, sizes = arm["friction"], arm["contacts"]["sizes"]
        lengths = len(arm["links"]), len(rubs["presliding"]), len(sizes)
        terms = {*TERMS} & {"coulomb", "load", *rubs["terms"]}
        check(arm, expected(*lengths, terms, "before_flange" in arm["threshold"]), "arm")
    except (KeyError, TypeError) as error:
        refuse(str(error))
    lost = max(map(abs, rubs["terms"]["load"])) * sum(one["share"] for one in rubs["presliding"])
    if arm.get("format") != FORMAT or lost >= 1 or max(sizes) < arm["contacts"]["typical"]:
        refuse("format, load, or typical")
    if arm.get("input") not in [*KINDS]:
        refuse("input")
    return arm


def expected(links: int, parts: int, sizes: int, terms: set[str], looks: bool) -> dict[str, Any]:
    """Return the range of each number that the estimator needs, in the place of the number; looks:
    whether it states contacts before the flange.
    """
    if not (0 < links <= 8 and 0 < parts <= 4 and 0 < sizes <= 8):
        refuse("links, presliding or sizes")
    some, part, positive = (-MOST, MOST), (0.0, MOST), (LEAST, MOST)
    vector, joints, above = [some] * 3, [some] * links, [positive] * links
    matrices: Any = dict.fromkeys(("rotation", "inertia"), [vector] * 3)
    link = dict.fromkeys(("position", "center_of_mass"), vector) | {"mass": part, **matrices}
    own = dict.fromkeys(("torque_constant", "breakaway", "speed", "current"), above)
    own |= dict.fromkeys(("rotor_inertia", "offset"), joints) | {"motor_constant": above}
    dahl = {"distance": positive, "share": part, "held": joints}
    constants = dict.fromkeys(CONSTANTS, positive) | dict.fromkeys(("freeze", "hysteresis"), some)
    typical = {"place": vector, "lever": positive, "typical": positive, "sizes": [positive] * sizes}
    noise: Any = dict.fromkeys(("absorbed", "hidden"), dict.fromkeys(STATES, [part] * links))
    return own | {
        "links": [link] * links,
        "gravity": vector,
        "friction": {"terms": dict.fromkeys(terms, joints), "presliding": [dahl] * parts},
        "noise": noise | {"std": dict.fromkeys(STATES, above), "shift": positive},
        "threshold": {"log_odds": some} | ({"before_flange": some} if looks else {}),
        "constants": constants | {"rare": (LEAST, 1 - LEAST), "quiet": [positive]},
        "contacts": typical,
    }


def check(value: Any, right: Any, place: str) -> None:
    """Raise ValueError where a value lacks a part, or a number is out of its range."""
    if isinstance(right, dict):
        for key, own in right.items():
            check(value.get(key) if isinstance(value, dict) else None, own, key)
    elif isinstance(right, list) and isinstance(value, list) and len(right) == len(value):
        for one, own in zip(value, right, strict=True):
            check(one, own, place)
    elif isinstance(right, list) or not (
        isinstance(value, float) and right[0] <= value <= right[1]
    ):
        refuse(place)


def refuse(what: str) -> Any:
    """Raise ValueError."""
    raise ValueError(f"{what}: not as `ur5 export --format live` writes it; export the file again")
