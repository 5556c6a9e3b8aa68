"""Findings about the quality of a recording."""

from dataclasses import asdict, dataclass
from typing import Literal

from ur5lib.errors import printable

Device = Literal["robot", "force", "imu"]
SENSORS: dict[str, Device] = {"force_sensor": "force", "imu": "imu"}  # by key of the study


@dataclass(frozen=True)
class Finding:
    """One kind of defect in one device's files.

    severity: error (the device is unusable), warning (results may suffer), note (harmless);
    count: number of samples, rows or files; detail: what was found, and what was done about it.
    """

    device: Device
    finding: str
    severity: Literal["error", "warning", "note"]
    count: int
    detail: str

    def __post_init__(self) -> None:
        """Keep the detail as it may be printed: it quotes files."""
        object.__setattr__(self, "detail", printable(self.detail))

    def as_row(self) -> dict[str, object]:
        """Return the finding as a row of the quality table."""
        return asdict(self)
