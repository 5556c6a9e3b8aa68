"""Checks that the channels of a recording agree with one another and with the arm."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
import pandas as pd
import scipy  # loads scipy.interpolate at its first use

from ur5lib.channels import joint_count
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.phrases import number, numbered
from ur5lib.records.quality import Finding, contradiction
from ur5lib.tables import channel, unit
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import extrapolated_samples, unbroken

MIN_MOVING_SPEED = 0.05  # rad/s; slower joints do not show their velocities nor their friction
DERIVATIVES = [  # a channel, and the channel that should be its derivative
    ("actual_q", "actual_qd"),
    ("target_q", "target_qd"),
    ("target_qd", "target_qdd"),
]
MIN_SLOPE, MAX_SLOPE = 0.9, 1.1  # of a position, relative to its velocity
TWINS = [  # channels that follow each other, and the largest median difference between them
    ("actual_q", "target_q", 0.05),
    ("actual_current", "target_current", 2.5),
]
# Allowed ratios of the overall levels of two channels. In all recordings seen so far, of two arms
# of different sizes, the ratios are 0.95 to 1.3 and 9.9 to 11.7 Nm/A. The bounds are wide because
# the targets contain neither friction nor loads; a unit wrong by 57 or 1000 still exceeds them.
LEVEL_RATIOS = [
    ("actual_current", "target_current", 0.05, 20.0),
    ("target_moment", "target_current", 0.5, 200.0),
]
# Two joints count as swapped if swapping them cuts their deviation to this share.
MAX_SWAPPED_DEVIATION = 0.3
SLOW_PERIOD, MIN_SLOW_SAMPLES = 0.03, 12  # s; samples of a stretch that show their own spacing
# A spline misses every second sample by less than this share of what a straight line does, beyond
# what encoders and vibrations leave [rad]. Ten motions of a KUKA at 10 Hz: 0.001 to 0.008.
MAX_MISSED_SHARE, MAX_MISSED_ANGLE = 0.1, 1e-3
# The same share, from which on accelerations err by a third of their size and more. Fast motions of
# a UR5, a UR3, a UR10e and a TX40: 0.1 to 0.5 at 10 Hz, 0.4 to 2.8 at 2 Hz.
MAX_UNTOLD_SHARE = 0.5
MIN_SAMPLES_OF_LOWPASS = 8  # a low-pass averages so many samples into one and removes their noise
MAX_PERIOD_RATIO = 1.5  # steps between samples of one rate differ by at most this factor
# A joint may exceed its largest speed by this; a UR5 exceeded its own by 6 %.
MAX_SPEED_RATIO = 1.25
MAX_EXCESS = 0.05  # rad; a controller lets no joint leave its described range by more
FIRST_MOTION = 0.01  # rad; after it, friction opposes the motion, whatever it did before
MIN_LEVEL = 0.5  # A, Nm; below it, a channel contains only friction and noise


def check_robot(
    robot: pd.DataFrame,
    period: float,
    positions: Sequence[tuple[float, float]],
    velocity_max: Sequence[float],
    counted: bool = False,
) -> list[Finding]:
    """Return the contradictions between the channels of a repaired robot table.

    period: of its time grid [s]; positions: each joint's lowest and highest angle [rad];
    velocity_max: their largest speeds [rad/s]; counted: whether angles follow from a controller's
    counts, as the arm's `drives` describe them.
    """
    speeds = [(-speed, speed) for speed in velocity_max]
    return [
        *_derivatives(robot, period),
        *_twins(robot),
        *_ratios(robot),
        *_swapped(robot, "actual_current", "target_current"),
        *((counted and _miscounted(robot, positions)) or _limits(robot, "actual_q", positions)),
        *_limits(robot, "actual_qd", speeds),
    ]


def unfiltered(cutoffs_hz: Mapping[str, float], period: float) -> Iterator[Finding]:
    """Yield a note on low-pass filters that leave a recording as it is.

    cutoffs_hz: by filter; period: of the recording [s].
    """
    nyquist = 0.5 / period
    if beyond := [name for name, cutoff in cutoffs_hz.items() if cutoff >= nyquist]:
        detail = (
            f"`cutoff_hz` of {', '.join(beyond)} is not below {number(nyquist, 'g')} Hz, half the "
            "rate of this recording, so that these filters are not applied"
        )
        yield Finding("robot", Found.UNFILTERED, "note", len(beyond), detail)


def unmoved(q: Array) -> Iterator[Finding]:
    """Yield a note on joints that never move; q: (N, n) [rad]."""
    still = np.flatnonzero(~_moved(q)) + 1
    if len(still):
        detail = (
            f"{numbered(still.tolist())} never moved, so that nothing says to which side friction "
            "holds a torque there; begin a recording with a small move of every joint"
        )
        yield Finding("robot", Found.UNMOVED, "note", len(still), detail)


def no_motion(q: Array) -> Iterator[Finding]:
    """Yield a warning on a recording of a fit in which no joint moves; q: (N, n) [rad]."""
    if not _moved(q).any():
        detail = (
            f"no joint moves by {FIRST_MOTION:g} rad, so that a fit learns no friction from it; "
            "record a motion, or give it the role `validate`"
        )
        yield Finding("robot", Found.NO_MOTION, "warning", q.shape[1], detail)


def _moved(q: Array) -> Mask:
    """Return which joints (n,) move in positions (N, n) [rad]."""
    moved: Mask = np.nanmax(q, axis=0) - np.nanmin(q, axis=0) >= FIRST_MOTION
    return moved


def too_short(segment: Labels, period: float, cutoff: float) -> list[Finding]:
    """Return a warning if no part without a gap is long enough to low-pass currents and estimate
    forces.

    segment: (N,) labels; period: [s]; cutoff: of the low-pass of the currents [Hz].
    """
    longest = max(part.stop - part.start for part in unbroken(segment))
    least = 2 * extrapolated_samples(cutoff, period) + 1
    if longest >= least:
        return []
    detail = (
        f"no more than {longest} samples, {number(longest * period, '.2g')} s, without a gap: the "
        f"low-pass filter `currents` needs {number(least * period, '.2g')} s, so that no contact "
        "force is estimated; record several seconds"
    )
    return [Finding("robot", Found.TOO_SHORT, "warning", 1, detail)]


def fast_between_samples(
    q: Array, segment: Labels, period: float, velocity_max: Sequence[float]
) -> list[Finding]:
    """Return a warning of the joints of a slow log that move faster than its samples resolve.

    q: (N, n) [rad]; segment: (N,) labels; velocity_max: of the joints [rad/s]; faster steps are
    jumps and no motion.
    """
    fast = _untold_joints(q, segment, period, velocity_max, MAX_MISSED_SHARE)
    if not fast or any(untold_motion(q, segment, period, velocity_max)):
        return []
    detail = (
        f"the motion of {numbered(fast)} is faster than samples {number(period, 'g')} s apart "
        "tell: accelerations, and with them torques, err by more than the bands say; record at a "
        "higher rate, or move more slowly"
    )
    return [Finding("robot", Found.FAST_BETWEEN_SAMPLES, "warning", len(fast), detail)]


def untold_motion(
    q: Array, segment: Labels, period: float, velocity_max: Sequence[float]
) -> Iterator[Finding]:
    """Find joints of a slow log with accelerations that its samples do not resolve: a stop sign.

    Arguments as of `fast_between_samples`.
    """
    if joints := _untold_joints(q, segment, period, velocity_max, MAX_UNTOLD_SHARE):
        detail = (
            f"samples {number(period, 'g')} s apart do not tell the motion of {numbered(joints)} "
            "between them, so that accelerations are unknown; record at a higher rate, or move "
            "more slowly"
        )
        yield contradiction(CauseCode.UNTOLD_MOTION, "sampling", detail)


def _untold_joints(
    q: Array, segment: Labels, period: float, velocity_max: Sequence[float], share: float
) -> list[int]:
    """Return the joints, from 1, where the samples miss more than `share` of the curvature.

    A spline through every second sample misses the one between by little where it follows the
    motion, and by as much as a straight line where it does not.
    """
    farthest = MAX_SPEED_RATIO * period * np.array(velocity_max)
    leaps = (np.abs(np.diff(q, axis=0)) > farthest).any(axis=1)
    stretches = unbroken(segment, np.append(0, np.cumsum(leaps)))
    parts = [q[rows] for rows in stretches if rows.stop - rows.start >= MIN_SLOW_SAMPLES]
    if period < SLOW_PERIOD or not parts:
        return []
    missed, bent = (
        np.sqrt(np.mean(np.concatenate(own) ** 2, axis=0))
        for own in zip(*map(_missed_and_bent, parts), strict=True)
    )
    untold = np.flatnonzero(missed > share * bent + MAX_MISSED_ANGLE)
    return (untold + 1).tolist()


def slow_samples(
    q: Array, segment: Labels, period: float, cutoff: float, of_fit: float | None = None
) -> list[Finding]:
    """Return a note on currents of a moving joint with too few samples for the low-pass to average
    noise.

    If recordings were fitted, it is a warning where their samples come faster, since their bands
    lack that noise, and nothing elsewhere. q: (N, n) [rad]; segment: (N,) labels; cutoff: [Hz];
    of_fit: longest period of the fitted recordings [s], None if there are none.
    """
    steps = np.diff(q, axis=0)[np.diff(segment) == 0]
    moves = bool((np.mean(steps**2, axis=0) > (MIN_MOVING_SPEED * period) ** 2).any())
    if not moves or period <= 1 / (2 * cutoff) / MIN_SAMPLES_OF_LOWPASS:
        return []
    apart = f"samples {number(period, 'g')} s apart"
    if of_fit is None:
        detail = (
            f"{apart}: the low-pass filter `currents` leaves their noise, so that contact forces "
            "take recordings to fit that are as slow"
        )
        return [Finding("robot", Found.SLOW_SAMPLES, "note", 1, detail)]
    detail = (
        f"{apart}, and {number(of_fit, 'g')} s in the recordings to fit: the low-pass filter "
        "`currents` leaves noise in motion that the bands of these do not hold, so that no contact "
        "force is estimated; record at their rate"
    )
    slower = period > MAX_PERIOD_RATIO * of_fit
    return [Finding("robot", Found.SLOWER_THAN_FIT, "warning", 1, detail)] * slower


def slower_than_fit(
    q: Array, segment: Labels, period: float, cutoff: float, of_fit: float | None
) -> list[Finding]:
    """Return the warning of `slow_samples`, none where nothing was fitted."""
    return [] if of_fit is None else slow_samples(q, segment, period, cutoff, of_fit)


def _missed_and_bent(q: Array) -> tuple[Array, Array]:
    """Return the errors at q_1, q_3 ... of a spline and of straight lines through q_0, q_2 ... (N,
    n).
    """
    whole = q[: len(q) - 1 + len(q) % 2]
    place = np.arange(len(whole))
    spline = scipy.interpolate.make_interp_spline(place[::2], whole[::2], k=5)
    return spline(place[1::2]) - whole[1::2], (whole[:-2:2] + whole[2::2]) / 2 - whole[1::2]


def _derivatives(robot: pd.DataFrame, period: float) -> Iterator[Finding]:
    for below, above in DERIVATIVES:
        if are_recorded(robot, below, above):
            slopes = slopes_over_velocities(robot, below, above, period)
            if slopes and not channel(robot, above).any():
                detail = f"{above} is zero while {below} changes, as in an arm that is led by hand"
                yield Finding("robot", Found.SILENT_CHANNEL, "warning", len(slopes), detail)
                continue
            wrong = [j for j, slope in slopes.items() if not MIN_SLOPE <= slope <= MAX_SLOPE]
            if wrong:
                ratios = [f"joint {j + 1}: {number(slopes[j], '.3g')}" for j in wrong]
                detail = (
                    f"{above} is not the derivative of {below} ({', '.join(ratios)}, where the "
                    "ratio should be 1); check columns and units"
                )
                yield _inconsistent(len(wrong), detail)


def slopes_over_velocities(
    robot: pd.DataFrame, below: str, above: str, period: float
) -> dict[int, float]:
    """Return, by moving joint from 0, the least-squares ratio of the derivative of `below` to
    `above`.
    """
    whole = (robot["segment"].diff() == 0).to_numpy() & ~robot["interpolated"].to_numpy()
    whole &= ~robot["interpolated"].shift(fill_value=True).to_numpy(bool)
    if not whole.any():
        return {}
    ratios = {}
    # one joint after the other, for the memory of long recordings
    for joint in range(joint_count(robot)):
        value, rate = (robot[f"{name}_{joint}"].to_numpy(float) for name in (below, above))
        slope = np.diff(value)[whole[1:]] / period
        mean = (rate[1:] + rate[:-1])[whole[1:]] / 2
        moves, rests = (np.sqrt(np.nanmean(each**2)) for each in (slope, mean))
        if max(moves, rests) > MIN_MOVING_SPEED:
            with np.errstate(invalid="ignore", divide="ignore"):
                ratios[joint] = float(np.nansum(slope * mean) / np.nansum(mean**2))
    return ratios


def _twins(robot: pd.DataFrame) -> Iterator[Finding]:
    for one, other, bound in TWINS:
        if are_recorded(robot, one, other):
            apart = np.nanmedian(np.abs(channel(robot, one) - channel(robot, other)), axis=0)
            wrong = np.flatnonzero(apart > bound)
            if len(wrong):
                detail = (
                    f"{one} and {other} differ on {numbered(wrong + 1)}; check columns and units"
                )
                yield _inconsistent(len(wrong), detail)


def _ratios(robot: pd.DataFrame) -> Iterator[Finding]:
    """Find pairs of channels with a ratio of root mean squares that shows a wrong unit."""
    for one, other, least, most in LEVEL_RATIOS:
        if are_recorded(robot, one, other):
            level, its = _level(robot, one), _level(robot, other)
            if max(level, its) > MIN_LEVEL and not least * its <= level <= most * its:
                detail = (
                    f"the root mean square of {one} is {number(level, '.3g')} and that of {other} "
                    f"{number(its, '.3g')} (SI units), which do not fit together; check columns "
                    "and units"
                )
                yield _inconsistent(joint_count(robot), detail)


def _swapped(robot: pd.DataFrame, one: str, other: str) -> Iterator[Finding]:
    """Find pairs of joints of which each one's channel `one` follows the target `other` of the
    other joint.
    """
    if not are_recorded(robot, one, other):
        return
    values, targets = channel(robot, one), channel(robot, other)
    apart = np.array(
        [np.nanmedian(np.abs(column[:, None] - targets), axis=0) for column in values.T]
    )
    for j, k in combinations(range(values.shape[1]), 2):
        uncrossed, crossed = apart[j, j] + apart[k, k], apart[j, k] + apart[k, j]
        if uncrossed > MIN_LEVEL and crossed < MAX_SWAPPED_DEVIATION * uncrossed:
            detail = (
                f"{one} of joint {j + 1} follows {other} of joint {k + 1} and vice versa; the "
                "columns are probably swapped"
            )
            yield _inconsistent(2, detail)


def _miscounted(robot: pd.DataFrame, positions: Sequence[tuple[float, float]]) -> list[Finding]:
    """Return a warning of joints outside their range, by a wrong description of their controller's
    counts.
    """
    wider = [(low - MAX_EXCESS, high + MAX_EXCESS) for low, high in positions]
    if (found := _excess(robot, "actual_q", wider)) is None:
        return []
    count, each = found
    detail = (
        f"actual_q leaves the range of the arm's description ({each}): correct `home_deg`, "
        "`directions`, `coupling` or `gear_ratio`, or the limits of its `motors`"
    )
    return [Finding("robot", Found.JOINTS_BEYOND_THEIR_RANGE, "warning", count, detail)]


def _limits(
    robot: pd.DataFrame, name: str, bounds: Sequence[tuple[float, float]]
) -> Iterator[Finding]:
    if (found := _excess(robot, name, bounds)) is not None:
        count, each = found
        detail = f"{name} exceeds the joints' limits ({each})"
        yield Finding("robot", Found.JOINT_LIMITS, "note", count, detail)


def _excess(
    robot: pd.DataFrame, name: str, bounds: Sequence[tuple[float, float]]
) -> tuple[int, str] | None:
    """Return in how many rows a channel exceeds the joints' bounds, and in words up to which value
    each such joint goes; None if no joint does or the channel was not recorded.
    """
    if not are_recorded(robot, name):
        return None
    values, (low, high) = channel(robot, name), np.transpose(bounds)
    values = np.where(low == -high, np.abs(values), values)
    excess = np.maximum(low - values, values - high)
    beyond = excess > 0
    if not beyond.any():
        return None
    wrong = np.flatnonzero(beyond.any(axis=0)).tolist()
    worst = values[np.nanargmax(excess[:, wrong], axis=0), wrong].tolist()
    each = [f"joint {j + 1}: up to {number(v, '.3g')}" for j, v in zip(wrong, worst, strict=True)]
    return int(beyond.any(axis=1).sum()), f"{', '.join(each)} {unit(name)}"


def _inconsistent(count: int, detail: str) -> Finding:
    return Finding("robot", Found.INCONSISTENT_CHANNELS, "warning", count, detail)


def are_recorded(robot: pd.DataFrame, *channels: str) -> bool:
    """Return whether all of some channels were recorded."""
    return all(f"{name}_0" in robot for name in channels)


def _level(robot: pd.DataFrame, name: str) -> float:
    """Return the root mean square of a channel over all rows and joints."""
    return float(np.sqrt(np.nanmean(channel(robot, name) ** 2)))
