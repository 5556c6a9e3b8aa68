"""Observability on an arm: the coverage of the bands of currents by speed."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Observed:
    """A row of observability.csv: a quantity in a range of speed; speed_high: None without an end.

    quantity: friction_in_band, the share of a joint's samples within the band stated there, by its
    speed; least_velocity [rad/s], the lower end of the speeds at which this share suffices, NaN
    where there is none; band_at_rest, the stated band at rest over that of motion;
    rest_band_factor, the multiple of the band within which 95 % of a resting joint's samples are.
    """

    quantity: str
    joint: int
    speed_low: float
    speed_high: float | None
    speed_unit: str
    value: float
    unit: str
    samples: float | None = None
