"""Reader of force sensor and IMU files, each on its own clock."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.channels import columns
from ur5lib.errors import InputError
from ur5lib.recordings.delimited import TextTable, drop_untimed
from ur5lib.recordings.entries import Clocked, Sensor, WithSensors, expand
from ur5lib.recordings.frozen import frozen_end, report_frozen
from ur5lib.recordings.held_samples import fresh_samples
from ur5lib.recordings.host_clock import without_delays
from ur5lib.recordings.ordering import drop_repeats, epochs
from ur5lib.recordings.plausibility import drop_implausible, first_time
from ur5lib.recordings.recording import DeviceRecord, Stamp
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Device, Finding, Log, add_finding
from ur5lib.strict import expect_file
from ur5lib.timeseries.arrays import Array

FORCE_CHANNELS = columns("ft")
FORCES = FORCE_CHANNELS[:3]  # all that some sensors have
UNCONNECTED_READING = 1e-6  # N, Nm; largest value that an unconnected force sensor writes
# In usual steps. From the first on, samples count as lost; the second is reported even if single.
GAP_STEPS, LONG_GAP_STEPS = 2.5, 4.0
MAX_STAMP_LENGTH = 1000  # a file with a stamp has at most this many characters
MAX_SHARE_LOST = 0.01  # share of samples; fewer lost or stale ones are ordinary jitter
MATCHED_STD, MATCHED_DRIFT_STD = 0.01, 2e-4  # s, and share, of clocks matched by forces
STAMP_STD = 0.05  # s, uncertainty of a start stamp of unknown origin


@dataclass(frozen=True)
class SensorSamples:
    """A sensor's samples, and the timestamp [s] of its first row, even if that was damaged and left
    out.
    """

    table: pd.DataFrame
    first: float


def read_sensors(recording: WithSensors, findings: list[Finding]) -> dict[Device, DeviceRecord]:
    """Return the records of the sensors in a recording's entry; those that recorded nothing are
    left out.
    """
    records = {
        device: read_sensor(Path(recording.folder), sensor, device, findings)
        for device, sensor in recording.sensors().items()
    }
    return {device: record for device, record in records.items() if record is not None}


def read_device(
    log: Log,
    names: list[str],
    clocked: Clocked = Clocked(),  # noqa: B008 - frozen
) -> SensorSamples | None:
    """Return a sensor's complete rows in order; None, and a finding, when there are none.

    clocked: its units and time base. A damaged sensor file never makes the robot's data unusable;
    only an invalid unit in the study raises InputError.
    """
    clocked.in_si(pd.DataFrame(columns=names, dtype=float))
    if (absent := _absence(log)) is not None:
        log.findings.append(absent)
        return None
    return log.unless_unusable(
        lambda: repair_samples(without_delays(clocked.in_si(*TextTable(log).rows(names))), log)
    )


def first_number(path: Path, ended: bool = False) -> float | None:
    """Return the number that a file begins with, as in the thesis's start stamps; None if there is
    none.

    ended: whether the line must end in a newline, without which its number is incomplete. Raises
    InputError where the path leads to no file.
    """
    expect_file(path)
    text = ""
    if path.is_file():
        with path.open(errors="replace") as stream:
            text = stream.read(MAX_STAMP_LENGTH)
    words = text.split()
    try:
        number = float(words[0]) if words and (text[len(words[0]) :] or not ended) else math.nan
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def counted_from_first(
    table: pd.DataFrame, first: float, clocked: Clocked, path: Path
) -> DeviceRecord:
    """Return a record with its time counted from its first row, which is the zero of its clock.

    first: time of that row [s].
    """
    start = Stamp(first, STAMP_STD, clocked.time)
    return DeviceRecord(table.assign(time=table["time"] - first), start, str(path))


def on_robot_clock(sensor: DeviceRecord) -> DeviceRecord:
    """Return the record of a sensor that shares the robot's stamps, with a start uncertain by a
    part of a sample and no drift.
    """
    assert sensor.start is not None
    late = float(np.median(np.diff(sensor.table["time"])) / np.sqrt(12))  # evenly distributed
    return replace(sensor, start=replace(sensor.start, std=late, drift_std=0.0))


def _absence(log: Log) -> Finding | None:
    """Return a note if a sensor has no file, or an empty one; else None."""
    path, name = log.path, log.path.name
    if not path.exists():
        return Finding(log.device, Found.NO_SENSOR, "note", 1, f"{name} does not exist")
    if not path.is_file():
        return None  # what it is instead is reported when it is read
    with path.open("rb") as stream:
        head = stream.read(100)
    if b"no values recorded" in head or not head.strip():
        return _unconnected(log, f"{name} is empty", "no values were recorded")
    return None


def _unconnected(log: Log, place: str, meaning: str) -> Finding:
    return Finding(log.device, Found.NO_SENSOR, "note", 1, f"{place}: {meaning}", place)


def repair_samples(table: pd.DataFrame, log: Log) -> SensorSamples | None:
    """Return the plausible samples in order, each once; None, and a finding, where there are none.

    Raises InputError for wrong units.
    """
    table = drop_untimed(table, log)
    if (absent := _nothing(table, log)) is not None:
        log.findings.append(absent)
        return None
    table = drop_implausible(table, str(log.path), log.device, log.findings)
    # a sensor samples fast enough to do without rows with empty cells
    complete = np.isfinite(table.to_numpy()).all(axis=1)
    detail = "samples with empty cells; discarded"
    add_finding(log.findings, log.device, Found.MISSING_CELLS, "warning", (~complete).sum(), detail)
    whole = _in_order(table[complete].reset_index(drop=True), log.device, log.findings)
    whole = _without_held(_until_frozen(whole, log), log)
    if len(whole) < 2:
        raise InputError(
            f"{log.path}: has fewer than two samples with possible values; record it again"
        )
    _report_timing(whole["time"].to_numpy(), log.device, log.findings)
    return SensorSamples(whole, first_time(table["time"].to_numpy()))


def _until_frozen(table: pd.DataFrame, log: Log) -> pd.DataFrame:
    """Return the samples of a table, without those at its end that all repeat one reading."""
    time = table["time"].to_numpy(float)
    first = frozen_end(table.drop(columns="time").to_numpy(float), time)
    if first is None:
        return table
    report_frozen(log.findings, log.device, str(log.path.name), time, first)
    return table[:first]


def _without_held(table: pd.DataFrame, log: Log) -> pd.DataFrame:
    """Return the samples of a table, without rows in which a slow sensor's are repeated."""
    fresh = fresh_samples(table.drop(columns="time").to_numpy())
    if fresh is None:
        return table
    rate = float((fresh.sum() - 1) / np.ptp(table["time"][fresh]))
    meaning = (
        f"the sensor measures at {number(rate, '.3g')} Hz, and its values are repeated in faster "
        f"rows: only new ones count, so that contacts of less than {number(1 / rate, '.2g')} s may "
        "be missed"
    )
    log.add(Found.HELD_SAMPLES, "warning", (~fresh).sum(), meaning)
    return table[fresh].reset_index(drop=True)


def _nothing(table: pd.DataFrame, log: Log) -> Finding | None:
    """Return a note on why a sensor's rows are unusable, None if they can be used."""
    whole, name = table.dropna(), log.path.name
    if len(whole) < 2:
        detail = f"{name} has fewer than two complete rows of {len(table.columns)} numbers"
        return Finding(log.device, Found.NO_SENSOR, "note", 1, detail)
    readings = whole.drop(columns="time").abs()
    if log.device == "force" and (readings <= UNCONNECTED_READING).all(axis=None):
        return _unconnected(log, f"{name} contains only zeros", "no sensor was connected")
    return None


def _in_order(table: pd.DataFrame, device: Device, findings: list[Finding]) -> pd.DataFrame:
    table = drop_repeats(table, device, findings)
    later = epochs(table["time"].to_numpy()) > 0
    detail = "the device's clock restarts; the samples after that are discarded"
    add_finding(findings, device, Found.CLOCK_RESET, "warning", later.sum(), detail)
    table = table[~later]
    backwards = (table["time"].diff() < 0).sum()
    detail = "samples come after later ones; sorted by time"
    add_finding(findings, device, Found.SAMPLES_OUT_OF_ORDER, "note", backwards, detail)
    return table.sort_values("time", kind="stable", ignore_index=True)


def _report_timing(time: Array, device: Device, findings: list[Finding]) -> None:
    """Add findings on lost samples and repeated timestamps beyond a device's ordinary jitter."""
    steps = np.diff(time)
    _report_lost(steps[steps > 0], device, findings)
    still = int((steps == 0).sum())
    if still > MAX_SHARE_LOST * len(time):
        detail = "samples with the timestamp of the previous one"
        add_finding(findings, device, Found.STALE_STAMPS, "warning", still, detail)


def _report_lost(steps: Array, device: Device, findings: list[Finding]) -> None:
    """Add a finding on lost samples, by the steps [s] between timestamps."""
    if not len(steps):
        return
    usual, median = np.quantile(steps, [0.25, 0.5])
    lost = int(np.rint(steps[steps > GAP_STEPS * usual] / median - 1).clip(min=0).sum())
    if lost > MAX_SHARE_LOST * (len(steps) + 1) or steps.max() > LONG_GAP_STEPS * median:
        detail = (
            f"longest step {number(1000 * steps.max(), '.0f')} ms, "
            f"median step {number(1000 * median, '.1f')} ms"
        )
        add_finding(findings, device, Found.LOST_SAMPLES, "warning", max(lost, 1), detail)


def read_sensor(
    folder: Path,
    sensor: Sensor,
    device: Device,
    findings: list[Finding],
    std: float = STAMP_STD,
    ended: bool = False,
) -> DeviceRecord | None:
    """Return the record of a sensor's file, None if it recorded nothing.

    A clock that is not relative is counted from its first sample. std: uncertainty of the stamp in
    `start_file` [s]; ended: whether that file must end in a newline.
    """
    path = folder / sensor.file
    samples = read_device(Log(path, device, findings), expand(sensor.columns), sensor)
    if samples is None:
        return None
    counted = counted_from_first(samples.table, samples.first, sensor, path)
    if sensor.offset_s is not None:
        later = (1 + 1e-6 * sensor.drift_ppm) * counted.table["time"]
        matched = Stamp(0.0, MATCHED_STD, "first_frame", MATCHED_DRIFT_STD)
        table = counted.table.assign(time=sensor.offset_s + later)
        return DeviceRecord(table, matched, str(path))
    if sensor.start_file is None:
        return counted
    began = Log(folder / sensor.start_file, device, findings)
    zero = began.unless_unusable(lambda: first_number(began.path, ended))
    scale = 1000 if sensor.start == "day_ms" else 1
    stamp = None if zero is None else Stamp(zero / scale, std, sensor.start)
    table = samples.table if sensor.time == "relative_s" else counted.table
    return DeviceRecord(table, stamp, str(path))
