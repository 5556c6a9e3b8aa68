"""A recording of postures at rest: what it tells of gravity, and what contradicts the study."""

from dataclasses import replace

import numpy as np

from ur5lib.channels import MEASURED_CURRENT
from ur5lib.checks.channels import check_robot
from ur5lib.checks.postures import (
    large_constants,
    posture_means,
    posture_stop_signs,
    what_gravity_shows,
)
from ur5lib.pipeline.carried import carried, disagreements
from ur5lib.pipeline.records.postures import Postures
from ur5lib.pipeline.records.signals import Signals
from ur5lib.recordings.entries import Files
from ur5lib.recordings.postures import read_postures
from ur5lib.recordings.quality import Contradictions, Quality
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
        current=means.currents[MEASURED_CURRENT],
        gravity=[*arm.gravity],
        payload=load.payload,
        contradictions=Contradictions(
            posture_stop_signs(means, arm, load.configured, load.payload),
            disagreements(declared, tcp, signals),
        ),
    )
    shown = check_robot(table, 1.0, arm.position_limits(), arm.velocity_limits())
    shown += what_gravity_shows(means, arm, load.payload)
    if not postures.contradictions.stop_signs:
        shown += large_constants(means, arm.carrying(load.payload))
    return postures, replace(quality, findings=[*quality.findings, *shown])


def held_torque(postures: Postures, arm: Robot, model: str) -> Array:
    """Return the torque (M, n) [Nm] by which an arm holds the postures and its payload."""
    loaded = arm.mounted(postures.gravity).carrying(postures.payload)
    return gravity_torque(loaded, model, postures.q)
