"""Verdicts on the recordings: whether files are complete, and whether the arm changed."""

import pandas as pd

from ur5lib.report.document import Number, State, Verdict
from ur5lib.report.findings import SEVERITIES, by_severity, group_findings
from ur5lib.report.formats import Sentence, capital, days
from ur5lib.report.results import Results
from ur5lib.report.sentences import say
from ur5lib.report.verdicts.baseline import bars
from ur5lib.report.views import arm_state
from ur5lib.report.views.recordings import count_findings

FILES, DRIFT = "Data quality", "Drift over time"  # topics
LOST = "lost frames"
SPOKEN = (LOST, "impossible frames")  # findings with a sentence of their own
STATES: dict[str, State] = {"stop": "do not use", "error": "usable", "warning": "usable"}


def judge_files(results: Results) -> Verdict:
    """Judge by the recordings that were left out, or by the most serious finding."""
    findings = results.tables["quality"]
    serious = findings[findings["severity"] != "note"]
    states = [STATES[name] for name in SEVERITIES[:-1] if name in {*serious["severity"]}]
    lost = lost_shares(results)
    drawn = pd.Series(lost).groupby(results.months()).max() if results.many else lost
    return Verdict(
        topic=FILES,
        state=states[0] if states else "usable" if results.unusable() else "good",
        sentence=worst(results),
        evidence=say(
            "quality.evidence",
            counts=count_findings(findings),
            bad=serious["recording"].nunique(),
            recordings=len(lost),
        ),
        drawing=bars({str(name): float(share) for name, share in drawn.items()}),
        caption=say("quality.caption", many=results.many),
        numbers=tuple(
            Number(f"findings of severity “{name}”", int((findings["severity"] == name).sum()), "")
            for name in SEVERITIES
        ),
    )


def worst(results: Results) -> Sentence:
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
        f"quality.{kind if kind in SPOKEN else 'other'}",
        file=results.file_of(first["recording"]),
        finding=kind,
        detail=first["detail"].partition("; ")[0],
        count=first["count"],
        frames=frames[first["recording"]],
    )


def lost_shares(results: Results) -> dict[str, float]:
    """Return the share of lost frames of each recording."""
    frames = results.tables["recordings"].set_index("recording")["frames"]
    lost = results.rows("quality", finding=LOST).groupby("recording")["count"].sum()
    shares = (lost.reindex(frames.index) / frames).fillna(0.0)
    return {str(name): float(share) for name, share in shares.items()}


def judge_drift(results: Results) -> Verdict | None:
    """Judge by whether anything changed; None with too few dates."""
    dates = results.tables["health"]
    if dates.empty:
        return None
    changes = arm_state.ranked(results)
    worst = changes.groupby("joint")["share"].max()
    joints = range(1, int(dates["joint"].max()) + 1)
    sentence = say("health.unchanged")
    if len(changes):
        sentence = capital(arm_state.change(next(changes.itertuples())))
    return Verdict(
        topic=DRIFT,
        state="usable" if len(changes) else "good",
        sentence=sentence,
        evidence=_evidence(results, len(changes)),
        drawing=bars({str(joint): float(worst.get(joint, 0.0)) for joint in joints}),
        caption=say("health.caption"),
    )


def _evidence(results: Results, changes: int) -> Sentence:
    """Return the number of dates, tests and changes, and the chance of a false one."""
    dates = results.tables["health"]
    tested = dates.dropna(subset="joint").groupby(["robot", "joint", "quantity"]).ngroups
    first, last = dates["date"].min(), dates["date"].max()
    words = {"days": dates["date"].nunique(), "span": days(first, last, "to"), "tested": tested}
    return say("health.evidence", changes=changes, **words)
