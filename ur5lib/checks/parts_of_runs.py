"""Neighbouring parts of one run as recordings: what is fitted to one has seen the other.

A part goes on where another ended: in its posture and at its velocity, within a few periods. Where
the arm rests there, which it also does at home, stamps must follow, too.
"""

import json
from collections.abc import Iterator, Mapping
from itertools import permutations
from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.checks.channels import MIN_MOVING_SPEED
from ur5lib.records.quality import Quality
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

MAX_PERIODS = 5  # one part follows another within this many periods
MAX_DEVIATION = 1e-3  # rad; a posture differs by at most this from where the velocities lead
MAX_ACCELERATION = 10.0  # rad/s²; velocities on both sides may differ by what this gives
MAX_CHANGE = 0.02  # rad/s; velocities of resting joints may differ by this, too
SLOPE_STEPS = 4  # a velocity follows from positions of frames so many steps apart


class Ends(NamedTuple):
    """Begin and end of a recording: times [s], postures [rad] and velocities [rad/s], first and
    last; period: [s]; stamped: whether the times are since 1970.
    """

    period: float
    stamped: bool
    times: list[float]
    q: list[list[float]]
    qd: list[list[float]]

    @classmethod
    def of(cls, robot: pd.DataFrame, quality: Quality) -> "Ends":
        """Return the ends of a repaired table."""
        q, time = channel(robot, "actual_q"), robot["time"].to_numpy(float)
        steps = min(SLOPE_STEPS, len(q) - 1)
        slopes = [q[steps] - q[0], q[-1] - q[-1 - steps]]
        qd = np.array(slopes) / max(steps * quality.period_s, 1e-9)
        epoch = quality.start_epoch_s
        times = (time[[0, -1]] + (epoch or 0.0)).tolist()
        return cls(quality.period_s, epoch is not None, times, q[[0, -1]].tolist(), qd.tolist())

    def go_on(self, later: "Ends") -> bool:
        """Return whether another recording goes on where this one ended."""
        if len(self.q[1]) != len(later.q[0]):
            return False
        gap = later.times[0] - self.times[1]
        follows = 0 < gap <= MAX_PERIODS * self.period
        if self.stamped and later.stamped and not follows:
            return False
        rates = np.array([self.qd[1], later.qd[0]])
        moves = np.abs(rates).max() > MIN_MOVING_SPEED
        most = MAX_CHANGE + MAX_ACCELERATION * (SLOPE_STEPS + 1) * self.period
        if np.abs(rates[1] - rates[0]).max() > most or not (moves or follows):
            return False
        led = self.period * np.arange(1, MAX_PERIODS + 1)[:, None] * rates.mean(axis=0)
        moved: Array = np.array(later.q[0]) - self.q[1]
        return bool(np.abs(moved - led).max(axis=1).min() < MAX_DEVIATION)


def as_text(ends: Ends) -> str:
    """Return ends as JSON, for the detail of a finding."""
    return json.dumps(ends)


def parts_seen(details: Mapping[str, str], roles: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Yield pairs of a recording and a fitted one, where the first continues or precedes the run of
    the second, so that its motion was not unseen.

    details: `as_text` by recording; roles: by recording.
    """
    ends = {name: Ends(*json.loads(text)) for name, text in details.items() if text}
    for one, later in permutations(ends, 2):
        fitted = [name for name in (one, later) if roles.get(name) == "fit"]
        if len(fitted) == 1 and ends[one].go_on(ends[later]):
            yield (one if fitted == [later] else later), fitted[0]
