"""The recordings, their defects and their clocks."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.cells import rounded, with_error
from ur5lib.report.document import Cell
from ur5lib.report.findings import SEVERITIES, count_findings, group_findings
from ur5lib.report.results import Body, Results
from ur5lib.report.sentences import Sentence, say

MOST_NAMED = 4  # recordings of one finding
LONGEST = 120  # characters for the places of one finding


def files(results: Results) -> Body:
    """Return role, length, frames, steps and devices, one row per recording."""
    roles = results.roles()
    rows = [
        [
            Cell(row.recording),
            Cell(roles[row.recording]),
            Cell(f"{row.duration_s:.1f}"),
            Cell(str(row.rows_read)),
            Cell(str(row.frames)),
            Cell(f"{1000 * row.longest_step_s:.1f}"),
            Cell(f"{1000 * row.jitter_s:.2f}"),
            Cell(row.devices.replace(" ", ", ")),
        ]
        for row in results.tables["recordings"].itertuples()
    ]
    header = ["recording", "role", "duration [s]", "rows read", "frames", "longest step [ms]"]
    return Body([*header, "jitter [ms]", "devices used"], rows)


def late(results: Results) -> list[str]:
    """Return the recording, of those with figures, that lost most frames."""
    lost = results.rows("quality", device="robot", finding="lost frames")
    return results.shown([*lost.sort_values("count", ascending=False)["recording"]], 1)


def counted(results: Results) -> Iterator[Sentence]:
    """Report how many findings there are, and the most frequent serious ones."""
    found = results.tables["quality"]
    serious = found[found["severity"] != "note"]["finding"].value_counts()
    worst = [
        say("quality.frequent", name=name, count=count)
        for name, count in serious[:MOST_NAMED].items()
    ]
    yield say("quality.files", counts=count_findings(found), worst=worst)


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
    """Return the meaning of a finding, with its list of places shortened."""
    places, _, meaning = detail.rpartition(": ")
    several = len(places) > LONGEST
    return f"{places[:LONGEST].rpartition(';')[0]} and others: {meaning}" if several else detail


def clocks(results: Results) -> Body:
    """Return each clock's offset and drift relative to the robot's, and its error at the end."""
    rows = [
        [
            Cell(clock.recording),
            Cell(clock.device),
            with_error(clock.offset_s, clock.offset_std_s, 3),
            _drift(clock.drift_ppm, clock.drift_std_ppm),
            Cell(f"± {rounded(clock.end_std_s, 3)}"),
            Cell(clock.method),
        ]
        for clock in results.tables["clocks"].itertuples()
    ]
    heads = ["recording", "device", "offset [s]", "drift [ppm]", "error at end [s]", "method"]
    return Body(heads, rows)


def _drift(drift: float, std: float) -> Cell:
    return Cell("not estimated") if pd.isna(drift) else with_error(drift, std, 0)


def arms(results: Results) -> list[str]:
    """Return the arms of the study."""
    return results.robots()
