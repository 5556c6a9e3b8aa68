"""The links on which the contacts of a recording may be, by the external torque."""

from collections.abc import Iterator

import numpy as np

from ur5lib.dynamics.flange import link_frames
from ur5lib.force.contact_link import SAMPLES, lever, link_probabilities, places
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.force_input import ForceInput
from ur5lib.force.gate import Noise
from ur5lib.force.residual_model import ResidualModel
from ur5lib.pipeline.records.contacts import Alarm, TouchedLinks
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array, Labels


def located(
    robot: Robot,
    run: ForceInput,
    time: Array,
    model: ResidualModel,
    prior: ContactPrior,
    raised: list[Alarm],
) -> Iterator[TouchedLinks]:
    """Yield the probabilities of the links for each contact among alarms.

    run: (N, 6); time: (N,) [s]; raised: alarms of F̂ᵐᵃᵖ; without those that are loads, and those in
    which no torque is known.
    """
    for alarm in raised:
        rows = middle_half(run, time, alarm.start, alarm.end)
        if alarm.kind == "contact" and len(rows):
            links = probabilities(robot, run, model, prior, rows)
            yield TouchedLinks(alarm.start, [*links.values()])


def middle_half(run: ForceInput, time: Array, start: float, end: float) -> Labels:
    """Return at most SAMPLES rows of known torque in the middle half of a contact [s].

    The low-pass blurs its ends.
    """
    quarter = (end - start) / 4
    inside = (time >= start + quarter) & (time <= end - quarter)
    rows = np.flatnonzero(inside & finite_rows(run.torque) & finite_rows(run.q))
    return rows[:: max(1, len(rows) // SAMPLES)]


def probabilities(
    robot: Robot, run: ForceInput, model: ResidualModel, prior: ContactPrior, rows: Labels
) -> dict[int, float]:
    """Return the probability of each link at a contact of some rows (n,) of a recording."""
    noise = Noise.of(run.states[rows], model, prior, run.load_std()[rows])
    # joints count as independent: correlations learnt without contact mislead in contact
    spread = (noise.spread + noise.hidden) * np.eye(run.q.shape[1])
    frames = link_frames(robot, run.q[rows])
    levers = {
        link: [lever(*frames, link, place) for place in along]
        for link, along in places(*frames).items()
    }
    return link_probabilities(run.torque[rows], levers, spread, prior.sizes)
