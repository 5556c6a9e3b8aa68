"""The recordings, their defects and clocks, the verdict on them, and the provenance of results."""

from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.records.accepted import ACCEPTED
from ur5lib.records.quality import UNCHECKED
from ur5lib.report.page.document import MOST_SHOWN
from ur5lib.report.page.findings import SEVERITIES, by_finding, by_severity
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results

MAX_NAMED_RECORDINGS = 4  # recordings of one finding
LOST_FRAMES = "lost frames"


def late(results: Results) -> list[str]:
    """Return the recording with figures that lost most frames."""
    lost = results.rows("quality", device="robot", finding=LOST_FRAMES)
    return results.shown([*lost.sort_values("count", ascending=False)["recording"]], 1)


def pages(results: Results) -> Iterator[str]:
    """Say how the page of one of many recordings is made, and name those that were left out."""
    if not results.many:
        return
    yield say("recordings.pages", study=results.study["study"], name=next(iter(results.roles())))
    if absent := results.unusable():
        more = len(absent) - MOST_SHOWN
        yield say("recordings.left out", count=len(absent), names=absent[:MOST_SHOWN], more=more)


def trust(results: Results) -> pd.DataFrame:
    """Return the recordings, also those left out, with their use, lost frames and the gravest
    finding, but for those of what could not be checked.
    """
    used = results.tables["recordings"].set_index("recording")[["duration_s", "devices", "frames"]]
    quality = results.tables["quality"]
    quality = by_severity(quality[~quality["finding"].isin(UNCHECKED)])
    gravest = quality.drop_duplicates("recording").set_index("recording")
    gravest = gravest[["severity", "device", "finding"]]
    lost = results.rows("quality", device="robot", finding=LOST_FRAMES)
    lost = lost.drop_duplicates("recording").set_index("recording")["count"]
    roles = pd.Series(results.roles(), name="role").rename_axis("recording")
    use = pd.Series(uses(results), dtype=str, name="use")
    return roles.to_frame().join([used, lost.rename("lost"), gravest, use]).reset_index()


def uses(results: Results) -> dict[str, str]:
    """Return a sentence for each recording: usable for what, for what not, and why."""
    rows = results.rows("uses").fillna({"reason": ""})
    found = {}
    for name, own in rows.groupby("recording", sort=False):
        served, refused = own[own["use"] == "yes"], own[own["use"] == "no"]
        for_ = [*zip(served["purpose"], served["reason"], strict=True)]
        against = [*zip(refused["purpose"], refused["reason"], strict=True)]
        found[str(name)] = say("recordings.use", goals=for_, against=against)
    return found


def causes(results: Results) -> pd.DataFrame:
    """Return the findings of all recordings by their cause, most serious first."""
    rows = by_finding(results.tables["quality"])
    return rows.assign(recordings=rows["recordings"].map(_named), count=rows["recordings"].map(len))


def _named(recordings: pd.Series) -> str:
    names = [*recordings]
    rest = (
        f" and {len(names) - MAX_NAMED_RECORDINGS} more"
        if len(names) > MAX_NAMED_RECORDINGS
        else ""
    )
    return ", ".join(names[:MAX_NAMED_RECORDINGS]) + rest


def accepted(results: Results) -> Iterator[str]:
    """Report the stop signs that the study overrules, each with its reason: numbers rest on it."""
    rows = results.rows("quality", finding=ACCEPTED).groupby("detail", sort=False)["recording"]
    arms = results.rows("remarks", code=ACCEPTED).groupby("remark", sort=False)["robot"]
    told = [(detail, _named(of)) for group in (rows, arms) for detail, of in group]
    for detail, of in told[:MAX_NAMED_RECORDINGS]:
        yield say("quality.accepted", of=of, detail=detail)
    if more := told[MAX_NAMED_RECORDINGS:]:
        yield say("quality.accepted more", count=len(more))


def commit(results: Results) -> Iterator[str]:
    """Return the commit that made the results."""
    yield say("provenance.commit", commit=results.commit)


def total_time(results: Results) -> Iterator[str]:
    """Report the time of all jobs together."""
    times: pd.DataFrame = results.tables["run_times"]
    if len(times):
        yield say("provenance.times", steps=[*times.itertuples()])


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


def versions(results: Results) -> pd.DataFrame:
    """Return the versions of the software that the numbers depend on."""
    return pd.DataFrame(results.versions.items(), columns=["package", "version"])


def legend(results: Results) -> pd.DataFrame:
    """Return the recordings, also those left out: role, duration, devices, lost frames and their
    share, the gravest finding, but for those of what could not be checked, and how many kinds of
    findings there are by severity.
    """
    used = results.tables["recordings"].set_index("recording")[["duration_s", "devices", "frames"]]
    quality = by_severity(results.tables["quality"])
    checked = quality[~quality["finding"].isin(UNCHECKED)].drop_duplicates("recording")
    gravest = checked.set_index("recording")[["severity", "device", "finding"]]
    lost = results.rows("quality", device="robot", finding=LOST_FRAMES)
    lost = lost.groupby("recording")["count"].first().rename("lost")
    roles = pd.Series(results.roles(), name="role", dtype=str).rename_axis("recording")
    rows = roles.to_frame().join([used, lost, gravest, _kinds(quality)]).reset_index()
    return rows.assign(lost_share=rows["lost"] / rows["frames"])


def _kinds(quality: pd.DataFrame) -> pd.DataFrame:
    """Return how many kinds of findings there are of each severity, by recording."""
    kinds = quality.drop_duplicates(["recording", "device", "finding", "severity"])
    counts = pd.crosstab(kinds["recording"], kinds["severity"])
    return counts.reindex(columns=pd.Index(SEVERITIES), fill_value=0)


def gravest(results: Results) -> pd.DataFrame:
    """Return the same, the recordings with the gravest findings and most lost frames first."""
    keys = [*SEVERITIES[:-1], "lost_share"]
    return legend(results).sort_values(keys, ascending=False, kind="stable")


def by_cause(results: Results) -> pd.DataFrame:
    """Return the findings of all recordings by their cause, most serious first, each with the names
    of its recordings.
    """
    rows = by_finding(results.tables["quality"])
    return rows.assign(count=rows["recordings"].map(len))


def left_out(results: Results) -> list[str]:
    """Return the recordings whose files cannot be used or repeat others."""
    return results.unusable()


def accepted_signs(results: Results) -> list[dict[str, Any]]:
    """Return the stop signs that the study overrules: their words, and of which recordings or
    arms.
    """
    rows = results.rows("quality", finding=ACCEPTED).groupby("detail", sort=False)["recording"]
    arms = results.rows("remarks", code=ACCEPTED).groupby("remark", sort=False)["robot"]
    return [{"detail": detail, "of": [*of]} for group in (rows, arms) for detail, of in group]
