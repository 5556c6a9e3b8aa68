"""The health of an arm over time."""

from dataclasses import dataclass, field
from typing import Literal


@dataclass(frozen=True)
class Condition:
    """A quantity of a joint on a date (ISO 8601), with its standard error.

    temperature_c: of the motor [°C]; group: dates on which the arm moved along the same paths. None
    in `lost_frames`, a share of all frames.
    """

    date: str
    quantity: str
    value: float
    joint: int | None = None
    temperature_c: float | None = None
    group: int | None = None
    std_error: float | None = None


@dataclass(frozen=True, kw_only=True)
class JointChange:
    """A change of a joint's quantity between two dates, as `ur5lib.timeseries.changes.Change`."""

    kind: Literal["drift", "jump"]
    first: str
    last: str
    before: float
    size: float
    std_error: float
    low: float
    high: float
    explained: float
    chance: float
    joint: int
    quantity: str


@dataclass(frozen=True)
class Health:
    """health.json: each quantity by date, and its changes; empty with too few dates."""

    dates: list[Condition] = field(default_factory=list)
    changes: list[JointChange] = field(default_factory=list)
