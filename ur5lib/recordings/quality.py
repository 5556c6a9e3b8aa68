"""Findings about the quality of a recording."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Literal

Device = Literal["robot", "force", "imu"]
SENSORS: dict[str, Device] = {"force_sensor": "force", "imu": "imu"}  # by key of the study


@dataclass(frozen=True)
class Finding:
    """One kind of defect in one device's files.

    severity: stop (the recording contradicts the study), error (the device is unusable), warning
    (results may suffer), note (harmless); count: number of samples, rows or files; values: numbers
    and names in the sentence about it, which stands in `report/templates/findings.yaml` under its
    code, or else under the finding's name.
    """

    device: Device
    finding: str
    severity: Literal["stop", "error", "warning", "note"]
    count: int
    values: Mapping[str, object] = field(default_factory=dict)
    code: str = ""

    def as_row(self) -> dict[str, object]:
        """Return the finding as a row of the quality table."""
        return asdict(self)


def contradiction(code: str, **values: object) -> Finding:
    """Return a stop sign: what contradicts the study so much that no forces may be stated."""
    return Finding("robot", "contradiction", "stop", 1, values, code)
