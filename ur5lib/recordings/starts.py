"""Which sensors belong to a recording, and when their clocks started."""

from dataclasses import dataclass

from ur5lib.recordings.plausibility import stray_times
from ur5lib.recordings.quality import Device, Finding
from ur5lib.recordings.recording import DeviceRecord, RawRecording


@dataclass(frozen=True)
class StartOffset:
    """How much later than the robot's a device's clock started, by the stamps [s]."""

    seconds: float
    std: float


def place_sensors(
    recording: RawRecording, findings: list[Finding]
) -> dict[Device, tuple[DeviceRecord, StartOffset]]:
    """The sensors whose record overlaps the robot's, with the start of their clocks."""
    placed = {}
    for device, record in recording.sensors.items():
        offset = _offset(recording.robot, record)
        if offset is None:
            detail = "no start stamp, or a torn one: its clock cannot be placed, not used"
            findings.append(Finding(device, "no start stamp", "warning", 1, detail))
        elif not _overlap(recording.robot, record, offset.seconds):
            detail = (
                f"started {offset.seconds:+.0f} s from the robot and recorded nothing beside it: "
                "of another run, or lost; not used"
            )
            findings.append(Finding(device, "stale copy", "warning", 1, detail))
        else:
            placed[device] = (record, offset)
    return placed


def _offset(robot: DeviceRecord, device: DeviceRecord) -> StartOffset | None:
    if robot.start is None or device.start is None:
        return None
    seconds = device.start.after(robot.start)
    std = (robot.start.std**2 + device.start.std**2) ** 0.5
    return None if seconds is None else StartOffset(seconds, std)


def _overlap(robot: DeviceRecord, device: DeviceRecord, offset: float) -> bool:
    (start, end), (device_start, device_end) = _span(robot), _span(device)
    return max(start, device_start + offset) < min(end, device_end + offset)


def _span(record: DeviceRecord) -> tuple[float, float]:
    """First and last stamp [s], in whatever order the rows are."""
    time = record.table["time"].to_numpy(float)
    time = time[~stray_times(time)]
    return float(time.min()), float(time.max())
