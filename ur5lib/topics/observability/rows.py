"""What can be observed on an arm: smallest pushes, and how well bands hold by speed."""

from dataclasses import dataclass

LARGEST_PUSH = "largest_push"  # quantity of the largest push that was tried


@dataclass(frozen=True, kw_only=True)
class Observed:
    """A row of observability.csv: a quantity in a range of speed; speed_high: None without an end.

    quantity: smallest_push_95_x, _y, _z [N], along an axis, by speed of the flange, and
    largest_push, that was tried; friction_in_band, the share of a joint's samples within the band
    stated there, by its speed; least_velocity [rad/s], the lower end of the speeds at which this
    share suffices, NaN where there is none; band_at_rest, the stated band at rest over that of
    motion; rest_band_factor, the multiple of the band within which 95 % of a resting joint's
    samples are; bound: ">" of a push beyond `value`, the largest that was tried.
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
