"""Which link the contact of an alarm is on, and whether it may be at the flange, by torques."""

from dataclasses import replace
from typing import Any

import numpy as np

from ur5lib.force.alarms import Alarm
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.force_input import ForceInput
from ur5lib.force.gate import TorqueVariances, diagonal
from ur5lib.force.problem import Problem
from ur5lib.force.touched_link import (
    LIKELY,
    off_flange,
    place_jacobians,
    place_probabilities,
    places,
    sizes_of,
)
from ur5lib.records.forces import Forces
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array, Labels

# At rest, a contact at the flange is excluded from this probability of the other links on: friction
# keeps what the wrist carries.
SURE_AT_REST = 0.95
MAX_CONTACT_SAMPLES = 20  # this many samples are used; more add no information


def judged_by_torques(
    robot: Robot, problem: Problem, forces: Forces, prior: ContactPrior, raised: list[Alarm]
) -> list[Alarm]:
    """Return alarms of F̂ᵐᵃᵖ with `link`, of those in motion, and how probably they are off the
    flange; forces: of the same recording.

    Loads, and contacts without a finite torque, count as not off the flange.
    """
    return [
        in_motion(forces, own) or replace(own, **at_rest(robot, problem, forces.time, prior, own))
        for own in raised
    ]


def in_motion(forces: Forces, alarm: Alarm) -> Alarm | None:
    """Return an alarm with what the forces state of its link; None where they state none."""
    if alarm.kind != "contact" or forces.link is None or forces.off_flange is None:
        return None
    inside = (forces.time >= alarm.start) & (forces.time <= alarm.end)
    rows = np.flatnonzero(inside & np.isfinite(forces.off_flange))
    if not len(rows):
        return None
    middle = rows[len(rows) // 2]
    link, probability = int(forces.link[middle]), float(forces.off_flange[middle])
    return replace(
        alarm, link=link, off_flange_probability=probability, off_flange=probability >= LIKELY
    )


def at_rest(
    robot: Robot, problem: Problem, time: Array, prior: ContactPrior, alarm: Alarm
) -> dict[str, Any]:
    """Return, as fields of `Alarm`, how probably a contact is not on the last link or a tool."""
    run, model = problem
    rows = middle_half(run, time, alarm.start, alarm.end)
    if alarm.kind != "contact" or not len(rows):
        return {}
    noise = TorqueVariances.of(run.states[rows], model, run.load_std()[rows])
    spread = diagonal(noise.spread + noise.hidden)
    frames = link_frames(robot, run.q[rows])
    levers = place_jacobians(*frames, places(*frames))
    found = place_probabilities(run.torque[rows], levers, spread, sizes_of(prior))
    probability = off_flange(found)
    return {"off_flange_probability": probability, "off_flange": probability >= SURE_AT_REST}


def middle_half(run: ForceInput, time: Array, start: float, end: float) -> Labels:
    """Return the rows with a torque in the middle half of a contact, at most about twice
    MAX_CONTACT_SAMPLES.

    start, end: [s]. The low-pass blurs its ends.
    """
    quarter = (end - start) / 4
    inside = (time >= start + quarter) & (time <= end - quarter)
    rows = np.flatnonzero(inside & finite_rows(run.torque) & finite_rows(run.q))
    return rows[:: max(1, len(rows) // MAX_CONTACT_SAMPLES)]
