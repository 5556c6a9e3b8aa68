"""The recordings, their defects and clocks, the verdict on them, and the provenance of results."""

from typing import Any

import pandas as pd

from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.quality import UNCHECKED
from ur5lib.report.page.findings import SEVERITIES, by_finding, by_severity
from ur5lib.report.results import Results


def late(results: Results) -> list[str]:
    """Return in a list the recording that lost most frames, among those with figures."""
    lost = results.rows("quality", device="robot", code=Found.LOST_FRAMES)
    return results.shown([*lost.sort_values("count", ascending=False)["recording"]], 1)


def tables(results: Results) -> pd.DataFrame:
    """Return the files of the tables that have rows, with their number and their columns."""
    known = {name: table for name, table in sorted(results.tables.items()) if len(table)}
    return pd.DataFrame(
        {
            "file": [f"tables/{name}.csv" for name in known],
            "rows": [*map(len, known.values())],
            "columns": [", ".join(table) for table in known.values()],
        }
    )


def legend(results: Results) -> pd.DataFrame:
    """Return all recordings, also those left out: role, duration, devices, lost frames and their
    share, the gravest finding except unchecked items, and the number of kinds of findings by
    severity.
    """
    used = results.tables["recordings"].set_index("recording")[["duration_s", "devices", "frames"]]
    quality = by_severity(results.tables["quality"])
    checked = quality[~quality["code"].isin(UNCHECKED)].drop_duplicates("recording")
    gravest = checked.set_index("recording")[["severity", "device", "finding"]]
    lost = results.rows("quality", device="robot", code=Found.LOST_FRAMES)
    lost = lost.groupby("recording")["count"].first().rename("lost")
    roles = pd.Series(results.roles(), name="role", dtype=str).rename_axis("recording")
    rows = roles.to_frame().join([used, lost, gravest, _kinds(quality)]).reset_index()
    return rows.assign(lost_share=rows["lost"] / rows["frames"])


def _kinds(quality: pd.DataFrame) -> pd.DataFrame:
    """Return the number of kinds of findings of each severity, by recording."""
    kinds = quality.drop_duplicates(["recording", "device", "finding", "severity"])
    counts = pd.crosstab(kinds["recording"], kinds["severity"])
    return counts.reindex(columns=pd.Index(SEVERITIES), fill_value=0)


def gravest(results: Results) -> pd.DataFrame:
    """Return the rows of `legend`, first the recordings with the gravest findings and most lost
    frames.
    """
    keys = [*SEVERITIES[:-1], "lost_share"]
    return legend(results).sort_values(keys, ascending=False, kind="stable")


def by_cause(results: Results) -> pd.DataFrame:
    """Return the findings with one row for each, most serious first, with the names of the
    recordings concerned.
    """
    rows = by_finding(results.tables["quality"])
    return rows.assign(count=rows["recordings"].map(len))


def left_out(results: Results) -> list[str]:
    """Return the recordings with files that cannot be used or repeat others."""
    return results.unusable()


def accepted_signs(results: Results) -> list[dict[str, Any]]:
    """Return the stop signs that the study overrules, with the recordings or arms concerned."""
    rows = results.rows("quality", code=Found.ACCEPTED_STOP_SIGN)
    arms = results.rows("remarks", code=CauseCode.ACCEPTED_STOP_SIGN)
    groups = (
        *rows.groupby("detail", sort=False)["recording"],
        *arms.groupby("remark", sort=False)["robot"],
    )
    return [{"detail": str(detail), "of": [*of]} for detail, of in groups]
