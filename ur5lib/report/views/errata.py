"""Errors found in the published work."""

from ur5lib.report.results import Results


def listed(results: Results) -> list[str]:
    """Return each erratum with its place and the choice made here."""
    return [f"{each.place}: {each.error} Here: {each.choice}" for each in results.errata]
