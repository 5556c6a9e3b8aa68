"""What a simulation's truth adds to the findings: intervals that are too wide or too narrow."""

from collections.abc import Iterator
from typing import NamedTuple

from ur5lib.records.phrases import number
from ur5lib.report.results import Results

TABLES = ("truth",)
REMARKABLE_CHANCE = 0.025  # one-sided; a less probable number of such intervals is reported
LEVEL = 0.95  # stated intervals contain the truth with this probability


class Count(NamedTuple):
    """How many of the intervals that a study states contain the truth, and how many should.

    values: number of intervals; chance: one-sided p-value for independent values; too: wide or
    narrow, if the chance is small.
    """

    values: int
    inside: int
    expected: float
    chance: float
    too: str | None


def findings(results: Results) -> Iterator[str]:
    """Report intervals that contain the truth too often or too seldom for independent values."""
    count = counted(results)
    if count and count.too:
        yield (
            f"Intervals are too {count.too}: {count.inside} of {count.values} contain the truth of "
            f"the simulation, where {number(count.expected, '.0f')} would be right."
        )


def counted(results: Results) -> Count | None:
    """Return the count of a study's intervals, None without any."""
    within = results.rows("truth")["within95"].dropna()
    if within.empty:
        return None
    from scipy.special import bdtr, bdtrc  # slow to import, for studies without a truth

    count, inside = len(within), int((within == "yes").sum())
    chances = {"wide": bdtrc(inside - 1, count, LEVEL), "narrow": bdtr(inside, count, LEVEL)}
    side = min(chances, key=lambda side: float(chances[side]))
    too = side if chances[side] < REMARKABLE_CHANCE else None
    return Count(count, inside, LEVEL * count, float(chances[side]), too)
