"""What can be observed on an arm."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Observed:
    """A row of observability.csv: a quantity in a range of speed; speed_high: None without an end.

    quantity: smallest_push_95 [N], by speed of the flange, or smallest_push_95_x, _y, _z, along an
    axis; friction_in_band, the share of a joint's samples within the band of its friction, by its
    speed; least_velocity [rad/s], the lower end of the speeds at which this share suffices, NaN
    where there is none.
    """

    quantity: str
    joint: int | None = None
    speed_low: float
    speed_high: float | None
    speed_unit: str
    value: float
    std_error: float | None = None
    unit: str
    samples: float | None = None
