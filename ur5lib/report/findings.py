"""Grouping of findings of one kind."""

import pandas as pd

SEVERITIES = ("stop", "error", "warning", "note")  # most serious first; see docs/report.md


def group_findings(quality: pd.DataFrame) -> pd.DataFrame:
    """Group findings of one kind in one row: counts summed, repeated parts of details once."""
    kinds = quality.groupby(["recording", "device", "finding", "severity"], sort=False)
    grouped = kinds.agg({"count": "sum", "detail": lambda details: _said_once(list(details))})
    return grouped.reset_index()


def _said_once(details: list[str]) -> str:
    places, rests = zip(*(detail.rpartition(": ")[::2] for detail in details), strict=True)
    return f"{'; '.join(places)}: {rests[0]}" if len(details) > 1 else details[0]
