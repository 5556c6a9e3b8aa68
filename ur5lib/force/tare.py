"""The tare: an untouched span of a recording, in which a resting arm's external torque is zero."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd
import scipy  # loads scipy.ndimage at its first use

from ur5lib.force.external_torque import finite_rows, is_still, joint_states
from ur5lib.force.sensed_contact import CONTACT_FORCE
from ur5lib.records.codes import Found
from ur5lib.records.currents import Currents
from ur5lib.records.motion import Motion
from ur5lib.records.phrases import as_written, number
from ur5lib.records.quality import CONTACT_TORQUE_SHARE, Finding, StartOffset
from ur5lib.records.signals import SENSOR_COLUMNS, Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import extrapolated_samples, without_ends

Span = tuple[float, float]  # s, from a recording's start

MAX_POSTURE_CHANGE = 0.02  # rad; a joint may leave the tared posture this far
MIN_REST_DURATION = 0.5  # s; a tare has torques at rest for at least this long
BLOCK_DURATION = 0.1  # s; readings are averaged over it
SMOOTHING_WINDOW = 0.2  # s; positions as read are averaged over it


def tare_doubts(
    span: Span, signals: Signals, arm: Robot, cutoff: float, qd: Array | None = None
) -> Iterator[Finding]:
    """Yield the finding that an untouched span cannot serve as a tare, or warnings that it may
    contain a contact.

    cutoff: of the currents' low-pass [Hz]; qd: (N, n) [rad/s], smoothed velocities, None to derive
    them from the positions.
    """
    period, time = signals.period, signals.time - signals.time[0]
    if qd is None:
        smooth = scipy.ndimage.uniform_filter1d(
            signals.actual_q, max(1, round(SMOOTHING_WINDOW / period)), axis=0
        )
        qd = np.gradient(smooth, period, axis=0)
    unknown = extrapolated_samples(cutoff, period)
    known = finite_rows(
        without_ends(np.zeros_like(signals.actual_q), signals.segment, period, cutoff)
    )
    known &= is_still(joint_states(qd, signals.segment, period, cutoff)) & inside(span, time)
    if (rest := float(known.sum() * period)) < MIN_REST_DURATION:
        yield _unusable(span, rest, time[-1], unknown * period)
        return
    if signals.effort is not None:
        yield from _touched_by_currents(span, time, signals.effort, arm)
    if signals.force_sensor is not None:
        yield from touched_by_sensor(span, time, signals.force_sensor)


def _unusable(span: Span, rest: float, whole: float, unknown: float) -> Finding:
    """Return the error of a span that cannot serve as a tare; rest: time at rest in it; whole:
    duration of the recording; unknown: time at both ends without a torque; all in s.
    """
    detail = (
        f"`untouched` [{as_written(span, 'g')}] is no tare, and forces are estimated without it: "
        f"the arm rests in it with a known torque for {number(rest, '.2g')} s, where "
        f"{MIN_REST_DURATION:g} s are needed (the recording lasts {number(whole, '.4g')} s, and "
        f"its first and last {number(unknown, '.2g')} s are unknown); give a longer span at rest, "
        "or remove the key"
    )
    return Finding("robot", Found.UNUSABLE_TARE, "error", 1, detail)


def touched_by_sensor(span: Span, time: Array, reading: Array) -> Iterator[Finding]:
    """Yield a warning where a sensor's reading (M, 6) [N, Nm] changes in an untouched span."""
    force = float(np.linalg.norm(_changes(span, time, reading[:, :3]), axis=1).max(initial=0))
    if force > CONTACT_FORCE:
        detail = (
            f"the sensor's reading changes by {number(force, '.0f')} N in `untouched` "
            f"[{as_written(span, 'g')}], whose torque the tare takes for zero: give a span in "
            "which nothing touches the arm"
        )
        yield Finding("force", Found.TOUCHED_TARE, "warning", 1, detail)


def touched_by_own_clock(span: Span, sensor: pd.DataFrame, start: StartOffset) -> Iterator[Finding]:
    """Yield the warning of `touched_by_sensor` for a sensor with a clock of its own, timed by its
    start stamps.
    """
    reading = sensor[SENSOR_COLUMNS["force"][:3]].to_numpy(float)
    yield from touched_by_sensor(span, sensor["time"].to_numpy() + start.seconds, reading)


def _touched_by_currents(span: Span, time: Array, current: Array, arm: Robot) -> Iterator[Finding]:
    torque = np.abs(_changes(span, time, current)) * np.array(arm.maker_torque_constants())
    shares = (torque / np.array(arm.torque_limits())).max(axis=0, initial=0)
    if (shares > CONTACT_TORQUE_SHARE).any():
        joint = int(np.nanargmax(shares))
        change = number(torque[:, joint].max(), ".2g")
        detail = (
            f"by its current, the torque of joint {joint + 1} changes by {change} Nm in "
            f"`untouched` [{as_written(span, 'g')}], which the tare takes for zero: give a span in "
            "which nothing touches the arm"
        )
        yield Finding("robot", Found.TOUCHED_TARE, "warning", 1, detail)


def _changes(span: Span, time: Array, values: Array) -> Array:
    """Return the changes (B, M) of values (N, M) since the start of a span, as means of blocks."""
    rows = inside(span, time) & finite_rows(values)
    blocks = (time[rows] / BLOCK_DURATION).astype(int)
    means = pd.DataFrame(values[rows]).groupby(blocks).mean().to_numpy()
    return means - means[:1]


def inside(span: Span, time: Array) -> Mask:
    """Return the samples (N,) in a span; time: (N,) [s], from the recording's start."""
    return np.asarray((time >= span[0]) & (time <= span[1]))


def tared(currents: Currents, motion: Motion, untouched: Span, cutoff: float) -> Currents:
    """Return the currents with the external torque reduced by its mean in an untouched span [s].

    cutoff: of its low-pass [Hz]. It is subtracted from the span on until a joint leaves its
    posture: then constants and load err differently, and friction at rest changes. If the arm rests
    in the span for less than MIN_REST_DURATION, the currents stay as they are, and `tare_doubts`
    reports it.
    """
    torque = currents.external_torque
    if torque is None:
        return currents
    still = is_still(joint_states(motion.motor_qd, motion.segment, motion.period, cutoff))
    known = inside(untouched, motion.time - motion.time[0]) & still & finite_rows(torque)
    if known.sum() * motion.period < MIN_REST_DURATION:
        return currents
    kept = from_span(motion, known)
    external = torque - kept[:, None] * torque[known].mean(axis=0)
    return replace(currents, external_torque=external, tared=kept)


def from_span(motion: Motion, known: Mask) -> Mask:
    """Return which samples (N,) follow the first of `known`, itself included, until a joint leaves
    its posture or the segment ends.
    """
    first = np.argmax(known)
    away = np.abs(motion.q - motion.q[known].mean(axis=0)).max(axis=1) > MAX_POSTURE_CHANGE
    ends = away | (motion.segment != motion.segment[first])
    ends[:first] = False
    kept = np.arange(len(ends)) >= first
    return kept & ~np.maximum.accumulate(ends)
