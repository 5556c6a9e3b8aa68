"""Selection of the sensors that belong to a recording, and the start of their clocks."""

from dataclasses import dataclass

from ur5lib.recordings.coverage import sensor_coverage
from ur5lib.recordings.plausibility import stray_times
from ur5lib.recordings.quality import Device, Finding
from ur5lib.recordings.recording import DeviceRecord, RawRecording


@dataclass(frozen=True)
class StartOffset:
    """How much later a device's clock started than the robot's, by the start stamps [s].

    drift_std: as in Stamp.
    """

    seconds: float
    std: float
    drift_std: float | None


def place_sensors(
    recording: RawRecording, findings: list[Finding]
) -> dict[Device, tuple[DeviceRecord, StartOffset]]:
    """Return the sensors whose record overlaps the robot's, and when their clocks started."""
    placed = {}
    for device, record in recording.sensors.items():
        offset = _offset(recording.robot, record)
        if offset is None:
            findings.append(Finding(device, "no start stamp", "warning", 1))
        elif not _overlap(recording.robot, record, offset.seconds):
            seconds = {"seconds": offset.seconds}
            findings.append(Finding(device, "stale copy", "warning", 1, seconds))
        else:
            placed[device] = (record, offset)
            begin, end = (offset.seconds + edge for edge in _span(record))
            findings += sensor_coverage(device, (begin, end), _span(recording.robot), offset.std)
    return placed


def _offset(robot: DeviceRecord, device: DeviceRecord) -> StartOffset | None:
    if robot.start is None or device.start is None:
        return None
    seconds = device.start.after(robot.start)
    std = (robot.start.std**2 + device.start.std**2) ** 0.5
    return None if seconds is None else StartOffset(seconds, std, device.start.drift_std)


def _overlap(robot: DeviceRecord, device: DeviceRecord, offset: float) -> bool:
    (start, end), (device_start, device_end) = _span(robot), _span(device)
    return max(start, device_start + offset) < min(end, device_end + offset)


def _span(record: DeviceRecord) -> tuple[float, float]:
    """Return the first and last timestamp [s], whatever the order of the rows."""
    time = record.table["time"].to_numpy(float)
    time = time[~stray_times(time)]
    return float(time.min()), float(time.max())
