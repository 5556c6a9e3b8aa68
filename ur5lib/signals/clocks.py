"""How a device's clock runs against the robot's."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Clock:
    """t_robot = offset + (1 + drift) t_device, both counted from their own start stamps.

    offset, offset_std: [s]; drift, drift_std: dimensionless, None where it was not estimated;
    method: how the offset was found.
    """

    offset: float
    offset_std: float
    drift: float | None
    drift_std: float | None
    method: str


def clock_from_stamps(offset: float, std: float) -> Clock:
    """The clock that two start stamps tell [s]; they say nothing of a drift."""
    return Clock(offset, std, None, None, "start stamps")
