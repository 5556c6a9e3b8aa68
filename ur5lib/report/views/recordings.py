"""The recordings, their defects and their clocks."""

from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.report.cells import rounded, with_error
from ur5lib.report.document import Cell
from ur5lib.report.findings import SEVERITIES, count_findings, group_findings
from ur5lib.report.results import Body, Column, Results, tabulated
from ur5lib.report.sentences import Sentence, say

MOST_NAMED = 4  # recordings of one finding
LONGEST = 120  # characters for the places of one finding


def files(results: Results) -> Body:
    """Return role, length, frames, steps and devices, one row per recording."""
    roles = results.roles()
    columns: dict[str, Column] = {
        "recording": "recording",
        "role": lambda row: roles[row.recording],
        "duration [s]": lambda row: f"{row.duration_s:.1f}",
        "rows read": "rows_read",
        "frames": "frames",
        "longest step [ms]": lambda row: f"{1000 * row.longest_step_s:.1f}",
        "jitter [ms]": lambda row: f"{1000 * row.jitter_s:.2f}",
        "devices used": lambda row: row.devices.replace(" ", ", "),
    }
    return tabulated(results.tables["recordings"].itertuples(), columns)


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


def findings(results: Results) -> Body:
    """Return the defects of the files, one row per finding and meaning."""
    grouped = group_findings(results.tables["quality"])
    kinds = grouped.groupby(["severity", "device", "finding", "detail"], sort=False)
    rows = [
        [
            Cell(severity),
            Cell(device),
            Cell(finding),
            Cell(_named(part["recording"])),
            Cell(str(part["count"].sum())),
            Cell(_short(detail)),
        ]
        for (severity, device, finding, detail), part in kinds
    ]
    rows.sort(key=lambda row: SEVERITIES.index(row[0].text))
    return Body(["severity", "device", "finding", "recordings", "count", "meaning"], rows)


def _named(recordings: pd.Series) -> str:
    names = [*recordings]
    rest = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + rest


def _short(detail: str) -> str:
    """Return a finding's detail with its list of places shortened."""
    places, _, meaning = detail.rpartition(": ")
    several = len(places) > LONGEST
    return f"{places[:LONGEST].rpartition(';')[0]} and others: {meaning}" if several else detail


def clocks(results: Results) -> Body:
    """Return each clock's offset and drift relative to the robot's, and its error at the end."""
    columns: dict[str, Column] = {
        "recording": "recording",
        "device": "device",
        "offset [s]": lambda row: with_error(row.offset_s, row.offset_std_s, 3),
        "drift [ppm]": _drift,
        "error at end [s]": lambda row: f"± {rounded(row.end_std_s, 3)}",
        "method": "method",
    }
    return tabulated(results.tables["clocks"].itertuples(), columns)


def _drift(row: Any) -> Cell:
    estimated = not pd.isna(row.drift_ppm)
    return with_error(row.drift_ppm, row.drift_std_ppm, 0) if estimated else Cell("not estimated")


def arms(results: Results) -> list[str]:
    """Return the arms of the study."""
    return results.robots()
