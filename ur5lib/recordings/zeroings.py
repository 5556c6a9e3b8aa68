"""A force sensor that was zeroed during a recording: all its samples are put on its last zero.

A zeroing shifts the reading to zero from one sample to the next, and nothing else happens. The end
of a contact takes longer, lets the arm ring, or shows in the motor currents.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ur5lib.channels import columns
from ur5lib.recordings.starts import MAX_CLOCK_DRIFT
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, StartOffset
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, gravity_torque, link_frames
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

SAMPLES_BESIDE_STEP = 20  # samples on each side of a step, which lie on two parallel lines
MAX_PERIOD = 0.02  # s, between samples; to a slower sensor, the end of a contact is one step, too
MIN_STEP = 2.0  # N, of a step
# The samples around a step may lie this share of it from their lines, and its end this share from
# zero unless they lie farther. Of the steps of more than 1 N in the real recordings, where nobody
# zeroed the sensor, none ends within 0.3 of zero, and none has samples so near their lines.
MAX_DISTANCE_FROM_LINES, MAX_DISTANCE_FROM_ZERO = 0.3, 0.1
# In s from a step, after which currents have followed the end of a contact.
REACTION_TIME, COMPARED_TIME = 0.02, 0.2
# Currents then show this share of its torque. Friction carries some of it.
MIN_SHARE_SHOWN_BY_CURRENTS = 0.25
ON_ROBOT_CLOCK = StartOffset(0.0, 0.0, drift_std=0.0)
MIN_STANDARD_ERRORS = 4.0  # standard errors by which a current changes


@dataclass(frozen=True)
class ReadingStep:
    """A step of a reading between two parallel lines, fitted before and after a row.

    size, std_error: (k,), of each column; after: (k,), the second line at the row; residual: (2 n,
    k), of n rows on each side.
    """

    size: Array
    std_error: Array
    after: Array
    residual: Array


@dataclass(frozen=True)
class Zeroing:
    """A place where a sensor was zeroed.

    row: number of the sample, within one; time: of the row by the robot's clock [s]; change: of all
    columns [N, Nm]; misfit: largest distance of the force around it from two parallel lines, as a
    share of the change; infinite if the force does not fall to zero.
    """

    row: int
    time: float
    change: Array
    misfit: float

    def size(self) -> float:
        """Return by how much the force changed [N]."""
        return float(np.linalg.norm(self.change[:3]))


def on_one_zero(
    sensor: pd.DataFrame, robot: pd.DataFrame, arm: Robot, start: StartOffset | None = None
) -> tuple[pd.DataFrame, list[Finding]]:
    """Return a force sensor's table with all samples shifted to its last zero, and the finding on
    where it was zeroed.

    sensor: `time` and ft_*; robot: a repaired table; start: of the sensor's clock, None for the
    robot's.
    """
    names = [name for name in columns("ft") if name in sensor]
    if not names:
        return sensor, []
    reading, start = sensor[names].to_numpy(float, copy=True), start or ON_ROBOT_CLOCK
    zeroings = [
        one
        for one in _sudden_zeros(reading, sensor["time"].to_numpy(float), start.seconds)
        if not _contact_ends(robot, arm, one, start)
    ]
    if not zeroings:
        return sensor, []
    for one in zeroings:
        reading[: one.row] += one.change
        reading[one.row] = (reading[one.row - 1] + reading[one.row + 1]) / 2
    zeroed = Finding("force", Found.ZEROED, "warning", len(zeroings), _words(zeroings))
    return sensor.assign(**dict(zip(names, reading.T, strict=True))), [zeroed]


def _words(zeroings: Sequence[Zeroing]) -> str:
    each = (f"at {number(one.time, '.3f')} s by {number(one.size(), '.1f')} N" for one in zeroings)
    return (
        "the reading falls to zero from one sample to the next, and the motors show no contact "
        f"that ends: {', '.join(each)}; the sensor was zeroed there, and all samples before are "
        "put on the last zero"
    )


def _sudden_zeros(reading: Array, time: Array, late: float) -> Iterator[Zeroing]:
    """Yield where a reading (N, 3 or 6) falls to zero within a sample.

    time: (N,) [s]; late: start of the sensor's clock, by the robot's [s].
    """
    force = reading[:, :3]
    change = np.linalg.norm(force[2:] - force[:-2], axis=1)
    sudden = (change > MIN_STEP / 2) & (
        np.linalg.norm(force[2:], axis=1) < 2 * MAX_DISTANCE_FROM_LINES * change
    )
    rows = np.flatnonzero(sudden & (time[2:] - time[:-2] <= 2 * MAX_PERIOD)) + 1
    rows = rows[(rows >= SAMPLES_BESIDE_STEP) & (rows < len(force) - SAMPLES_BESIDE_STEP)]
    for near in np.split(rows, np.flatnonzero(np.diff(rows) > SAMPLES_BESIDE_STEP) + 1):
        falls = [_fall(reading, time + late, row) for row in near.tolist()]
        best = min(falls, key=lambda fall: fall.misfit, default=None)
        # a sensor that is gone sends zeros
        if (
            best is not None
            and best.misfit < MAX_DISTANCE_FROM_LINES
            and force[best.row + 1 :].any()
        ):
            yield best


def _fall(reading: Array, time: Array, row: int) -> Zeroing:
    """Return the step of a reading at a row as a possible zeroing."""
    step = _step(
        reading[row - SAMPLES_BESIDE_STEP : row], reading[row + 1 : row + 1 + SAMPLES_BESIDE_STEP]
    )
    size, end = (float(np.linalg.norm(force[:3])) for force in (step.size, step.after))
    away = float(np.linalg.norm(step.residual[:, :3], axis=1).max())
    fits = size > MIN_STEP and end < max(MAX_DISTANCE_FROM_ZERO * size, away)
    return Zeroing(row, float(time[row]), step.size, away / size if fits else np.inf)


def _step(before: Array, after: Array) -> ReadingStep:
    """Return the step between values (n, k) before and values (n, k) after a row."""
    place = np.arange(1, len(before) + 1)
    slope = np.concatenate([-place[::-1], place])
    terms = np.column_stack([np.ones(len(slope)), slope, slope > 0])
    inverse, values = np.linalg.pinv(terms), np.concatenate([before, after])
    level, _, size = solution = inverse @ values
    residual = values - terms @ solution
    noise = np.sqrt((residual**2).sum(axis=0) / (len(values) - len(solution)))
    return ReadingStep(size, noise * np.linalg.norm(inverse[2]), level + size, residual)


def _contact_ends(robot: pd.DataFrame, arm: Robot, zeroing: Zeroing, start: StartOffset) -> bool:
    """Return whether the motors' efforts show that a contact ends there; start: of the sensor's
    clock.
    """
    if f"{arm.measured.channel}_0" not in robot:
        return False
    unsure = start.std + (MAX_CLOCK_DRIFT * zeroing.time if start.drift_std is None else 0.0)
    since = robot["time"].to_numpy() - zeroing.time
    before, after = (
        np.flatnonzero((REACTION_TIME + unsure < away) & (away < COMPARED_TIME + unsure))
        for away in (-since, since)
    )
    count = min(len(before), len(after))
    if count < 3:
        return False
    beside = robot.iloc[[*before[-count:], *after[:count]]]
    q, effort = channel(beside, "actual_q"), channel(beside, arm.measured.channel)
    constants = np.array(arm.family_torque_constants())
    torque = constants * effort - gravity_torque(arm, arm.chosen_model, q)
    step = _step(*np.split(np.nan_to_num(torque), 2))
    expected = _torque(arm, q[count - 1 : count], zeroing.change[:3]) * np.isfinite(constants)
    shown, noise = expected @ step.size, np.linalg.norm(expected * step.std_error)
    return bool(
        abs(shown)
        > max(MIN_STANDARD_ERRORS * noise, MIN_SHARE_SHOWN_BY_CURRENTS * expected @ expected)
    )


def _torque(arm: Robot, q: Array, force: Array) -> Array:
    """Return the joints' torque (n,) [Nm] by a force at the flange, in its axes; q: (1, n)
    [rad].
    """
    (jacobian,), rotation = geometric_jacobian(arm, q), link_frames(arm, q)[0][0, -1]
    return np.asarray(jacobian[:3].T @ (rotation @ force))
