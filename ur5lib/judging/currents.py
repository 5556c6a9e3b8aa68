"""Predicted currents on recordings that no fit has used, and how certain friction is."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.judging.contacts import days_away
from ur5lib.judging.errors import Conditions, by_place, judged, severity, verdicts, with_floors
from ur5lib.judging.study import StudyTables
from ur5lib.records.friction import TOTAL
from ur5lib.records.verdicts import JudgedError, Reason, Verdict, reason_in

QUESTION = "currents"


def unseen(study: StudyTables) -> pd.DataFrame:
    """Return the errors on validate recordings without contacts or undeclared loads."""
    rows = study.rows("current_rmse", recording=study.quiet("validate"))
    return rows.assign(error=rows["rmse_lowpassed"], zero=rows["zero_rmse_lowpassed"])


def moving(study: StudyTables, rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of joints that move on their recording."""
    joints = zip(rows["recording"], rows["joint"], strict=True)
    moves = [joint in study.moving(recording) for recording, joint in joints]
    return rows[np.array(moves, dtype=bool)]


def errors(study: StudyTables, robot: str) -> list[JudgedError]:
    """Return the errors of an arm's predicted currents by joint, compared with plain least
    squares."""
    every = unseen(study)
    own = every[every["model"] == "fitted"]
    rows = moving(study, own).dropna(subset="error")
    if rows.empty:
        return []
    table = with_floors(by_place(rows, "joint"), study, "current")
    others = moving(study, every[every["model"] == "least_squares"])
    table["rival"] = "plain least squares"
    table["rival_error"] = others.groupby("joint")["error"].mean().reindex(table.index)
    held = rows.groupby("joint")
    table["coverage95"] = held["coverage95"].min()
    table["band_factor95"] = held["band_factor95"].max()
    table["least_factor95"] = held["band_factor95"].min()
    most = by_place(own, "joint").reindex(table.index)  # at rest, too
    for name in ("largest", "recording", "largest_zero"):
        table[name] = most[name]
    constants = torque_constants(study).reindex(table.index)
    table["torque"] = table["error"] * constants
    table["largest_torque"] = table["largest"] * constants
    return judged(QUESTION, robot, study.effort.unit, table, Conditions())


def torque_constants(study: StudyTables) -> pd.Series:
    """Return the torque constants [Nm/A] of an arm by joint; empty where torques are measured."""
    rows = study.rows("friction", parameter="torque_constant")
    return rows.set_index("joint")["value"].astype(float)


def judge_currents(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Judge predicted currents by joint: error, coverage of the band, least squares, repeats."""
    every = errors(study, robot)
    found = [one for one in every if one.state != "not determined"]
    about: Any = {"arm": robot}
    if not found:
        reason = _why_not(study)
        yield Verdict(question=QUESTION, state="not determined", reason=reason, arm=robot)
    else:
        cutoff = study.study["settings"]["lowpass"]["currents"]["cutoff_hz"]
        count = {one.recordings for one in found}
        interval = f"range over {max(count)} recordings"
        yield from verdicts(every, f"RMSE below {cutoff:g} Hz", interval, basis="unseen", **about)
        yield _pooled(found, f"RMSE below {cutoff:g} Hz, all moving joints", robot)
        yield from _bands(found, robot)
        yield from _as_torque(found, robot)
        yield from _farthest_in_time(study, robot)
    yield from judge_friction(study, robot)


def _why_not(study: StudyTables) -> Reason:
    if study.tables["friction"].empty:
        return "uncalibrated"
    if len(moving(study, unseen(study))):
        return "too_small"
    return "no_motion" if study.quiet("validate") else study.why_unseen_is_missing()


def _pooled(errors: list[JudgedError], quantity: str, robot: str) -> Verdict:
    """Return the root mean square of the joints' errors; the decisive joint's reason doubts it."""

    def pooled(name: str) -> float | None:
        own = [getattr(one, name) for one in errors]
        return None if None in own else float(np.sqrt(np.mean(np.square(own))))

    decisive = min(errors, key=severity)
    rival: Any = {"rival": decisive.rival, "rival_value": pooled("rival_error")}
    return Verdict(
        question=QUESTION,
        arm=robot,
        rank=9,
        reason=decisive.reason,
        quantity=quantity,
        sense="less",
        value=pooled("error"),
        unit=decisive.unit,
        zero=pooled("zero"),
        basis="unseen",
        **(rival if rival["rival_value"] is not None else {}),
    )


def _bands(errors: list[JudgedError], robot: str) -> Iterator[Verdict]:
    """Yield the least share of readings in the band, and its largest width over the width that
    contains 95 %.
    """
    least = min(errors, key=lambda one: one.coverage95 or 0.0)
    yield Verdict(
        question=QUESTION,
        arm=robot,
        rank=4,
        quantity="least share of a joint's readings in the 95 % band",
        sense="at least",
        value=100 * (least.coverage95 or 0.0),
        unit="%",
        joint=least.joint,
    )
    widths = [
        (1 / one.least_factor95, 1 / one.band_factor95, one.joint)
        for one in errors
        if one.least_factor95 and one.band_factor95
    ]
    if widths:
        widest, _, joint = max(widths)
        yield Verdict(
            question=QUESTION,
            arm=robot,
            rank=5,
            quantity="width of the 95 % band over the width that contains 95 %, largest",
            sense="ratio",
            value=widest,
            low=min(narrowest for _, narrowest, _ in widths),
            high=widest,
            interval="range over joints and recordings",
            joint=joint,
        )


def _as_torque(errors: list[JudgedError], robot: str) -> Iterator[Verdict]:
    """Yield the largest error of a joint's current, converted to torque [Nm]."""
    known = [one for one in errors if one.largest_torque is not None]
    if known:
        most = max(known, key=lambda one: one.largest_torque or 0.0)
        about: Any = {"question": QUESTION, "arm": robot, "rank": 6, "unit": "Nm"}
        yield Verdict(
            **about,
            quantity="error on the worst recording as a torque",
            sense="less",
            value=most.largest_torque,
            joint=most.joint,
        )


def _farthest_in_time(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Yield the largest number of days from a dated recording to the nearest day of the fit, with
    that recording.
    """
    away = days_away(study)
    if away and (days := max(away.values())):
        about: Any = {"question": QUESTION, "arm": robot, "rank": 7, "unit": "days"}
        name = max(away, key=away.__getitem__)
        yield Verdict(
            **about,
            quantity="farthest from a day of the fit",
            sense="less",
            value=days,
            recording=name,
        )


def judge_friction(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Yield the widest relative 95 % interval of a usable total friction, and the numbers of those
    that may be used, and that are without a doubt.
    """
    rows = study.rows("friction")
    rows = rows[rows["parameter"].astype(str).str.startswith(TOTAL)]
    if rows.empty:
        return
    half = rows[["low", "high"]].sub(rows["value"], axis="index").abs().max(axis="columns")
    shares = half / rows["value"].abs()
    usable = rows[(rows["use"] == "yes") & (shares < 1)]  # an estimate below its error is useless
    others = rows[~rows["joint"].isin(usable["joint"])]
    reason = reason_in(
        next(iter(others["reason"].dropna().mode()), "undetermined" * bool(len(others)))
    )
    about: Any = {"question": "friction", "arm": robot}
    if len(usable):
        worst = usable.loc[shares[usable.index].idxmax()]
        yield _widest_friction(worst, float(shares[worst.name]), about)
    yield Verdict(
        **about,
        rank=2,
        reason=reason,
        quantity="total frictions that may be used, of each joint at four velocities",
        sense="more",
        count=len(usable),
        of=len(rows),
    )
    yield _sure_frictions(rows, about)


def _sure_frictions(rows: pd.DataFrame, about: Mapping[str, Any]) -> Verdict:
    """Return the number of total frictions, one a row, without a doubt."""
    sure = rows["state"].eq("good")
    doubts = rows.loc[~sure, "reason"].dropna().mode()
    return Verdict(
        **about,
        rank=3,
        reason=reason_in(next(iter(doubts), "")),
        quantity="total frictions without a doubt, of each joint at four velocities",
        sense="more",
        count=int(sure.sum()),
        of=len(rows),
    )


def _widest_friction(worst: Any, share: float, about: dict[str, Any]) -> Verdict:
    """Return the verdict of the row of the widest interval; share: half of it over its value."""
    return Verdict(
        **about,
        reason=reason_in(worst["reason"]),
        quantity="widest 95 % interval of a total friction that may be used, half of it",
        sense="less",
        value=100 * share,
        unit="%",
        joint=int(worst["joint"]),
        motion=str(worst["parameter"]).replace(TOTAL, "at ") + " rad/s",
    )
