"""How much of a recording each device recorded: one may have died, or started late."""

from ur5lib.recordings.quality import Device, Finding

TOLERANCE = 2.0  # s that a device may lack at the start and the end together
UNSURE = 0.005  # share of a recording that a clock may drift
SPREAD = 3.0  # standard deviations of a start stamp that may be its error
TOLD = 0.05  # s, shortest part that is told
FINDING = "part missing"

Span = tuple[float, float]  # first and last sample [s], by the robot's clock


def sensor_coverage(device: Device, span: Span, robot: Span, std: float) -> list[Finding]:
    """Return a warning where a sensor recorded only a part of the robot's recording.

    std: standard uncertainty of its start stamp [s].
    """
    late, early = max(0.0, span[0] - robot[0]), max(0.0, robot[1] - span[1])
    whole = robot[1] - robot[0]
    if late + early <= TOLERANCE + UNSURE * whole + SPREAD * std:
        return []
    lacks = {(True, False): "start missing", (False, True): "end missing"}
    values = {"covered_s": whole - late - early, "whole_s": whole, "late_s": late, "early_s": early}
    code = lacks.get((late >= TOLD, early >= TOLD), "start and end missing")
    return [Finding(device, FINDING, "warning", 1, values, code)]


def robot_coverage(robot: Span, sensors: Span) -> list[Finding]:
    """Return a warning where the robot recorded only a part of a session with sensors.

    sensors: from the first sample of any to the last, by the clock of the one host of all devices.
    """
    whole = min(robot[0], sensors[0]), max(robot[1], sensors[1])
    covered, total = robot[1] - robot[0], whole[1] - whole[0]
    if total - covered <= TOLERANCE + UNSURE * total:
        return []
    values = {"covered_s": covered, "whole_s": total}
    return [Finding("robot", FINDING, "warning", 1, values, "robot missing")]
