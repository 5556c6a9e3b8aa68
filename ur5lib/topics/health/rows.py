"""The health of an arm over time: by recording, by date, and its changes."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from ur5lib.timeseries.arrays import Array

Estimate = tuple[float, float]  # value and standard error


@dataclass(frozen=True)
class Checkup:
    """The condition of an arm on a date (ISO 8601), by one recording.

    joints: estimates by quantity, of joints 1 to n; temperature: (n,) [°C], mean of each motor, NaN
    where not recorded; lost: share of lost frames. Without a date, the recording cannot be used.
    """

    date: str = ""
    joints: list[dict[str, Estimate]] = field(default_factory=list)
    temperature: Array = field(default_factory=lambda: np.empty(0))
    lost: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Condition:
    """A row of health.csv: a quantity of a joint on a date (ISO 8601), with its standard error.

    temperature_c: of the motor [°C]; group: number of the group of dates on which the arm moved
    along the same paths. A row of the quantity `lost_frames`, a share of all frames, has only a
    date and a value.
    """

    date: str
    joint: int | None = None
    quantity: str
    value: float
    std_error: float | None = None
    temperature_c: float | None = None
    group: int | None = None


@dataclass(frozen=True, kw_only=True)
class JointChange:
    """A row of health_changes.csv: a change of a joint's quantity between two dates, as
    `ur5lib.topics.health.changes.Change`; by_temperature: what that explains of it.
    """

    joint: int
    quantity: str
    kind: Literal["drift", "jump"]
    first: str
    last: str
    before: float
    size: float
    std_error: float
    low: float
    high: float
    by_temperature: float
    chance: float


@dataclass(frozen=True)
class Health:
    """The rows of health.csv (each quantity by date) and of health_changes.csv of an arm; empty
    with too few dates.
    """

    dates: list[Condition] = field(default_factory=list)
    changes: list[JointChange] = field(default_factory=list)
