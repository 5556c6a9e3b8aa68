"""The recordings, their defects and their clocks."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.findings import SEVERITIES, count_findings, group_findings
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say

MOST_NAMED = 4  # recordings of one finding
LONGEST = 120  # characters for the places of one finding


def late(results: Results) -> list[str]:
    """Return the recording with figures that lost most frames."""
    lost = results.rows("quality", device="robot", finding="lost frames")
    return results.shown([*lost.sort_values("count", ascending=False)["recording"]], 1)


def counted(results: Results) -> Iterator[Sentence]:
    """Report how many findings there are, and the most frequent serious ones."""
    quality = results.tables["quality"]
    serious = quality[quality["severity"] != "note"]["finding"].value_counts()
    worst = [
        say("quality.frequent", name=name, count=count)
        for name, count in serious[:MOST_NAMED].items()
    ]
    yield say("quality.files", counts=count_findings(quality), worst=worst)


def findings(results: Results) -> pd.DataFrame:
    """Return the defects of the files, one row per finding and meaning, most serious first."""
    grouped = group_findings(results.tables["quality"])
    kinds = grouped.groupby(["severity", "device", "finding", "detail"], sort=False)
    rows = kinds.agg(recordings=("recording", _named), count=("count", "sum")).reset_index()
    meaning = [_short(detail) for detail in rows["detail"]]
    rank = rows["severity"].map(SEVERITIES.index)
    return rows.assign(meaning=meaning, rank=rank).sort_values("rank", kind="stable")


def _named(recordings: pd.Series) -> str:
    names = [*recordings]
    rest = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + rest


def _short(detail: str) -> str:
    """Return a finding's detail with its list of places shortened."""
    places, _, meaning = detail.rpartition(": ")
    several = len(places) > LONGEST
    return f"{places[:LONGEST].rpartition(';')[0]} and others: {meaning}" if several else detail


def arms(results: Results) -> list[str]:
    """Return the arms of the study."""
    return results.robots()
