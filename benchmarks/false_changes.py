"""How often an arm that did not change shows a change between dates, and which changes are found.

Each arm has six joints with five quantities on twenty dates. Their values differ from date to date
by noise, which is correlated with that of the date before (an autoregression of first order). In
one arm nothing changes; in a copy of it, one quantity drifts and another one jumps. Both changes
are 5 and 10 standard deviations of that noise large.
"""

from dataclasses import replace

import numpy as np

from benchmarks.harness.options import asked
from ur5lib.topics.health.changes import (
    FALSE_ALARM_PROBABILITY,
    DatedSeries,
    coloured,
    find_changes,
)

ARMS, DATES, APART = 100, 20, 3.0  # days between dates
SERIES = 30  # of an arm: six joints, five quantities
CORRELATIONS = (0.0, 0.3, 0.5, 0.6)  # of neighbouring dates
SPREAD, STATED = 0.02, 0.01  # of a value of 1: deviation between dates, stated standard error
SIZES = (5.0, 10.0)  # standard deviations from date to date
LEVEL = FALSE_ALARM_PROBABILITY / SERIES


def main() -> None:
    """Print the share of arms with a false change, and of changes that are found."""
    arms, quick = asked(__doc__, ARMS)
    series = 2 if quick else SERIES
    print(f"{arms} seeds, {series} quantities on {DATES} dates")
    print("| correlation of dates | arms with a false change | size | drifts found | jumps found |")
    print("| --- | --- | --- | --- | --- |")
    for correlation in CORRELATIONS:
        drawn = [arm(seed, correlation, series) for seed in range(arms)]
        false = sum(any(find_changes(own, LEVEL) for own in one) for one in drawn)
        for size in SIZES:
            drifts = sum(found(drifting(one[0], size), "drift") for one in drawn)
            jumps = sum(found(jumping(one[1], size), "jump") for one in drawn)
            print(f"| {correlation:g} | {false} of {arms} | {size:g} | {drifts} | {jumps} |")


def arm(seed: int, correlation: float, series: int) -> list[DatedSeries]:
    """Return the quantities of an arm that does not change."""
    independent = np.random.default_rng(seed).standard_normal((series, DATES))
    day, error = APART * np.arange(DATES, dtype=float), np.full(DATES, STATED)
    return [DatedSeries(day, 1 + SPREAD * row, error) for row in coloured(independent, correlation)]


def drifting(series: DatedSeries, size: float) -> DatedSeries:
    """Return a series that rises evenly by a size [standard deviations]."""
    return replace(series, value=series.value + size * SPREAD * np.linspace(0, 1, DATES))


def jumping(series: DatedSeries, size: float) -> DatedSeries:
    """Return a series that jumps by a size [standard deviations] on the date in the middle."""
    return replace(series, value=series.value + size * SPREAD * (np.arange(DATES) >= DATES // 2))


def found(series: DatedSeries, kind: str) -> bool:
    """Return whether the first found change is of this kind."""
    changes = find_changes(series, LEVEL)
    return bool(changes) and changes[0].kind == kind


if __name__ == "__main__":
    main()
