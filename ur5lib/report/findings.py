"""Findings of one kind as one row."""

import pandas as pd


def group_findings(quality: pd.DataFrame) -> pd.DataFrame:
    """Findings of one kind as one row: counts summed, details that differ in a place said once."""
    kinds = quality.groupby(["recording", "device", "finding", "severity"], sort=False)
    grouped = kinds.agg({"count": "sum", "detail": lambda details: _said_once(list(details))})
    return grouped.reset_index()


def _said_once(details: list[str]) -> str:
    places, rests = zip(*(detail.rpartition(": ")[::2] for detail in details), strict=True)
    return f"{'; '.join(places)}: {rests[0]}" if len(details) > 1 else details[0]
