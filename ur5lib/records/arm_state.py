"""The health of an arm over time, and what can be observed on it."""

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

    temperature_c: of the motor [°C]; group: dates on which the arm moved along the same paths. None
    in `lost_frames`, a share of all frames.
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
    `ur5lib.timeseries.changes.Change`; by_temperature: what that explains of it.
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
    """Each quantity by date, and its changes; empty with too few dates."""

    dates: list[Condition] = field(default_factory=list)
    changes: list[JointChange] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class Observed:
    """A row of observability.csv: a quantity in a range of speed; speed_high: None without an end.

    quantity: smallest_push_95_x, _y, _z [N], along an axis, by speed of the flange;
    friction_in_band, the share of a joint's samples within the band of motion, by its speed;
    least_velocity [rad/s], the lower end of the speeds at which this share suffices, NaN where
    there is none; band_at_rest, the stated band at rest over that of motion; bound: ">" of a push
    beyond `value`, the largest that was tried.
    """

    quantity: str
    joint: int | None = None
    speed_low: float
    speed_high: float | None
    speed_unit: str
    bound: str = ""
    value: float
    std_error: float | None = None
    unit: str
    samples: float | None = None


@dataclass(frozen=True, kw_only=True)
class Repeated:
    """A row of repetition.csv: what runs of one path differ by over √2, which no function of the
    motion can avoid, beside the error on the same samples.

    quantity: current [A] (root mean squares), torque [Nm] of the fullest link model, force [N], for
    which that of the currents would pass in a contact (mean absolute values).
    """

    quantity: str
    joint: int | None = None
    component: str | None = None
    unit: str
    floor: float
    error: float
    paths: int
    samples: int
