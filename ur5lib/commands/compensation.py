"""`ur5 export --format sensor`: bias and tool of a force sensor, and how to subtract them."""

import math
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Quality
from ur5lib.records.sensor_offset import OffsetAccount
from ur5lib.records.signals import Signals
from ur5lib.records.table import WRENCH
from ur5lib.robots.description import Robot
from ur5lib.study.model import Recording
from ur5lib.tables import json_text
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

Interval = dict[str, float]  # value, low, high
AXES = ("x", "y", "z")
DOUBTS = (Found.MOUNTING, Found.OFFSET, Found.ZEROED)  # findings about a sensor
FORMULA = (  # docs/exports.md has its symbols
    "f' = T f - bias_F - mass p",
    "n' = T n - bias_n - first_moment x p + I alpha + omega x (I omega)",
    "F = R f'",
    "M = R (n' + position x f')",
)


def compensation(study: StudyFiles | None, robot: str, only: str) -> str:
    """Return bias and tool of an arm's force sensor by recording, as JSON with the formula.

    only: a recording, "" for all of the arm. Raises InputError without a study, and if no recording
    has a force sensor.
    """
    if study is None:
        raise InputError("--format sensor is what a study fitted; name its folder by --results")
    arm, entries = study.arm(robot), study.configuration().recordings
    chosen = [study.recording(only)] if only else [one for one in entries if not one.at_rest]
    of_arm = [entry for entry in chosen if entry.arm.known_as == robot]
    if only and not of_arm:
        raise InputError(f"{only} is a recording of {chosen[0].arm.known_as}, not of {robot}")
    sensed = [part for entry in of_arm if (part := _recording(study, arm, entry))]
    if not sensed:
        raise InputError(
            f"{study.folder} has no reading of a force sensor on {only or robot}; record one, and "
            "`ur5 run` the study again"
        )
    return json_text(
        {"arm": robot, "formula": FORMULA, "recordings": sensed, "spread": spread(sensed)}
    )


def _recording(study: StudyFiles, arm: Robot, entry: Recording) -> dict[str, Any] | None:
    """Return a recording's start and its results on the sensor; None without a sensor."""
    quality, sensor = study.quality(entry.name), study.beside_sensor(entry.name)
    if sensor.offset is None:
        return None
    found = study.judgement(entry.name).findings + sensor.findings()
    place = arm.with_force_sensor(*entry.sensor_mounting()).mounting
    return {
        "recording": entry.name,
        "start": _start(quality, entry),
        "duration_s": quality.duration_s,
        "temperature": _last_temperature(study.record(Signals, entry.name)),
        "remarks": [one.sentence() for one in found if _is_doubt(one)],
        "reading": _reading(quality),
        "gravity": [*arm.mounted(entry.known_gravity()).gravity],
        "position": [*place.force_sensor],
        "turn_deg": [*place.force_sensor_turn_deg],
        **offset_of(sensor.offset),
    }


def offset_of(offset: OffsetAccount) -> dict[str, Any]:
    """Return the values subtracted from a reading, fitted ones with their 95 % interval."""
    inertia = offset.inertia and [*offset.inertia]
    return {
        "free_share": offset.free,
        "bias": _named(WRENCH, offset.bias, offset.bias_std),
        "mass": _interval(offset.mass, offset.mass_std),
        "first_moment": _named(AXES, offset.moment_arm, offset.moment_arm_std),
        "center_of_mass": _named(AXES, *_center(offset)),
        "pull_at": offset.pull_at.tolist(),
        "inertia": inertia,
        "clock_std": offset.clock_std,
    }


def spread(recordings: Sequence[dict[str, Any]]) -> dict[str, Any] | None:
    """Return the spread of mass, bias and centre of mass over the recordings with a mass.

    recordings: as in `compensation`. None with fewer than two such recordings.
    """
    weighed = [recording for recording in recordings if recording["mass"]]
    if len(weighed) < 2:
        return None
    vectors = {"bias": WRENCH, "center_of_mass": AXES}
    return {
        "recordings": [recording["recording"] for recording in weighed],
        "mass": _apart(recording["mass"] for recording in weighed),
        **{
            vector: {name: _apart(one[vector][name] for one in weighed) for name in names}
            for vector, names in vectors.items()
        },
    }


def _apart(intervals: Iterable[Interval | None]) -> dict[str, float] | None:
    """Return the lowest and the highest of some values and their standard deviation; None with
    fewer than two values.
    """
    values = [one["value"] for one in intervals if one]
    if len(values) < 2:
        return None
    std = float(np.std(values, ddof=1))
    return {"lowest": min(values), "highest": max(values), "std": std}


def _start(quality: Quality, entry: Recording) -> str | None:
    """Return the start of a recording in ISO 8601, else its date, else None."""
    if quality.start_epoch_s is None:
        return None if entry.date is None else str(entry.date)
    return datetime.fromtimestamp(quality.start_epoch_s, UTC).isoformat(timespec="seconds")


def _last_temperature(signals: Signals) -> float | None:
    """Return the mean temperature [°C] of the last joint, which is next to the sensor."""
    known = signals.joint_temperatures
    return None if known is None else float(np.nanmean(known[:, -1]))


def _is_doubt(one: Finding) -> bool:
    """Return whether a finding is about the sensor's bias, or concerns the whole recording."""
    return one.code in DOUBTS or one.severity == "stop"


def _reading(quality: Quality) -> str:
    """Return the sensor's channel: that of a sensor in the arm's wrist, else `ft`."""
    own = (name for f in quality.findings if f.code == Found.WRIST_SENSOR for name in f.channels)
    return next(own, "ft")


def _center(offset: OffsetAccount) -> tuple[Array, Array]:
    """Return the tool's centre of mass (3,) [m] and its error, NaN without a certain mass.

    c = h / m. The errors of m, from forces, and of the first moment h, from moments, are
    independent.
    """
    if not abs(offset.mass) > NORMAL95 * offset.mass_std:
        return np.full(3, np.nan), np.full(3, np.nan)
    center = offset.moment_arm / offset.mass
    return center, np.hypot(offset.moment_arm_std, center * offset.mass_std) / abs(offset.mass)


def _named(names: Sequence[str], values: Array, errors: Array) -> dict[str, Interval | None]:
    return {n: _interval(*pair) for n, *pair in zip(names, values, errors, strict=True)}


def _interval(value: float, error: float) -> Interval | None:
    """Return a value and its 95 % interval, None where it is unknown."""
    if not math.isfinite(value):
        return None
    half = NORMAL95 * float(error)
    return {"value": float(value), "low": float(value) - half, "high": float(value) + half}
