"""Recordings: their findings, and which purposes each may serve."""

from collections.abc import Iterator
from typing import Any

import pandas as pd
from scipy.special import gammainc

from ur5lib.force.estimators import GATED, LEADING
from ur5lib.judging.limits import MAX_CHANCE_OF_ALARMS, USUAL_ALARMS, USUAL_SECONDS
from ur5lib.judging.study import AT_REST, StudyTables
from ur5lib.records.codes import Found
from ur5lib.records.contacts import OF_CONTACTS, Kind
from ur5lib.records.verdicts import Reason, RecordingUse, State, Verdict

QUESTION = "recordings"
OF_FRAMES = (Found.LOST_FRAMES, Found.IMPOSSIBLE_FRAMES)  # findings that count frames
IN_WORDS = {  # quantities, for the words of findings
    Found.TOUCHED: "contacts in a recording whose role denies them",
    Found.MOVED_IN_BETWEEN: "recordings before which the arm was moved",
    Found.NO_CURRENTS: "recordings without currents",
    Found.NO_GRAVITY: "recordings without gravity",
    Found.NO_MOMENTS: "recordings without moments",
    Found.NO_MOTION: "recordings without motion",
    Found.NO_SENSOR: "recordings without a sensor",
    Found.NO_START_STAMP: "recordings without a start stamp",
    Found.NO_VELOCITIES: "recordings without velocities",
}
SEVERITIES = ("stop", "error", "warning", "note")  # most serious first; see docs/report.md
STATES: dict[str, tuple[State, Reason]] = {
    "stop": ("do not use", "stopped"),
    "error": ("usable", "error"),
    "warning": ("usable", "warning"),
}


def judge_recordings(study: StudyTables) -> Iterator[Verdict]:
    """Judge by the most serious finding, and count the findings, and the recordings that serve any
    purpose; an excluded recording is more serious than an error, and none that serves is the worst.
    """
    quality = study.tables["quality"]
    serious = {*quality["severity"]}
    state, reason = next((STATES[one] for one in STATES if one in serious), ("good", ""))
    absent = study.unusable()
    if absent and state != "do not use":
        state, reason = "usable", "unread"
    serving = _serving(study)
    if not serving.count and state != "do not use":
        state = "do not use"
        reason = "no_reference" if study.silent() < {*study.roles()} else "no_effort"
    about: Any = {"question": QUESTION, "state": state, "reason": reason}
    if absent:
        about |= {"count": len(absent), "of": len(study.roles())}
        yield Verdict(**about, quantity="recordings left out", sense="less", recording=absent[0])
    elif (row := worst_finding(study)) is not None:
        yield Verdict(**about, **_counted(study, row), sense="less", recording=row["recording"])
    else:
        yield Verdict(**about, quantity="errors and warnings", sense="less", count=0)
    kinds = quality.drop_duplicates(["recording", "device", "finding", "severity"])
    counts = kinds["severity"].value_counts()
    for rank, name in enumerate(SEVERITIES, start=2):
        if name == SEVERITIES[0] or name in counts:
            noun = "stop signs" if name == SEVERITIES[0] else f"{name}s"
            yield Verdict(
                question=QUESTION,
                rank=rank,
                quantity=noun,
                sense="less",
                count=int(counts.get(name, 0)),
            )
    yield serving


def _counted(study: StudyTables, row: "pd.Series[Any]") -> dict[str, Any]:
    """Return quantity, count and whole of a finding, as fields of a verdict."""
    quantity, count = IN_WORDS.get(row["code"], str(row["finding"])), int(row["count"])
    if row["code"] in IN_WORDS and quantity.startswith("recordings "):
        count = study.rows("quality", code=row["code"])["recording"].nunique()
    of = int(_frames(study)[row["recording"]]) if row["code"] in OF_FRAMES else None
    return {"quantity": quantity, "count": count, "of": of}


def _serving(study: StudyTables) -> Verdict:
    """Return how many recordings may serve any purpose."""
    return Verdict(
        question=QUESTION,
        rank=len(SEVERITIES) + 2,
        quantity="recordings that serve a purpose",
        sense="more",
        count=len({one.recording for one in uses(study) if one.use == "yes"}),
        of=len(study.roles()),
    )


def worst_finding(study: StudyTables) -> "pd.Series | None":
    """Return the most serious finding; among equally serious ones, the one that concerns the
    largest share of frames.

    None without findings.
    """
    quality = study.tables["quality"]
    keys = ["recording", "device", "code", "finding", "severity"]
    rows = quality.groupby(keys, sort=False, as_index=False)["count"].sum()
    rows = rows[rows["severity"] != SEVERITIES[-1]]
    if rows.empty:
        return None
    share = rows["count"].where(rows["code"].isin(OF_FRAMES), 0)
    share = share / rows["recording"].map(_frames(study))
    gravity = rows["severity"].map(SEVERITIES.index)
    order = rows.assign(share=-share, gravity=gravity).sort_values(
        ["gravity", "share"], kind="stable"
    )
    return order.iloc[0]


def _frames(study: StudyTables) -> "pd.Series[float]":
    return study.tables["recordings"].set_index("recording")["frames"]


def lost_shares(study: StudyTables) -> dict[str, float]:
    """Return the share of lost frames of each recording."""
    frames = _frames(study)
    lost = study.rows("quality", code=Found.LOST_FRAMES).groupby("recording")["count"].sum()
    shares = (lost.reindex(frames.index) / frames).fillna(0.0)
    return {str(name): float(share) for name, share in shares.items()}


def felt_while_fitted(study: StudyTables) -> list[str]:
    """Return the fit recordings on which the arm was probably touched: a fit without the recording
    finds more contacts there than the alarm rate on the arm's other fit recordings explains.
    """
    alarms = study.rows("contacts", estimate=LEADING, kind=[*OF_CONTACTS, Kind.FALSE])
    found = alarms["recording"].value_counts()
    lengths = study.tables["recordings"].set_index("recording")["duration_s"].astype(float)
    fitted = study.with_role("fit")
    rows = pd.DataFrame({"arm": study.arms(), "alarms": found, "seconds": lengths}).loc[fitted]
    rows = rows.fillna({"alarms": 0})
    others = rows.groupby("arm")[["alarms", "seconds"]].transform("sum") - rows
    rate = (others["alarms"] + USUAL_ALARMS) / (others["seconds"] + USUAL_SECONDS)
    chance = gammainc(rows["alarms"], rate * rows["seconds"])  # Poisson: P(this many or more)
    return [*rows.index[len(rows) * chance < MAX_CHANCE_OF_ALARMS]]


def uses(study: StudyTables) -> Iterator[RecordingUse]:
    """Yield for each recording the purposes for which it may and may not be used, with the reason.

    A recording without any purpose has one row.
    """
    served, refused, doubted = dict(_served(study)), [*_refused(study)], [*_doubts(study)]
    silent = study.silent()
    for name in study.roles():
        against = {purpose: reason for purpose, reason, names in refused if name in names}
        doubts = {purpose: reason for purpose, reason, names in doubted if name in names}
        goals = [purpose for purpose, names in served.items() if name in names]
        goals = [] if "all" in against else [one for one in goals if one not in against]
        for purpose in goals:
            reason = doubts.get(purpose, "")
            yield RecordingUse(recording=name, purpose=purpose, use="yes", reason=reason)
        for purpose, reason in against.items():
            yield RecordingUse(recording=name, purpose=purpose, use="no", reason=reason)
        if not goals and not against:
            reason = "no_effort" if name in silent else "no_reference"
            yield RecordingUse(recording=name, purpose="all", use="no", reason=reason)


def _served(study: StudyTables) -> Iterator[tuple[str, set[str]]]:
    """Yield (purpose, names of the recordings that serve it)."""
    errors, loads = study.rows("current_rmse", model="fitted"), {*study.loaded()}
    moving = {name for name in study.roles() if study.moving(name)}
    forces = study.rows("force_mae", during="contact", use="yes")
    yield "fit", {*errors.loc[errors["fitted"] == "yes", "recording"], *study.with_role(AT_REST)}
    yield "currents", {*study.with_role("validate", errors["recording"])} & moving
    yield "load", loads
    yield "links", {*study.tables["torque_mae"].dropna(subset="mae")["recording"]} & moving
    yield "force", {*forces["recording"]}
    searched = {*study.rows("detection", estimate=GATED)["recording"]}
    yield "contacts", {*study.with_role("contact", searched), *({*study.touched()} & searched)}
    yield "motion", {*study.tables["acceleration_mae"]["recording"]}


def _refused(study: StudyTables) -> Iterator[tuple[str, Reason, set[str]]]:
    """Yield (purpose, reason, names of the recordings that the reason excludes from it)."""
    stops = study.rows("quality", severity="stop")
    stopped = {*stops.loc[stops["code"] != Found.UNREADABLE, "recording"]}
    yield "all", "stopped", stopped
    yield "all", "unread", {*study.unusable()} - stopped
    touched = {*study.touched()}
    yield "fit", "touched", touched & {*study.with_role("fit")}
    yield "currents", "touched", touched & {*study.with_role("validate")}
    yield "currents", "loaded", {*study.with_role("validate", study.loaded())} - touched
    unsensed = {*study.with_role("contact")} - {*study.tables["sensed"]["recording"]}
    yield "force", "no_sensor", unsensed - stopped
    yield "force", "sensor_bias", {*study.doubted()} - stopped
    withheld = study.rows("quality", code=Found.UNUSUAL_FRICTION)["recording"]
    yield "force", "other_friction", {*withheld}


def _doubts(study: StudyTables) -> Iterator[tuple[str, Reason, set[str]]]:
    """Yield (purpose, doubt, names of the recordings to which it applies), the graver
    doubts last.
    """
    yield "fit", "no_motion", {one for one in study.roles() if not study.moving(one)}
    yield "fit", "felt", {*felt_while_fitted(study)}
    yield "links", "fitted", {*study.with_role("fit")}
