"""What was found in a recording, told in the same few words everywhere."""

from dataclasses import asdict, dataclass
from typing import Literal

from ur5lib.errors import printable

Device = Literal["robot", "force", "imu"]
SENSORS: dict[str, Device] = {"force_sensor": "force", "imu": "imu"}  # by the study's key


@dataclass(frozen=True)
class Finding:
    """One kind of defect in one device's files.

    severity: error (the device is unusable), warning (results may suffer), note (harmless);
    count: how many samples, rows or files; detail: one sentence on what it is and what it means.
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
        """The finding as a row of the quality table."""
        return asdict(self)
