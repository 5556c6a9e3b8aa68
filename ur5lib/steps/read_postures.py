"""A recording of postures at rest: what gravity shows, and contradictions with the study."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5lib.checks import files
from ur5lib.checks.channels import check_robot
from ur5lib.checks.postures import (
    large_constants,
    posture_means,
    posture_stop_signs,
    what_gravity_shows,
)
from ur5lib.checks.unknown_unit import unknown_unit
from ur5lib.errors import InputError, UnreadableError
from ur5lib.recordings import postures as posture_files
from ur5lib.recordings.entries import Entry, Files
from ur5lib.records.accepted import accepting
from ur5lib.records.carried import carried, disagreements
from ur5lib.records.judgement import Judgement
from ur5lib.records.postures import Postures
from ur5lib.records.quality import Contradictions, Quality
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Payload, Robot
from ur5lib.tables import checksum
from ur5lib.timeseries.arrays import Six


class ReadPostures(NamedTuple):
    """A recording of postures at rest, and its rows of the tables."""

    postures: Postures
    judgement: Judgement


@step(
    "posture",
    "postures.json judgement.json",
    recording="entry",
    arm="described",
    payload="declared_payload",
)
def read_postures(
    recording: Entry,
    raw: list[Path],
    arm: Robot,
    gravity: list[float] | None = None,
    payload: Payload | None = None,
    tcp: Six | None = None,
    accepted: dict[str, str] | None = None,
) -> ReadPostures:
    """Return the postures of a recording without time, in which the arm rests, and its rows of the
    tables.

    recording, raw, arm: as of `read_recording`; gravity [m/s²], payload, tcp: as the study declares
    them; accepted: its reasons to overrule stop signs, by kind. Raises UnreadableError where the
    files cannot be used.
    """
    try:
        postures, quality = checked_postures(
            recording, arm.mounted(gravity), payload, tcp, accepted
        )
    except InputError as error:
        raise UnreadableError(str(error)) from None
    quality = replace(quality, read={str(path): checksum(path) for path in raw})
    judgement = Judgement(
        findings=files.findings(quality, postures.contradictions),
        recordings=[files.summary(quality, None)],
        files=files.files_read(quality),
        account=quality.account,
    )
    return ReadPostures(postures, judgement)


def checked_postures(
    recording: Files,
    arm: Robot,
    declared: Payload | None,
    tcp: Six | None,
    accepted: Mapping[str, str] | None = None,
) -> tuple[Postures, Quality]:
    """Return the postures of a recording and its quality, read from its files and checked.

    arm: under the recording's gravity; declared, tcp: of the study, None where it declares none;
    accepted: its reasons to overrule stop signs, by kind. Raises InputError when it cannot be used.
    """
    table, quality = posture_files.read_postures(recording, arm)
    counted = table.assign(time=np.arange(len(table)), segment=0, interpolated=False)
    signals, means = Signals.from_table(counted), posture_means(table)
    load = carried(declared, signals)
    reasons = accepted or {}
    stops = posture_stop_signs(means, arm, load.configured, load.payload, reasons)
    if recording.unknown_unit():
        stops = [unknown_unit(means, arm.carrying(load.payload))]
    doubts = disagreements(declared, tcp, signals)
    postures = Postures(
        q=means.q,
        current=means.effort,
        gravity=[*arm.gravity],
        payload=load.payload,
        contradictions=accepting(Contradictions(stops, doubts), reasons),
    )
    shown = check_robot(table, 1.0, arm.position_limits(), arm.velocity_limits(), arm.is_counted())
    shown += what_gravity_shows(means, arm, load.payload)
    if not stops:
        shown += large_constants(means, arm.carrying(load.payload))
    return postures, replace(quality, findings=[*quality.findings, *shown])
