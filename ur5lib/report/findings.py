"""Findings about files: counted, and grouped by kind."""

import pandas as pd

from ur5lib.report.sentences import Sentence, joined, say

SEVERITIES = ("stop", "error", "warning", "note")  # most serious first; see docs/report.md

SPOKEN = {"stop": "stop sign"}


def count_findings(quality: pd.DataFrame) -> Sentence:
    """Return how many findings there are of each severity, most serious first."""
    counts = quality["severity"].value_counts()
    parts = [
        say("quality.severity", count=int(counts[name]), name=SPOKEN.get(name, name))
        for name in SEVERITIES
        if name in counts
    ]
    return joined(parts, ", ") if parts else say("quality.none")


def group_findings(quality: pd.DataFrame) -> pd.DataFrame:
    """Group findings of one kind in one row: counts summed, each meaning stated once."""
    kinds = quality.groupby(["recording", "device", "finding", "severity"], sort=False)
    grouped = kinds.agg({"count": "sum", "detail": lambda details: _stated_once(list(details))})
    return grouped.reset_index()


def _stated_once(details: list[str]) -> str:
    """Join details, "place: meaning" or a meaning alone, with the places of each meaning."""
    places: dict[str, list[str]] = {}
    for detail in dict.fromkeys(details):
        place, _, meaning = detail.rpartition(": ")
        places.setdefault(meaning, []).extend([place] if place else [])
    return "; ".join(
        ": ".join(["; ".join(named), meaning] if named else [meaning])
        for meaning, named in places.items()
    )
