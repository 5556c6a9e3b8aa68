"""Examine an arm's joints by one recording, which has a date and no contact."""

from datetime import UTC, date, datetime

import numpy as np

from ur5lib.channels import CURRENT, Effort
from ur5lib.identification.current_samples import ZeroPhaseLowpass, current_record
from ur5lib.identification.samples import CurrentSamples, Smooth
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.codes import Found
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.prediction import Prediction
from ur5lib.records.quality import Quality
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.lowpass import Butterworth
from ur5lib.topics.health.condition import QUANTITIES, joint_conditions
from ur5lib.topics.health.rows import Checkup


class Inputs(AlignedRecording):
    """What is read of a recording."""

    date: str
    quality: Quality
    prediction: Prediction


@step("recording", "checkup.json", recordings="contact_free")
def examine_joints(
    recording: Inputs, friction: Friction, arm: Robot, lowpass: Butterworth
) -> Checkup:
    """Return the condition of each joint; with date None if the recording cannot be used.

    friction, arm: fitted; lowpass: of the currents.
    """
    day = dated(recording.date, recording.quality, recording.prediction)
    record = current_record(recording, arm)
    if day is None or record is None:
        return Checkup()
    return checkup(
        record, ZeroPhaseLowpass(*lowpass), friction.fit, day, recording.quality, arm.measured
    )


def checkup(
    record: CurrentSamples,
    smooth: Smooth,
    fit: CurrentFit,
    day: date,
    quality: Quality,
    measured: Effort = CURRENT,
) -> Checkup:
    """Return the condition by one recording; fit, measured: of its arm."""
    lost = sum(one.count for one in quality.findings if one.code == Found.LOST_FRAMES)
    warmth = np.full(record.q.shape[1], np.nan)
    if record.temperature is not None:
        warmth = np.nanmean(record.temperature, axis=0)
    found = joint_conditions(record, smooth, fit)
    joints = [{measured.parameter(name): one[name] for name in QUANTITIES} for one in found]
    return Checkup(day.isoformat(), joints, warmth, lost / quality.frames)


def dated(given: str, quality: Quality, currents: Prediction) -> date | None:
    """Return the date of a recording, None if it is unknown or the recording cannot be used.

    A recording with a stop sign or an unknown load cannot be used. given: ISO 8601, from the study;
    if empty, the date (UTC) of the start stamp is used.
    """
    start = quality.start_epoch_s
    if currents.is_loaded or not currents.scores:
        return None
    if given:
        return date.fromisoformat(given)
    return None if start is None else datetime.fromtimestamp(start, UTC).date()
