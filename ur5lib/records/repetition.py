"""The differences between repeated motions of an arm."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Repeated:
    """A row of repetition.csv: what runs of one path differ by over √2, which no function of the
    motion can avoid, with the error on the same samples.

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
