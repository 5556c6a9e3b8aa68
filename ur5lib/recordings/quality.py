"""Findings about the quality of a recording."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Literal, SupportsInt, TypeVar

from ur5lib.errors import InputError

T = TypeVar("T")
Device = Literal["robot", "force", "imu"]
Severity = Literal["stop", "error", "warning", "note"]
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
    severity: Severity
    count: int
    values: Mapping[str, object] = field(default_factory=dict)
    code: str = ""

    def as_row(self) -> dict[str, object]:
        """Return the finding as a row of the quality table."""
        return asdict(self)


@dataclass(frozen=True)
class Log:
    """The findings about a file of a device."""

    path: Path
    device: Device
    findings: list[Finding]

    def add(
        self,
        finding: str,
        severity: Severity,
        count: SupportsInt = 1,
        code: str = "",
        **values: object,
    ) -> None:
        """Add a finding with the file's name, if it counts anything."""
        if count:
            named = {"file": self.path.name} | values
            self.findings.append(Finding(self.device, finding, severity, int(count), named, code))

    def unless_unusable(self, read: Callable[[], T | None]) -> T | None:
        """Return what a function reads of a sensor; None, and a finding, for an InputError."""
        try:
            return read()
        except InputError as error:
            values = {"error": str(error)}
            self.findings.append(Finding(self.device, "unusable sensor", "error", 1, values))
            return None


def contradiction(code: str, **values: object) -> Finding:
    """Return a stop sign: what contradicts the study so much that no forces may be stated."""
    return Finding("robot", "contradiction", "stop", 1, values, code)
