"""The arm of a recording as *Replay* shows it."""

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.force.alarms import Alarms, alarms_of, largest_force
from ur5lib.force.estimators import NEW, all_stated
from ur5lib.force.sensed_contact import CONTACT_FORCE, FREE_ROLES, contacts
from ur5lib.force.touched_link import LIKELY
from ur5lib.records.currents import Currents
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.scene import LinkPose, Scene, Spans
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import link_tail
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import Span, starts

SHORTEST_STEP = 0.1  # s; between postures, shorter than the low-pass resolves
MOST_POSTURES = 1200  # of a recording, in addition to the last of each segment
DECIMALS = 4  # of stored numbers


class Shown(Protocol):
    """What is shown of a recording."""

    role: str
    signals: Signals
    currents: Currents
    forces: Forces
    sensor: SensorWrenches


def arm_scene(recording: Shown, arm: Robot, thresholds: Mapping[str, float]) -> Scene:
    """Return the arm at some times of a recording; thresholds: of alarms, by estimate.

    arm: under the recording's gravity. Contacts at a sensor overrule a role without contact.
    """
    signals, forces, sensor = recording.signals.anew(), recording.forces, recording.sensor
    time, felt = signals.time, sensor.wrench.get("compensated")
    touches = [] if felt is None else contacts(_size(felt), CONTACT_FORCE)
    rows = shown_rows(signals.segment, signals.period)
    lead = next((name for name in NEW if name in forces.wrench), "")
    estimates = forces.anew(rows)
    found = lead in thresholds and lead in forces.log_odds
    raised = alarms_of(all_stated(forces, {})[lead], thresholds[lead]) if found else None
    return Scene(
        links=[LinkPose(*link_tail(pose)) for pose in arm.link_poses()],
        upright=upright(arm.gravity),
        time=np.round(time[rows], DECIMALS),
        segment=signals.segment[rows],
        q=np.round(signals.anew(rows).actual_q, DECIMALS),
        estimate=NEW.get(lead, ""),
        torque=_rounded(recording.currents.anew(rows).external_torque),
        force=_force(estimates.wrench.get(lead)),
        std=_force(estimates.std.get(lead)),
        hidden=_rounded(estimates.hidden),
        sensed=_force(sensor.anew(rows).wrench.get("compensated")),
        link=link_before_last(estimates),
        contacts=None if felt is None else _spans(touches, time),
        alarms=None if raised is None else _spans(raised.raised, time),
        largest=None if raised is None or lead not in forces.std else _largest(raised),
        free=recording.role in FREE_ROLES and not touches,
    )


def _largest(own: Alarms) -> list[tuple[float, float]]:
    """Return the largest force [N] of each alarm, and half of its 95 % band [N]."""
    spans = (slice(*span) for span in own.raised)
    found = (largest_force(own.unsmoothed[span], own.std[span, :3]) for span in spans)
    return [(round(size, 1), round(band, 1)) for size, band in found]


def link_before_last(forces: Forces) -> Labels | None:
    """Return the likeliest touched link (N,), from 1, where that is probably not the last one, and
    0 elsewhere.
    """
    if forces.link is None or forces.off_flange is None:
        return None
    return np.where(forces.off_flange >= LIKELY, np.nan_to_num(forces.link), 0.0).astype(int)


def shown_rows(segment: Labels, period: float) -> Labels:
    """Return evenly spaced rows of each segment and its last row; segment: (N,); period: [s]."""
    count = len(segment)
    step = max(round(SHORTEST_STEP / period), -(-count // MOST_POSTURES), 1)
    first = np.flatnonzero(starts(segment))
    within = np.arange(count) - np.repeat(first, np.diff([*first, count]))
    last = np.append(starts(segment)[1:], True)
    rows: Labels = np.flatnonzero((within % step == 0) | last)
    return rows


def upright(gravity: Sequence[float]) -> Array:
    """Return the smallest rotation (3, 3) that turns gravity (3,) [m/s²], base frame, to −z."""
    turn, _ = Rotation.align_vectors([[0.0, 0.0, -1.0]], [gravity])
    matrix: Array = turn.as_matrix().round(9) + 0.0
    return matrix


def _rounded(values: Array | None) -> Array | None:
    return None if values is None else np.round(values, DECIMALS)


def _force(wrench: Array | None) -> Array | None:
    return None if wrench is None else _rounded(wrench[:, :3])


def _size(wrench: Array) -> Array:
    size: Array = np.linalg.norm(wrench[:, :3], axis=1)
    return size


def _spans(found: Sequence[Span], time: Array) -> Spans:
    """Return the first and the last time [s] of each part of a recording, (first, last) samples
    with last exclusive.
    """
    return [(float(time[first]), float(time[end - 1])) for first, end in found]
