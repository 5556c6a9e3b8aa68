"""A recording of postures at rest: what it tells of gravity, and what contradicts the study."""

from dataclasses import replace

import numpy as np

from ur5lib.pipeline.carried import carried, disagreements
from ur5lib.recordings.entries import Files
from ur5lib.recordings.innovations import CURRENT
from ur5lib.recordings.posture_checks import (
    large_constants,
    posture_stop_signs,
    what_gravity_shows,
)
from ur5lib.recordings.postures import posture_means, read_postures
from ur5lib.recordings.quality import Contradictions, Quality
from ur5lib.records.postures import Postures
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot, Six
from ur5lib.robots.statics import gravity_torque
from ur5lib.timeseries.arrays import Array


def checked_postures(
    recording: Files, arm: Robot, declared: Payload | None, tcp: Six | None
) -> tuple[Postures, Quality]:
    """Read and check a recording of postures.

    arm: under the recording's gravity; declared, tcp: of the study, None where it declares none.
    Raises InputError when it cannot be used.
    """
    table, quality = read_postures(recording, arm)
    counted = table.assign(time=np.arange(len(table)), segment=0, interpolated=False)
    signals, means = Signals.from_table(counted), posture_means(table)
    load = carried(declared, signals)
    postures = Postures(
        q=means.q,
        current=means.currents[CURRENT],
        gravity=[*arm.gravity],
        payload=load.payload,
        contradictions=Contradictions(
            posture_stop_signs(means, arm, load.configured, load.payload),
            disagreements(declared, tcp, signals),
        ),
    )
    shown = what_gravity_shows(means, arm, load.payload)
    if not postures.contradictions.stop_signs:
        shown += large_constants(means, arm.carrying(load.payload))
    return postures, replace(quality, findings=[*quality.findings, *shown])


def held_torque(postures: Postures, arm: Robot, model: str) -> Array:
    """Return the torque (M, n) [Nm] by which an arm holds the postures and its payload."""
    loaded = arm.mounted(postures.gravity).carrying(postures.payload)
    return gravity_torque(loaded, model, postures.q)
