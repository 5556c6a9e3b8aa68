"""The contacts of a recording that cannot be at the flange, by the external torque."""

from dataclasses import replace

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.flange_contact import (
    MAX_CONTACT_SAMPLES,
    MIN_PROBABILITY_ELSEWHERE,
    flange_probability,
    place_jacobian,
    places,
)
from ur5lib.force.force_input import ForceInput
from ur5lib.force.gate import TorqueVariances, diagonal
from ur5lib.pipeline.force_estimates import Problem
from ur5lib.pipeline.records.contacts import Alarm
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array, Labels


def judged_by_torques(
    robot: Robot, problem: Problem, time: Array, prior: ContactPrior, raised: list[Alarm]
) -> list[Alarm]:
    """Return alarms of F̂ᵐᵃᵖ with whether they are off the flange; time: (N,) [s].

    Loads, and contacts in which no torque is known, stay as they are.
    """
    return [
        replace(own, off_flange=is_off_flange(robot, problem, time, prior, own)) for own in raised
    ]


def is_off_flange(
    robot: Robot, problem: Problem, time: Array, prior: ContactPrior, alarm: Alarm
) -> bool:
    """Return whether the torques of a contact exclude that it is on the last link or a tool."""
    run, model = problem
    rows = middle_half(run, time, alarm.start, alarm.end)
    if alarm.kind != "contact" or not len(rows):
        return False
    noise = TorqueVariances.of(run.states[rows], model, prior, run.load_std()[rows])
    spread = diagonal(noise.spread + noise.hidden)
    frames = link_frames(robot, run.q[rows])
    levers = {
        link: [place_jacobian(*frames, link, place) for place in along]
        for link, along in places(*frames).items()
    }
    return (
        1 - flange_probability(run.torque[rows], levers, spread, prior.sizes)
        >= MIN_PROBABILITY_ELSEWHERE
    )


def middle_half(run: ForceInput, time: Array, start: float, end: float) -> Labels:
    """Return at most MAX_CONTACT_SAMPLES rows of known torque in the middle half of a contact [s].

    The low-pass blurs its ends.
    """
    quarter = (end - start) / 4
    inside = (time >= start + quarter) & (time <= end - quarter)
    rows = np.flatnonzero(inside & finite_rows(run.torque) & finite_rows(run.q))
    return rows[:: max(1, len(rows) // MAX_CONTACT_SAMPLES)]
