"""What a simulation's truth adds to the findings: that stated intervals are too wide or narrow."""

from collections.abc import Iterator

from ur5lib.report.results import Results
from ur5lib.report.stated import stated

TABLES = ("truth",)
REMARKABLE_CHANCE = 0.025  # below it, the count of intervals that contain the truth is remarkable
LEVEL = 0.95  # of stated intervals


def findings(results: Results) -> Iterator[str]:
    """Report intervals that contain the truth too often or too seldom, as of independent values."""
    from scipy.special import bdtr, bdtrc  # slow to import, for studies without a truth

    told = results.rows("truth")["within95"].dropna()
    count, inside = len(told), int((told == "yes").sum())
    many, few = bdtrc(inside - 1, count, LEVEL), bdtr(inside, count, LEVEL)
    words = {"inside": inside, "count": count, "right": LEVEL * count}
    if count and few < REMARKABLE_CHANCE:
        yield stated(results, "narrow intervals", **words)
    elif count and many < REMARKABLE_CHANCE:
        yield stated(results, "wide intervals", **words)
