"""The recordings, their defects and clocks, the verdict on them, and the provenance of results."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.records.accepted import ACCEPTED
from ur5lib.records.quality import UNCHECKED
from ur5lib.report.page.document import MOST_SHOWN, Number, State, Verdict
from ur5lib.report.page.findings import (
    SEVERITIES,
    by_finding,
    by_severity,
    group_findings,
)
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.uses import uses

SPOKEN_SEVERITIES = {"stop": "stop sign"}
MAX_NAMED_RECORDINGS = 4  # recordings of one finding
FILES_TOPIC = "Data quality"  # topic
LOST_FRAMES = "lost frames"
WORDED_FINDINGS = (LOST_FRAMES, "impossible frames")  # findings with a sentence of their own
STATES_OF_SEVERITIES: dict[str, State] = {
    "stop": "do not use",
    "error": "usable",
    "warning": "usable",
}


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
    used = results.tables["recordings"].set_index("recording")[["duration_s", "devices"]]
    quality = results.tables["quality"]
    quality = by_severity(quality[~quality["finding"].isin(UNCHECKED)])
    gravest = quality.drop_duplicates("recording").set_index("recording")
    gravest = gravest[["severity", "device", "finding"]]
    lost = pd.Series(lost_shares(results), dtype=float, name="lost")
    roles = pd.Series(results.roles(), name="role").rename_axis("recording")
    use = pd.Series(uses(results), dtype=str, name="use")
    return roles.to_frame().join([used, lost, gravest, use]).reset_index()


def causes(results: Results) -> pd.DataFrame:
    """Return the findings of all recordings by their cause, most serious first."""
    rows = by_finding(results.tables["quality"])
    return rows.assign(recordings=rows["recordings"].map(_named), count=rows["recordings"].map(len))


def count_findings(results: Results) -> pd.DataFrame:
    """Return how many findings there are of each severity, most serious first, and how many causes
    they have: the rows of `causes`, each once for a recording. Stop signs are counted if none, too.
    """
    groups = causes(results).groupby("severity")["count"]
    counts = groups.agg(findings="sum", causes="size").reindex(SEVERITIES, fill_value=0)
    counts = counts[(counts["findings"] > 0) | (counts.index == SEVERITIES[0])]
    return counts.rename(index=SPOKEN_SEVERITIES)


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


def total_time(results: Results) -> Iterator[str]:
    """Report the time of all jobs together."""
    times: pd.DataFrame = results.tables["run_times"]
    if len(times):
        yield say("provenance.times", sums=times[["jobs", "cpu_s", "start_up_s"]].sum())


def judge_files(results: Results) -> Verdict:
    """Judge by the recordings that were left out, or by the most serious finding."""
    findings = results.tables["quality"]
    serious, counts = findings[findings["severity"] != "note"], count_findings(results)
    states = [
        STATES_OF_SEVERITIES[name] for name in SEVERITIES[:-1] if name in {*serious["severity"]}
    ]
    return Verdict(
        topic=FILES_TOPIC,
        state=states[0] if states else "usable" if results.unusable() else "good",
        sentence=worst(results),
        evidence=say(
            "quality.evidence",
            counts=counts[counts["findings"] > 0],
            bad=serious["recording"].nunique(),
            recordings=len(results.roles()),
        ),
        numbers=tuple(Number(f"{row.Index}s", row.findings, "") for row in counts.itertuples()),
    )


def worst(results: Results) -> str:
    """Return the most serious finding with its file; among equals, that of the most frames.

    Recordings that were left out come before it.
    """
    if absent := results.unusable():
        return say("quality.left out", count=len(absent), of=len(results.roles()))
    findings = group_findings(results.tables["quality"])
    findings = findings[findings["severity"] != "note"]
    if findings.empty:
        return say("quality.perfect")
    frames = results.tables["recordings"].set_index("recording")["frames"]
    share = findings["count"] / findings["recording"].map(frames)
    most = findings.loc[share.sort_values(ascending=False, kind="stable").index]
    first = by_severity(most).iloc[0]
    kind = first["finding"]
    return say(
        f"quality.{kind if kind in WORDED_FINDINGS else 'other'}",
        file=results.file_of(first["recording"]),
        finding=kind,
        detail=first["detail"].partition("; ")[0],
        count=first["count"],
        frames=frames[first["recording"]],
    )


def lost_shares(results: Results) -> dict[str, float]:
    """Return the share of lost frames of each recording."""
    frames = results.tables["recordings"].set_index("recording")["frames"]
    lost = results.rows("quality", finding=LOST_FRAMES).groupby("recording")["count"].sum()
    shares = (lost.reindex(frames.index) / frames).fillna(0.0)
    return {str(name): float(share) for name, share in shares.items()}
