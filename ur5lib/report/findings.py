"""Findings about recordings and remarks of steps: their sentences, and findings of one kind."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from string import Formatter
from typing import Any

import pandas as pd

from ur5lib.errors import Remark, printable
from ur5lib.recordings.quality import Finding
from ur5lib.strict import read_yaml

SEVERITIES = ("stop", "error", "warning", "note")  # most serious first; see docs/report.md

LONGEST = 120  # characters for the places of one finding
TEMPLATES = Path(__file__).parent / "templates/findings.yaml"


def group_findings(quality: pd.DataFrame) -> pd.DataFrame:
    """Group findings of one kind in one row: counts summed, each meaning stated once."""
    kinds = quality.groupby(["recording", "device", "finding", "severity"], sort=False)
    grouped = kinds.agg({"count": "sum", "detail": lambda details: _stated_once(list(details))})
    return grouped.reset_index()


def by_finding(quality: pd.DataFrame) -> pd.DataFrame:
    """Group findings of all recordings, one row a finding, most serious first.

    Stop signs and errors keep each meaning; of others, `detail` is that of the recording with the
    largest count, and `alike` whether all recordings have the same. `recordings` is a list.
    """
    grouped = group_findings(quality).sort_values("count", ascending=False, kind="stable")
    meaning = grouped["detail"].where(grouped["severity"].isin(("stop", "error")), "")
    kinds = grouped.groupby(["severity", "device", "finding", meaning], sort=False)
    rows = kinds.agg(
        recordings=("recording", list),
        detail=("detail", "first"),
        alike=("detail", lambda details: len({*details}) == 1),
    )
    return by_severity(rows.reset_index(level=[0, 1, 2]).reset_index(drop=True))


def by_severity(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows in the order of their severity, most serious first."""
    return rows.sort_values("severity", key=lambda s: s.map(SEVERITIES.index), kind="stable")


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


def shortened(detail: str) -> str:
    """Return a finding's detail with its list of places shortened."""
    places, _, meaning = detail.rpartition(": ")
    several = len(places) > LONGEST
    return f"{places[:LONGEST].rpartition(';')[0]} and others: {meaning}" if several else detail


class Words(Formatter):
    """Values in a sentence: lists are joined by commas, remarks by their format."""

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a value in words; NaN, which JSON does not know, is unknown."""
        if value is None:
            return "unknown"
        if isinstance(value, Mapping):
            return sentence(value["code"], value["values"])
        if not isinstance(value, list | tuple):
            return str(super().format_field(value, format_spec))
        if all(isinstance(one, Mapping) for one in value):
            return (format_spec or ", ").join(self.format_field(one, "") for one in value)
        return ", ".join(self.format_field(one, format_spec) for one in value)


@cache
def templates() -> dict[str, str]:
    """Return the sentences by code."""
    return dict(read_yaml(TEMPLATES))


def sentence(code: str, values: Mapping[str, Any]) -> str:
    """Return the sentence of a code, made printable: its values quote hostile files."""
    return printable(Words().vformat(templates()[code], (), values))


def in_words(remark: Remark) -> str:
    """Return the sentence of a remark."""
    return sentence(**asdict(remark))


def worded(finding: Finding) -> dict[str, str | int]:
    """Return a finding as a row whose code and values are replaced by the sentence `detail`."""
    row = asdict(finding)
    code, values = row.pop("code"), row.pop("values")
    return row | {"detail": sentence(code or finding.finding, values)}
