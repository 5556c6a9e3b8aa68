"""Low-passed, thinned samples of recordings for the fit of each joint's current.

The current and all columns pass the same zero-phase low-pass, so that both sides of the fit remain
comparable; fast changes of the measured current are noise.
"""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import partial
from typing import Any

import numpy as np

from ur5lib.records.motion import Motion
from ur5lib.robots.friction import (
    FITTED_TERMS,
    PRESLIDING_DISTANCE,
    REST_DISTANCES,
    USUAL_TEMPERATURE,
    JointMotion,
    ShaftMotion,
    Track,
    coefficient_names,
    direction_over_distances,
    friction_columns,
    rest_factor,
    unknown_after,
    unknown_share,
)
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import BLOCK_DURATION, DEAD_ZONE, starts
from ur5lib.timeseries.trajectories import PathStates, group_by_path

INDEPENDENT_STEP = 0.1  # s; samples this far apart count as independent
WHOLLY = 0.9  # this share of the low-pass's weight counts as all of it
MIN_UNITS = 5  # paths, or stretches; with fewer, smaller parts are resampled
BLOCKS_PER_STRETCH = 5
MIN_PATHS = 3  # cross-validation by path needs this many; README asks for them


class MotionState(IntEnum):
    """How a joint moves throughout the reach of a low-pass.

    REVERSING: it starts, stops or turns; `STANDING`: at rest; UNKNOWN: before its first motion,
    where the side on which friction acts is unknown.
    """

    MOVING, REVERSING, STANDING, UNKNOWN = range(4)


@dataclass(frozen=True)
class Shafts:
    """Motion of coupled motors' shafts, (N, n) each [rad, rad/s, rad/s²], NaN where there is none.

    Each is in the column of the joint that it turns with; before: the shafts in the earlier
    motions.
    """

    q: Array
    qd: Array
    qdd: Array
    before: Sequence["Shafts"] = ()


@dataclass(frozen=True)
class CurrentSamples:
    """A contact-free recording on a uniform grid, as the fit of currents takes it.

    period: [s]; segment: (N,) labels of parts without a gap; q, qd: (N, n) [rad, rad/s]; torque:
    (N, n) [Nm], of the rigid-body model at that motion; current: (N, n) [A]; temperature: (N, n)
    [°C], of the motors, if recorded; shafts: of coupled motors; balanced: joints from 0 on which
    springs or counterbalances act; qdd: (N, n) [rad/s²], if rotors are fitted, too; inertial: (N,
    n) [Nm], the torque without gravity's, if gains of measured torques are fitted; day: label of
    its date, the same for all where dates are unknown; before: the earlier motions, oldest first,
    each of which begins where the previous one ended.
    """

    name: str
    period: float
    segment: Labels
    q: Array
    qd: Array
    torque: Array
    current: Array
    temperature: Array | None = None
    shafts: Shafts | None = None
    balanced: Sequence[int] = ()
    qdd: Array | None = None
    inertial: Array | None = None
    day: str = ""
    before: Sequence[Motion] = ()
    # Low-passed samples, since fits without each path need the same ones again.
    _thinned: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    def once(self, key: Any, thinned: Callable[[], Any]) -> Any:
        """Return `thinned()`, computed only at the first call with a key."""
        if key not in self._thinned:
            self._thinned[key] = thinned()
        return self._thinned[key]

    def command(self) -> str:
        """Return a hash of the efforts of all samples, empty if they never change."""
        changes = (self.current != self.current[0]).any()
        return hashlib.sha256(self.current.tobytes()).hexdigest() if changes else ""

    def joint(self, joint: int) -> JointMotion:
        """Return the motion of a joint, from 0."""
        q, qd, torque = (values[:, joint] for values in (self.q, self.qd, self.torque))
        direction_over = self._direction_over(self._track(q, qd), tracks(self.before, joint))
        warmth = 0.0 if self.temperature is None else self.temperature[:, joint] - USUAL_TEMPERATURE
        shaft, is_balanced = self._shaft(joint), joint in self.balanced
        qdd, inertial = (0.0 if v is None else v[:, joint] for v in (self.qdd, self.inertial))
        further = warmth, shaft, is_balanced, qdd, direction_over, inertial
        return JointMotion(q, qd, torque, direction_over(PRESLIDING_DISTANCE), *further)

    def unknown_shares(self) -> Array:
        """Return which share (N, n) of each joint's friction depends on the unknown motion before
        the recording.
        """
        shares = [
            unknown_share(q, self.segment, unknown_after(tracks(self.before, joint)))
            for joint, q in enumerate(self.q.T)
        ]
        return np.stack(shares, axis=1)

    def _shaft(self, joint: int) -> ShaftMotion | None:
        """Return the motion of the coupled motor that a joint turns with, None without one."""
        if self.shafts is None or np.isnan(self.shafts.q[:, joint]).all():
            return None
        shafts = self.shafts
        q, qd, qdd = (values[:, joint] for values in (shafts.q, shafts.qd, shafts.qdd))
        before = [
            Track(own.q[:, joint], own.qd[:, joint], motion.segment, motion.period)
            for own, motion in zip(shafts.before, self.before, strict=True)
        ]
        direction_over = self._direction_over(self._track(q, qd), before)
        return ShaftMotion(qd, qdd, direction_over(PRESLIDING_DISTANCE))

    def _direction_over(self, track: Track, earlier: Sequence[Track]) -> Callable[[float], Array]:
        """Return a function of a distance [rad] that returns the direction (N,) of dry friction."""
        return direction_over_distances(track, earlier)

    def _track(self, q: Array, qd: Array) -> Track:
        return Track(q, qd, self.segment, self.period)


@dataclass(frozen=True)
class SteadyStates(CurrentSamples):
    """States in any order: a joint that moves has moved like this for long; of one at rest, nobody
    knows on which side friction holds it.
    """

    def unknown_shares(self) -> Array:
        """Return 1 for joints at rest, 0 for others, (N, n)."""
        return (np.abs(self.qd) <= DEAD_ZONE).astype(float)

    def _direction_over(self, track: Track, _: Sequence[Track]) -> Callable[[float], Array]:
        return lambda _: np.sign(track.qd)


def tracks(motions: Sequence[Motion], joint: int) -> list[Track]:
    """Return each motion's part of one joint, from 0."""
    return [
        Track(own.q[:, joint], own.motor_qd[:, joint], own.segment, own.period) for own in motions
    ]


# A zero-phase low-pass of (N, M) samples of a recording, within its segments.
Smooth = Callable[[Array, CurrentSamples], Array]


@dataclass(frozen=True)
class JointSamples:
    """Samples of one joint from all recordings.

    columns: (n, P), of the torque, an offset, and the terms; held: (n, 1 + D), `held_columns` of
    `distances`; current: (n,) [A]; state: (n,), a `MotionState`; block, record, path, day: (n,)
    labels; recordings of one trajectory have one path and are left out together; unit: (n,) labels
    of what the bootstrap draws: paths, or parts of 10 s if paths are few, or blocks if these parts
    are few, too.
    """

    terms: tuple[str, ...]
    distances: tuple[float, ...]
    columns: Array
    held: Array
    current: Array
    state: Labels
    block: Labels
    record: Labels
    path: Labels
    day: Labels
    unit: Labels

    @property
    def moving(self) -> Mask:
        """Return which samples (n,) are in motion: not at rest, starting or stopping."""
        return self.state == MotionState.MOVING

    def of(self, terms: Sequence[str], distances: Sequence[float]) -> "JointSamples":
        """Return the samples with some of their terms and distances."""
        names, wanted = coefficient_names(self.terms), coefficient_names(terms)
        places = [0, 1, *(2 + names.index(name) for name in wanted)]
        held = [0, *(1 + self.distances.index(distance) for distance in distances)]
        columns, kept = self.columns[:, places], self.held[:, held]
        return replace(
            self, terms=tuple(terms), distances=tuple(distances), columns=columns, held=kept
        )

    def where(self, rows: Mask) -> "JointSamples":
        """Return the samples in some rows (n,)."""
        names = ("columns", "held", "current", "state", "block", "record", "path", "day", "unit")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


def joint_samples(
    records: Sequence[CurrentSamples], smooth: Smooth, terms: Sequence[str] = FITTED_TERMS
) -> list[JointSamples]:
    """Return the samples of each joint from all recordings, with the columns of these terms of
    friction.
    """
    labels = [blocks(record) for record in records]
    # each recording's labels begin with a new stretch, so that no stretch contains two recordings
    firsts = np.cumsum(
        [
            0,
            *(
                -(-(block_labels[-1] + 1) // BLOCKS_PER_STRETCH) * BLOCKS_PER_STRETCH
                for block_labels in labels[:-1]
            ),
        ]
    )
    thinned = [
        _record_samples(record, smooth, tuple(terms), first + block_labels)
        for record, block_labels, first in zip(records, labels, firsts, strict=True)
    ]
    paths, days = record_paths(records), record_days(records)
    joints = []
    for joint in range(len(thinned[0])):
        rows = [samples[joint] for samples in thinned]
        record = np.repeat(np.arange(len(rows)), [len(row[0]) for row in rows])
        columns, held, current, state, block = (
            np.concatenate(arrays) for arrays in zip(*rows, strict=True)
        )
        path = paths[record]
        # the largest kind of part of which there are MIN_UNITS
        parts = (path, block // BLOCKS_PER_STRETCH)
        unit = next((part for part in parts if len(np.unique(part)) >= MIN_UNITS), block)
        remaining = held, current, state, block, record, path, days[record], unit
        joints.append(JointSamples(tuple(terms), REST_DISTANCES, columns, *remaining))
    return joints


def record_paths(records: Sequence[CurrentSamples]) -> Labels:
    """Return labels (R,) of recordings by their trajectory; a command that is sent again is one,
    however the arm follows it.
    """
    labels = group_by_path([recorded_path(record) for record in records])
    first = dict[str, int]()
    for place, record in enumerate(records):
        commanded = record.once("command", record.command) or str(place)
        labels[labels == labels[place]] = labels[first.setdefault(commanded, place)]
    return np.unique(labels, return_inverse=True)[1].astype(np.int64)


def record_days(records: Sequence[CurrentSamples]) -> Labels:
    """Return labels (R,) of recordings by their day."""
    return np.unique([record.day for record in records], return_inverse=True)[1].astype(np.int64)


def apart_from(out: Mask, path: Labels, day: Labels) -> Mask:
    """Return which samples or recordings (n,) share neither path nor day with those in `out`.

    out: (n,), whole paths; path, day: (n,) labels. If fewer than MIN_PATHS paths remain, days are
    ignored.
    """
    on_other_days = ~out & ~np.isin(day, day[out])
    return on_other_days if len(np.unique(path[on_other_days])) >= MIN_PATHS else ~out


def recorded_path(record: CurrentSamples) -> PathStates:
    """Return the states of a recording along its path, by which paths are compared."""
    return path_of(record.q, record.qd, record.period)


def path_of(q: Array, qd: Array, period: float) -> PathStates:
    """Return the states along the path of a motion, by which paths are compared; q, qd: (N, n)
    [rad, rad/s]; period: [s].
    """
    return PathStates.from_motion(q, qd, max(1, round(INDEPENDENT_STEP / period)))


def columns_of(motion: JointMotion, terms: Sequence[str]) -> Array:
    """Return the regression columns (N, P) of a joint: its torque, an offset and the terms of
    friction.
    """
    ones = np.ones_like(motion.torque)
    return np.column_stack([motion.torque, ones, friction_columns(motion, terms)])


def held_columns(motion: JointMotion, distances: Sequence[float]) -> Array:
    """Return the columns (N, 1 + D) of a joint's friction at rest.

    They are its direction z, and z over each of the other distances [rad] minus z.
    """
    others = [motion.direction_over(distance) - motion.direction for distance in distances]
    columns: Array = np.stack([motion.direction, *others], axis=1) * rest_factor(motion.qd)[:, None]
    return columns


def smoothed_moving(record: CurrentSamples, smooth: Smooth) -> Mask:
    """Return which joints move throughout the reach of the low-pass, (N, n)."""
    return motion_states(record, smooth) == MotionState.MOVING


def motion_states(record: CurrentSamples, smooth: Smooth) -> Labels:
    """Return the `MotionState` (N, n) of each joint."""
    moving = (np.abs(record.qd) > DEAD_ZONE).astype(float)
    moving[~np.isfinite(record.qd)] = np.nan
    share = smooth(moving, record)
    moves_or_turns = np.where(share > WHOLLY, MotionState.MOVING, MotionState.REVERSING)
    known = np.where(share < 1 - WHOLLY, MotionState.STANDING, moves_or_turns)
    unknown = smooth(record.unknown_shares(), record) > 1 - WHOLLY
    return np.where(unknown & (known != MotionState.MOVING), MotionState.UNKNOWN, known)


def _record_samples(
    record: CurrentSamples,
    smooth: Smooth,
    terms: tuple[str, ...],
    block: Labels,
) -> list[tuple[Array, Array, Array, Labels, Labels]]:
    """Return, for each joint, columns in motion and at rest, current, state and block, low-passed
    and thinned.
    """
    stride = max(1, round(INDEPENDENT_STEP / record.period))
    state = record.once(smooth, lambda: motion_states(record, smooth)[::stride].copy())
    joints = []
    for joint in range(record.q.shape[1]):
        key = smooth, terms, joint
        smoothed = record.once(key, partial(_smoothed_columns, record, *key, stride))
        finite = np.isfinite(smoothed).all(axis=1)
        columns, held, current = np.split(smoothed[finite], [-2 - len(REST_DISTANCES), -1], axis=1)
        labels = state[finite, joint], block[::stride][finite]
        joints.append((columns, held, current[:, 0], *labels))
    return joints


def _smoothed_columns(
    record: CurrentSamples, smooth: Smooth, terms: Sequence[str], joint: int, stride: int
) -> Array:
    """Return a joint's columns in motion and at rest, and current, low-passed, every `stride`-th
    row.
    """
    motion = record.joint(joint)
    sources = columns_of(motion, terms), held_columns(motion, REST_DISTANCES)
    return smooth(np.column_stack([*sources, record.current[:, joint]]), record)[::stride].copy()


def blocks(record: CurrentSamples) -> Labels:
    """Return labels (N,) of blocks of BLOCK_DURATION seconds within segments."""
    running = np.arange(len(record.segment)) // max(1, round(BLOCK_DURATION / record.period))
    return np.cumsum(starts(record.segment) | starts(running)) - 1
