"""Findings about recordings and remarks of steps: their sentences, and findings of one kind."""

import math
import re
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from string import Formatter
from typing import Any

import pandas as pd

from ur5lib.errors import Remark, printable
from ur5lib.records.accepted import KINDS
from ur5lib.records.quality import Finding
from ur5lib.strict import read_yaml

SAME_RUN = "same run"  # the finding that a recording's contents are those of another one
SEVERITIES = ("stop", "error", "warning", "note")  # most serious first; see docs/report.md

MAX_NAMED_PLACES = 3  # places of a meaning that are named beside the findings of other recordings
TEMPLATE_FILE = Path(__file__).parent / "templates/findings.yaml"
MAX_STATED_NUMBER = (
    9999  # of a number in a sentence; a larger one only says that something is wrong
)
PARTICULAR_WORD = re.compile(
    r"\S*(?:[/\\]|\d[\d.e]|\w\.\w)\S*"
)  # a path, or a number of two digits


def group_findings(quality: pd.DataFrame, most: int | None = None) -> pd.DataFrame:
    """Group findings of one kind in one row: counts summed, each meaning stated once.

    quality: the place of a finding is the start of its detail; most: places of a meaning that are
    named, None for all.
    """
    kind = ["recording", "device", "finding", "severity"]
    rows = [
        (*key, rows_of_kind["count"].sum(), _stated_once(rows_of_kind, most))
        for key, rows_of_kind in quality.groupby(kind, sort=False)
    ]
    return pd.DataFrame(rows, columns=[*kind, "count", "detail"])


def by_finding(quality: pd.DataFrame) -> pd.DataFrame:
    """Group findings of all recordings, one row a finding, most serious first.

    Stop signs and errors keep each meaning, whatever its numbers and paths, and each run that
    several recordings hold; of others, `detail` is that of the recording with the largest count,
    and `alike` whether all recordings have the same. `recordings` is a list.
    """
    grouped = group_findings(quality, MAX_NAMED_PLACES).sort_values(
        "count", ascending=False, kind="stable"
    )
    general = grouped["detail"].str.replace(PARTICULAR_WORD, "…", regex=True)
    meaning = general.where(grouped["severity"].isin(("stop", "error")), "")
    meaning = meaning.where(grouped["finding"] != SAME_RUN, grouped["detail"])
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


def _stated_once(findings: pd.DataFrame, most: int | None) -> str:
    """Join the details of findings: each meaning once, with its places, `most` of them named."""
    places: dict[str, dict[str, None]] = {}
    for place, detail in zip(findings["place"], findings["detail"], strict=True):
        named = places.setdefault(detail.removeprefix(f"{place}: "), {})
        named |= {place: None} if isinstance(place, str) and place else {}
    return "; ".join(
        ": ".join([_listed([*named], most), meaning] if named else [meaning])
        for meaning, named in places.items()
    )


def _listed(places: list[str], most: int | None) -> str:
    """Join places, of many the first few and how many others there are."""
    named = places[:most]
    others = [f"{len(places) - len(named)} others"] if named[: len(places)] != places else []
    return "; ".join([*named, *others])


class Words(Formatter):
    """Values in a sentence: lists are joined by commas, remarks by their format."""

    def format_field(self, value: Any, format_spec: str) -> str:
        """Return a value in words; NaN, which JSON does not know, is unknown."""
        if value is None:
            return "unknown"
        if isinstance(value, Mapping):
            return sentence(value["code"], value["values"])
        if not isinstance(value, list | tuple):
            return self._bounded(value, format_spec)
        if all(isinstance(part, Mapping | str) for part in value):
            return (format_spec or ", ").join(self.format_field(part, "") for part in value)
        return ", ".join(self.format_field(part, format_spec) for part in value)

    def _bounded(self, value: Any, format_spec: str) -> str:
        """Return a value in words, beyond four digits before the point as `above 9999`."""
        most = MAX_STATED_NUMBER / 100 if format_spec.endswith("%") else MAX_STATED_NUMBER
        if format_spec[-1:] not in ("f", "%") or not abs(value) > most:
            return str(super().format_field(value, format_spec))
        bound = super().format_field(math.copysign(most, value), f".0{format_spec[-1]}")
        return f"{'above' if value > 0 else 'below'} {bound}"


@cache
def templates() -> dict[str, str]:
    """Return the sentences by code."""
    return dict(read_yaml(TEMPLATE_FILE))


def sentence(code: str, values: Mapping[str, Any]) -> str:
    """Return the sentence of a code, made printable: its values quote hostile files."""
    return _filled(templates()[code], values)


def _filled(template: str, values: Mapping[str, Any]) -> str:
    return printable(Words().vformat(template, (), values))


def in_words(remark: Remark) -> str:
    """Return the sentence of a remark."""
    return _with_remedy(remark.code, sentence(**asdict(remark)))


def _with_remedy(code: str, stated: str) -> str:
    """Return the sentence of a stop sign with how a study overrules it; others as they are."""
    if code not in KINDS:
        return stated
    return sentence("overruled by", {"sign": stated, "kind": KINDS[code]})


def worded(finding: Finding) -> dict[str, str | int]:
    """Return a finding as a row whose code and values are replaced by the sentence `detail`.

    `place`: where in a file it is, with which that sentence starts.
    """
    row = asdict(finding)
    code, values = row.pop("code") or finding.finding, row.pop("values")
    place, _, meaning = templates()[code].partition(": ")
    located = meaning and place.startswith("{file}")
    return row | {
        "place": _filled(place, values) if located else "",
        "detail": _with_remedy(code, sentence(code, values)),
    }
