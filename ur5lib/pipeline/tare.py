"""The tare of a recording: a span in which nothing touches the resting arm counts as zero."""

from dataclasses import replace

import numpy as np

from ur5lib.errors import InputError
from ur5lib.force.external_torque import finite_rows, is_still, joint_states
from ur5lib.records.currents import Currents
from ur5lib.records.motion import Motion
from ur5lib.timeseries.arrays import Array, Mask

NEAR = 0.02  # rad, by which a joint may leave the tared posture
LEAST_REST = 0.5  # s, of known torque at rest


def tared(
    currents: Currents, motion: Motion, untouched: tuple[float, float], recording: str
) -> Currents:
    """Return the currents with external torques counted from an untouched span [s].

    They count from there until a joint is elsewhere: constants and a load then err differently, and
    friction at rest is another. Raises InputError where the span does not hold LEAST_REST at rest.
    """
    torque = currents.external_torque
    if torque is None:
        return currents
    time = motion.time - motion.time[0]
    states = joint_states(motion.motor_qd, motion.segment, motion.period)
    inside = (time >= untouched[0]) & (time <= untouched[1])
    known = inside & is_still(states) & finite_rows(torque)
    if known.sum() * motion.period < LEAST_REST:
        raise InputError(
            f"`untouched` of {recording} is {[*untouched]}, in which the arm rests with a known "
            f"torque for less than {LEAST_REST:g} s (the recording lasts {time[-1]:.4g} s, and its "
            "first and last quarter second are unknown); give a span at rest, or remove the key"
        )
    kept = from_span(motion, known)
    external, causal = (
        own - kept[:, None] * own[known].mean(axis=0)
        for own in (torque, _required(currents.causal_torque))
    )
    return replace(currents, external_torque=external, causal_torque=causal, tared=kept)


def from_span(motion: Motion, known: Mask) -> Mask:
    """Return the samples (N,) from the first known one on, until a joint is elsewhere."""
    first = np.argmax(known)
    away = np.abs(motion.q - motion.q[known].mean(axis=0)).max(axis=1) > NEAR
    ends = away | (motion.segment != motion.segment[first])
    ends[:first] = False
    kept = np.arange(len(ends)) >= first
    return kept & ~np.maximum.accumulate(ends)


def _required(torque: Array | None) -> Array:
    assert torque is not None, "both external torques are known, or none"
    return torque
