"""Windows of recordings: the state at the start, the efforts in it, and where the arm went."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
import scipy  # loads scipy.interpolate at its first use

from ur5lib.identification.samples import CurrentSamples
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import DEAD_ZONE, unbroken
from ur5lib.topics.rollout.simulation import STEP, State

HORIZONS = (0.1, 0.2, 0.5, 1.0, 2.0)  # s
ENDS = np.round(np.array(HORIZONS) / STEP).astype(int)  # steps
STEPS = int(ENDS[-1])
LENGTH = HORIZONS[-1]  # s


@dataclass(frozen=True)
class Windows:
    """W windows of LENGTH seconds.

    recording: (W,), the place of each one's recording among those of the arm; row: (W,), the sample
    at which it starts; q, qd, direction: (W, n), the state there, as of `State`; effort: (W, STEPS,
    n), the mean of each step [A, or Nm]; reached: (W, H, n) [rad], after each of HORIZONS.
    """

    recording: Labels
    row: Labels
    q: Array
    qd: Array
    direction: Array
    effort: Array
    reached: Array

    @property
    def start(self) -> State:
        """Return the states at the start."""
        return State(self.q, self.qd, self.direction)

    def at(self, places: Labels) -> Self:
        """Return the windows at some places (M,), in their order."""
        return type(self)(*(getattr(self, own.name)[places] for own in fields(self)))


def joined(parts: Sequence[Windows]) -> Windows:
    """Return the windows of several recordings, at least one, in their order."""
    names = [own.name for own in fields(Windows)]
    return Windows(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def starts_of(record: CurrentSamples) -> Labels:
    """Return the samples (W,) at which windows start: side by side in unbroken stretches with known
    efforts, each with a joint that moves.
    """
    length, chosen = samples_in(record), list[int]()
    for row in starts_within(record, np.arange(len(record.q))).tolist():
        if not chosen or row >= chosen[-1] + length:
            chosen.append(row)
    moves = [np.abs(record.qd[row : row + length]).max() > DEAD_ZONE for row in chosen]
    return np.array(chosen, dtype=np.int64)[np.array(moves, dtype=bool)]


def starts_within(record: CurrentSamples, rows: Labels) -> Labels:
    """Return those of some samples from which on LENGTH seconds are in an unbroken stretch with
    known states and efforts.
    """
    states = np.hstack([record.q, record.qd, record.current])
    known: Mask = np.asarray(np.isfinite(states).all(axis=1))
    left = np.zeros(len(known), dtype=np.int64)  # samples to come in the stretch
    for stretch in unbroken(record.segment, known):
        if known[stretch.start]:
            left[stretch] = np.arange(stretch.stop - stretch.start)[::-1]
    return rows[left[rows] >= samples_in(record)]


def samples_in(record: CurrentSamples) -> int:
    """Return the number of a recording's samples that a window passes."""
    return int(np.ceil(LENGTH / record.period - 1e-9))


def windows_at(record: CurrentSamples, rows: Labels, recording: int) -> Windows:
    """Return the windows that start at some samples (W,); recording: its place among the arm's."""
    q, qd, effort = map(np.nan_to_num, (record.q, record.qd, record.current))
    sample, period = np.arange(len(q)), record.period
    angles = scipy.interpolate.CubicHermiteSpline(sample, q, period * qd)
    total = scipy.interpolate.make_interp_spline(sample, effort, k=1).antiderivative()
    ends = rows[:, None] + STEP / period * np.arange(STEPS + 1)
    directions = [record.joint(joint).direction[rows] for joint in range(q.shape[1])]
    return Windows(
        np.full(len(rows), recording),
        rows,
        q[rows],
        qd[rows],
        np.stack(directions, axis=1),
        np.diff(total(ends), axis=1) * period / STEP,
        angles(rows[:, None] + np.array(HORIZONS) / period),
    )
