"""How each device's clock runs against the robot's."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "device",
    "offset_s",
    "offset_std_s",
    "drift_ppm",
    "drift_std_ppm",
    "method",
    "end_std_s",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    yield from clock_rows(results.all("clocks"))


def clock_rows(clocks: Mapping[str, Any]) -> Iterator[Row]:
    """Yield a row for each device; clocks: clocks.json by recording."""
    for recording, devices in clocks.items():
        for device, clock in devices.items():
            yield {
                "recording": recording,
                "device": device,
                "offset_s": clock["offset"],
                "offset_std_s": clock["offset_std"],
                "drift_ppm": _ppm(clock["drift"]),
                "drift_std_ppm": _ppm(clock["drift_std"]),
                "method": clock["method"],
                "end_std_s": clock["end_std"],
            }


def _ppm(drift: float | None) -> float | None:
    return None if drift is None else 1e6 * drift
