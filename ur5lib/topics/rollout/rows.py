"""The table of rollouts."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class RolledOut:
    """A row of rollout.csv: how far an arm, simulated under recorded efforts from a recorded state,
    is from where it went, after a time.

    model: `identified arm`; the same with another link model, by its name; `without friction`; `as
    described`, the description's links, rotors and torque constants alone; `standing still`;
    joint: None of the flange; error: median over windows [deg, mm], low, high: its 95 % interval;
    largest: nine of ten windows are below; floor: of windows that others repeat, what the
    identified arm's errors in both differ by over √2, median over so many repeats; apart: distance
    from the identified arm, median; closer: share of windows in which that is closer, with its 95 %
    interval; beaten: whether this is more than half of them, yes, no, or open where the interval
    contains a half; why it is not: both are `alike`, less than half of the identified arm's error
    apart; `repeats` differ by half of that error or more; there are too `few` windows; or it is
    `worse`.
    """

    model: str
    horizon_s: float
    joint: int | None = None
    unit: Literal["deg", "mm"]
    error: float
    low: float
    high: float
    largest: float
    floor: float | None = None
    repeats: int | None = None
    apart: float | None = None
    closer: float | None = None
    closer_low: float | None = None
    closer_high: float | None = None
    beaten: Literal["yes", "no", "open"] | None = None
    why: Literal["alike", "repeats", "few", "worse"] | None = None
    windows: int
    recordings: int
