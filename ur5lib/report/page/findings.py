"""Findings of one kind in one row, each meaning stated once."""

import re

import pandas as pd

from ur5lib.records.codes import Found

SEVERITIES = ("stop", "error", "warning", "note")  # most serious first; see docs/report.md

MAX_NAMED_PLACES = 3  # of one meaning, in a table of several recordings
PARTICULAR_WORD = re.compile(
    r"\S*(?:[/\\]|\d[\d.e]|\w\.\w)\S*"
)  # a path, or a number of two digits


def group_findings(quality: pd.DataFrame, most: int | None = None) -> pd.DataFrame:
    """Return findings with those of one kind in one row: counts summed, each meaning stated once.

    quality: the detail of a finding begins with its place; most: number of named places of a
    meaning, None for all.
    """
    kind = ["recording", "device", "code", "finding", "severity"]
    rows = [
        (*key, rows_of_kind["count"].sum(), _stated_once(rows_of_kind, most))
        for key, rows_of_kind in quality.groupby(kind, sort=False)
    ]
    return pd.DataFrame(rows, columns=[*kind, "count", "detail"])


def by_finding(quality: pd.DataFrame, most: int | None = MAX_NAMED_PLACES) -> pd.DataFrame:
    """Return the findings of all recordings with one row for each finding, the most serious first.

    Stop signs and errors keep one detail for each meaning (numbers and paths ignored) and for each
    run that several recordings contain. Other findings keep the detail of the recording with the
    largest count. The column `recordings` lists the recordings; `alike`: whether all of them have
    the same detail; most: as in `group_findings`.
    """
    grouped = group_findings(quality, most).sort_values("count", ascending=False, kind="stable")
    general = grouped["detail"].str.replace(PARTICULAR_WORD, "…", regex=True)
    meaning = general.where(grouped["severity"].isin(("stop", "error")), "")
    meaning = meaning.where(grouped["code"] != Found.SAME_RUN, grouped["detail"])
    kinds = grouped.groupby(["severity", "device", "code", "finding", meaning], sort=False)
    rows = kinds.agg(
        recordings=("recording", list),
        detail=("detail", "first"),
        alike=("detail", lambda details: len({*details}) == 1),
    )
    return by_severity(rows.reset_index(level=[0, 1, 2, 3]).reset_index(drop=True))


def by_severity(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows in the order of their severity, most serious first."""
    return rows.sort_values("severity", key=lambda s: s.map(SEVERITIES.index), kind="stable")


def _stated_once(findings: pd.DataFrame, most: int | None) -> str:
    """Return the details of findings as one text: each meaning once, with its places, `most` of
    them named.
    """
    places: dict[str, dict[str, None]] = {}
    for place, detail in zip(findings["place"], findings["detail"], strict=True):
        named = places.setdefault(detail.removeprefix(f"{place}: "), {})
        named |= {place: None} if isinstance(place, str) and place else {}
    return "; ".join(
        ": ".join([_listed([*named], most), meaning] if named else [meaning])
        for meaning, named in places.items()
    )


def _listed(places: list[str], most: int | None) -> str:
    """Return places as one text; of more than `most`, the first ones and the number of others."""
    named = places[:most]
    others = [f"{len(places) - len(named)} others"] if named[: len(places)] != places else []
    return "; ".join([*named, *others])
