"""Sensors of a recording: how much of it each recorded, and when its clock started."""

from dataclasses import replace

from ur5lib.recordings.ordering import epochs
from ur5lib.recordings.plausibility import before_reset
from ur5lib.recordings.recording import DeviceRecord, RawRecording
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Device, Finding, StartOffset, add_finding

MAX_MISSING_TIME = 2.0  # s that a device may lack at the start and the end together
MAX_CLOCK_DRIFT = 0.005  # share of a recording that a clock may drift
START_STAMP_SPREAD = 3.0  # standard deviations of a start stamp that may be its error
MIN_REPORTED_TIME = 0.05  # s, shortest missing part that is reported

Span = tuple[float, float]  # first and last sample [s], by the robot's clock


def sensor_coverage(device: Device, span: Span, robot: Span, std: float) -> list[Finding]:
    """Return a warning where a sensor recorded only a part of the robot's recording.

    span, robot: first and last sample of each [s], by the robot's clock; std: standard uncertainty
    of the sensor's start stamp [s].
    """
    late, early = max(0.0, span[0] - robot[0]), max(0.0, robot[1] - span[1])
    whole = robot[1] - robot[0]
    if late + early <= MAX_MISSING_TIME + MAX_CLOCK_DRIFT * whole + START_STAMP_SPREAD * std:
        return []
    covered = f"covers only {number(whole - late - early, '.1f')} of {number(whole, '.1f')} s"
    starts = f"it starts {number(late, '.1f')} s after the robot"
    ends = f"ends {number(early, '.1f')} s before"
    lacks = {(True, False): starts, (False, True): f"it {ends} the robot"}
    reported = late >= MIN_REPORTED_TIME, early >= MIN_REPORTED_TIME
    lacking = lacks.get(reported, f"{starts} and {ends} it")
    detail = f"{covered}: {lacking}; nothing is compared with it there"
    return [Finding(device, Found.PART_MISSING, "warning", 1, detail)]


def robot_coverage(robot: Span, sensors: Span) -> list[Finding]:
    """Return a warning where the robot recorded only a part of the time in which sensors recorded.

    sensors: from the first sample of any to the last, by the robot's clock, to which the stamps of
    their host relate it.
    """
    whole = min(robot[0], sensors[0]), max(robot[1], sensors[1])
    covered, total = robot[1] - robot[0], whole[1] - whole[0]
    if total - covered <= MAX_MISSING_TIME + MAX_CLOCK_DRIFT * total:
        return []
    detail = (
        f"covers only {number(covered, '.1f')} of the {number(total, '.1f')} s that the sensors "
        "recorded; there is no estimate for the rest"
    )
    return [Finding("robot", Found.PART_MISSING, "warning", 1, detail)]


def place_sensors(
    recording: RawRecording, findings: list[Finding]
) -> dict[Device, tuple[DeviceRecord, StartOffset]]:
    """Return, by device, the records of the sensors and the start of each one's clock relative to
    the robot's.

    A sensor without a start stamp, or that was never on with the robot, is left out, and so are
    samples after a reset of the robot's clock, since nothing shows when they were taken. `findings`
    gets a finding for each.
    """
    placed, robot = {}, _span(recording.robot)
    was_reset = bool(epochs(recording.robot.table["time"].to_numpy(float)).any())
    for device, record in recording.sensors.items():
        offset = _offset(recording.robot, record)
        if offset is None:
            detail = "start stamp missing or incomplete: the clock cannot be aligned; not used"
            findings.append(Finding(device, Found.NO_START_STAMP, "warning", 1, detail))
            continue
        begin, end = (offset.seconds + edge for edge in _span(record))
        if max(robot[0], begin) >= min(robot[1], end):
            detail = (
                f"started {number(offset.seconds, '+.0f')} s from the robot and has no data during "
                "the recording: probably a file of another run; not used"
            )
            findings.append(Finding(device, Found.STALE_COPY, "warning", 1, detail))
        else:
            if was_reset:
                record = _until(record, robot[1] - offset.seconds, device, findings)
            placed[device] = (record, offset)
            findings += sensor_coverage(device, (begin, end), robot, offset.std)
    return placed


def _offset(robot: DeviceRecord, device: DeviceRecord) -> StartOffset | None:
    if robot.start is None or device.start is None:
        return None
    seconds = device.start.after(robot.start)
    # on the robot's clock, by the stamps of its host or its own, an error of its start is common
    others = robot.start.std if device.start.drift_std is None else 0.0
    std = (others**2 + device.start.std**2) ** 0.5
    return None if seconds is None else StartOffset(seconds, std, device.start.drift_std)


def _span(record: DeviceRecord) -> tuple[float, float]:
    """Return the first and last timestamp [s] before any clock reset, whatever the order of the
    rows.
    """
    time = record.table["time"].to_numpy(float)
    time = time[before_reset(time)]
    return float(time.min()), float(time.max())


def _until(
    record: DeviceRecord, end: float, device: Device, findings: list[Finding]
) -> DeviceRecord:
    """Return a sensor's record up to `end` by its own clock [s]; later samples are reported."""
    later = record.table["time"] > end
    detail = (
        "samples after the restart of the controller's clock, discarded: nothing tells when they "
        "were"
    )
    add_finding(findings, device, Found.CLOCK_RESET, "warning", later.sum(), detail)
    return replace(record, table=record.table[~later])
