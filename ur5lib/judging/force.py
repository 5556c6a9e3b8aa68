"""The force in contact, compared with a sensor, and the worth of its bands."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.force.estimators import GATED, NEW, PUBLISHED, SPOKEN, STATIC, UNGATED
from ur5lib.judging.errors import beaten
from ur5lib.judging.limits import (
    MAX_BLIND_SHARE,
    MAX_DRIFT_ERROR,
    MAX_GOOD_FLOORS,
    MIN_GOOD_COVERAGE,
    MIN_GOOD_SKILL,
    MIN_PUSH,
    MIN_USABLE_COVERAGE,
)
from ur5lib.judging.study import AT_REST, IN_MOTION, StudyTables
from ur5lib.records.verdicts import ErrorParts, Reason, Sense, State, Verdict
from ur5lib.timeseries.metrics import NORMAL95

QUESTION = "force"
RANK = {name: place for place, name in enumerate([*NEW, *PUBLISHED])}  # the report has this order
RIVAL = "least squares without a detector"


def leading(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the leading estimate: of the estimates in these rows, the first in the
    report's order.
    """
    rank = rows["estimate"].map(RANK)
    return rows[rank == rank.min()]


def in_contact(study: StudyTables) -> pd.DataFrame:
    """Return the leading estimate's errors along x, y, z on recordings that no fit has used, with
    those of plain least squares (`plain`) and the repeatability.
    """
    about: Any = {"kind": "compensated", "during": "contact", "component": ["Fx", "Fy", "Fz"]}
    every = study.rows("force_mae", **about)
    every = every[every["reason"] != "fitted"]
    key = ["recording", "component"]
    plain = every[every["estimate"] == UNGATED].set_index(key)
    plain = plain[["mae", "even_interval_score95"]].set_axis(["plain", "plain_score"], axis=1)
    rows = leading(every).join(plain, on=key)
    floors = study.rows("repetition", quantity="force")
    floors = floors.astype({"component": object})
    floors = floors.assign(in_floors=floors["error"] / floors["floor"])
    floors = floors.set_index(["robot", "component"])[["floor", "in_floors"]]
    rows = rows.assign(robot=rows["recording"].map(study.arms()), axis=rows["component"].str[1:])
    return rows.join(floors, on=["robot", "component"])


def sure(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the errors on recordings on which the sensor's bias is certain; all errors if it is
    certain on none.
    """
    known = rows[rows["use"] == "yes"]
    return known if len(known) else rows


def judge_force(study: StudyTables) -> Iterator[Verdict]:
    """Judge the force by its mean error over the mean force, and doubt it by its worst axis and
    recording, and by the mean error of plain least squares.
    """
    if study.stopped():
        yield Verdict(question=QUESTION, state="do not use", reason="stopped")
        return
    known = in_contact(study)
    if known.empty:
        yield Verdict(question=QUESTION, state="not determined", reason=_why_not(study))
        return
    rows = sure(known)
    state, reason = state_of(rows)
    yield from _numbers(rows, known.drop(rows.index), state, reason)
    yield from _bands(study, known)


def _why_not(study: StudyTables) -> Reason:
    """Return why no sensor judges the force."""
    if study.tables["force_mae"].empty and len(study.tables["friction"]):
        return "no_sensor"
    unsearched = study.rows("detection", estimate=GATED).empty
    return "uncalibrated" if unsearched else "no_contact"


def state_of(rows: pd.DataFrame) -> tuple[State, Reason]:
    """Return the state of the force and the reason why it is not better."""
    pooled = rows[["mae", "mean_force"]].mean()
    if (rows["use"] == "no").all():
        return "not determined", "sensor_bias"
    if pooled["mae"] >= pooled["mean_force"]:
        return "do not use", "worse_than_zero"
    if rows["coverage95"].mean() < MIN_USABLE_COVERAGE:
        return "do not use", "undercovers"
    share = max(_worst_axis(rows)["share"], _worst_recording(rows)["share"])
    reason: Reason = next(_doubts(rows, share), "")
    return ("usable" if reason else "good"), reason


def _doubts(rows: pd.DataFrame, share: float) -> Iterator[Reason]:
    """Yield why a force is not good, the gravest reason first; share: error / mean force."""
    pushed = rows[rows["mean_force"] > MIN_PUSH]
    if share >= 1:
        yield "large_error"
    if rows["estimate"].eq(STATIC).any():
        yield "uncalibrated"
    yield from beaten(rows["mae"].mean(), rows["plain"].mean())
    if (rows["in_floors"] > MAX_GOOD_FLOORS).any():
        yield "far_above_floor"
    if pushed["coverage95"].min() < MIN_GOOD_COVERAGE:
        yield "undercovers"
    if rows["zero_in_band95"].max() > MAX_BLIND_SHARE:
        yield "blind"
    worst = _worst_axis(rows)
    if not worst["mae_high"] < (1 - MIN_GOOD_SKILL) * worst["mean_force"]:
        yield "wide_interval"
    if share >= 1 - MIN_GOOD_SKILL:
        yield "large_error"


def _worst_axis(rows: pd.DataFrame) -> "pd.Series[Any]":
    """Return the row with the largest error, and its share of the mean force."""
    row = rows.loc[rows["mae"].idxmax()]
    return pd.Series({**row, "share": row["mae"] / row["mean_force"]})


def _worst_recording(rows: pd.DataFrame) -> "pd.Series[Any]":
    """Return the means over x, y, z of the recording with the largest error / mean force."""
    means = rows.groupby("recording", sort=False)[["mae", "mean_force", "plain"]].mean()
    means["share"] = means["mae"] / means["mean_force"]
    return means.loc[means["share"].idxmax()]


def _numbers(
    rows: pd.DataFrame, doubted: pd.DataFrame, state: State, reason: Reason
) -> Iterator[Verdict]:
    """Yield the mean error, that of the worst axis, a larger one where the bias is uncertain, that
    on the worst recording of several, and the gain of the estimate over the sensor.
    """
    row, share, has_rival = _worst_axis(rows), _worst_recording(rows), rows["plain"].notna().any()
    name = f"mean absolute error of {_named(str(row['estimate']))} in contact"
    about: dict[str, Any] = {"question": QUESTION, "unit": "N", "quantity": name}
    about |= {"sense": "less"}

    def beside(rival: float, where: str = "") -> dict[str, Any]:
        return {"rival": RIVAL + where, "rival_value": _known(rival)} if has_rival else {}

    recordings = {*rows["recording"]}
    mean: Any = {"axis": "mean of x, y, z", "recording": str(share.name)}
    means = rows[["mae", "mean_force", "plain", "floor"]].astype(float).mean()
    first = about | _errors(means) | beside(means["plain"]) | {"axis": "per axis"}
    floor = _known(means["floor"])
    yield Verdict(**first, state=state, reason=reason, floor=floor, basis="unseen")
    worst = about | _errors(row) | beside(rows["plain"].max(), " at its worst") | _interval(row)
    yield Verdict(**worst, **_place(row), rank=2, floor=_known(row["floor"]))
    if len(doubted) and doubted["mae"].max() > row["mae"]:
        most = doubted.loc[doubted["mae"].idxmax()]
        yield Verdict(**about, **_errors(most), **_place(most), rank=3, reason="sensor_bias")
    if len(recordings) > 1:
        yield Verdict(**about, **_errors(share), **mean, **beside(share["plain"]), rank=4)
    if not math.isnan(row["slope"]):
        gain: Any = {"question": QUESTION, "quantity": "gain of the estimate over the sensor"}
        gain |= {"sense": "ratio"}
        yield Verdict(**gain, **_place(row), rank=5, value=row["slope"])


def _errors(row: "pd.Series[Any]") -> dict[str, Any]:
    return {"value": float(row["mae"]), "zero": float(row["mean_force"])}


def _place(row: "pd.Series[Any]") -> dict[str, Any]:
    return {"axis": row["axis"], "recording": row["recording"]}


def _named(estimate: str) -> str:
    return SPOKEN[estimate]


def _known(value: float) -> float | None:
    return None if pd.isna(value) else float(value)


def _interval(row: "pd.Series[Any]") -> dict[str, Any]:
    if pd.isna(row["mae_low"]):
        return {}
    return {"low": row["mae_low"], "high": row["mae_high"], "interval": "95 %"}


def _bands(study: StudyTables, known: pd.DataFrame) -> Iterator[Verdict]:
    """Yield the interval score of the 95 % bands in contact, which decides, and their quality along
    pushed axes, at rest and in motion, the worse first.
    """
    scored = sure(known).dropna(subset=["interval_score95"])
    if len(scored):
        yield _score(scored)
    rows = known.dropna(subset=["coverage95", "band_factor95"])
    rows = rows[rows["mean_force"] > MIN_PUSH]
    moves = np.array([bool(study.moving(name)) for name in rows["recording"]], dtype=bool)
    halves = {IN_MOTION: rows[moves], AT_REST: rows[~moves]}
    order = sorted(halves.items(), key=lambda half: half[1]["coverage95"].min())
    numbers = [(when, *number) for when, part in order if len(part) for number in _worth(part)]
    first = 2 if len(scored) else 1
    for rank, (when, quantity, sense, value, unit, row, reason) in enumerate(numbers, start=first):
        yield Verdict(
            question="bands",
            rank=rank,
            motion=when,
            reason=reason,
            quantity=quantity,
            sense=sense,
            value=_known(value),
            unit=unit,
            axis=row["axis"],
            recording=row["recording"],
        )
    if len(rows):
        yield _width(rows, first + len(numbers))


def _width(rows: pd.DataFrame, rank: int) -> Verdict:
    """Return the range of the bands' mean width in contact over recordings and pushed axes."""
    widths = rows["width95"].astype(float)
    return Verdict(
        question="bands",
        rank=rank,
        quantity="width of the 95 % band in contact, mean",
        sense="less",
        unit="N",
        low=float(widths.min()),
        high=float(widths.max()),
        interval="range over recordings and axes",
    )


def _score(rows: pd.DataFrame) -> Verdict:
    """Return the interval score of the bands on the recording where it is farthest above that of
    plain least squares, or else of zero; the axis with the least readings in its band counts.
    """
    names = {"interval_score95": "score", "zero_interval_score95": "zero", "plain_score": "rival"}
    means = rows.rename(columns=names).groupby("recording", sort=False)
    means = means[[*names.values()]].mean().join(means["coverage95"].min())
    row = means.loc[(means["score"] / means["rival"].fillna(means["zero"])).idxmax()]
    state, reason = _state_of_bands(row, bool((rows["use"] == "no").all()))
    rival: dict[str, Any] = {"rival": RIVAL, "rival_value": row["rival"]}
    return Verdict(
        question="bands",
        state=state,
        reason=reason,
        quantity="interval score of the 95 % band in contact: width and 40 times what lies outside",
        sense="less",
        value=row["score"],
        unit="N",
        axis="mean of x, y, z",
        recording=str(row.name),
        zero=row["zero"],
        **({} if pd.isna(row["rival"]) else rival),
    )


def _state_of_bands(row: "pd.Series[Any]", doubted: bool) -> tuple[State, Reason]:
    """Return the state of bands and the reason why it is not better; doubted: sensors' biases."""
    if doubted:
        return "not determined", "sensor_bias"
    if row["score"] >= row["zero"]:
        return "do not use", "worse_than_zero"
    few: Reason = "undercovers" if row["coverage95"] < MIN_GOOD_COVERAGE else ""
    reason = few or next(beaten(row["score"], row["rival"]), "")
    return ("usable" if reason else "good"), reason


def _worth(
    part: pd.DataFrame,
) -> Iterator[tuple[str, Sense, float, str, "pd.Series[Any]", Reason]]:
    """Yield for bands in contact the least share of readings in the band, the longest share of time
    in which it contains zero, and its relative width: (quantity, sense, value, unit, row,
    reason) each.
    """
    own = sure(part)
    doubt: Reason = "sensor_bias" if (own["use"] == "no").any() else ""
    least = own.loc[own["coverage95"].idxmin()]
    few = least["coverage95"] < MIN_GOOD_COVERAGE
    quantity = "readings in contact within the 95 % band, least share"
    yield (
        quantity,
        "at least",
        100 * least["coverage95"],
        "%",
        least,
        "undercovers" if few else doubt,
    )
    blind = own.loc[own["zero_in_band95"].astype(float).fillna(0.0).idxmax()]
    long = blind["zero_in_band95"] > MAX_BLIND_SHARE
    quantity = "time in contact in which the 95 % band contains zero on all axes, at most"
    yield quantity, "at most", 100 * blind["zero_in_band95"], "%", blind, "blind" if long else doubt
    farthest = own.loc[np.log(own["band_factor95"].astype(float)).abs().idxmax()]
    quantity = "width of the 95 % band over the width that contains 95 %, farthest from 1"
    yield quantity, "ratio", 1 / farthest["band_factor95"], "", farthest, doubt


def error_parts(study: StudyTables) -> Iterator[ErrorParts]:
    """Yield the parts of the error in contact by recording, means over x, y, z [N]; friction: the
    remainder that neither alarms nor a gain explain.
    """
    rows = in_contact(study)
    names = {"mae": "error", "mae_missed": "missed", "mae_shut": "late_alarms", "mae_gain": "gain"}
    means = rows.groupby("recording", sort=False)[[*names, "mean_force"]].mean()
    means = means.dropna(subset=[*names]).rename(columns=names)
    means["share"] = means["error"] / means.pop("mean_force")
    means["friction"] = means["error"] - means[["missed", "late_alarms", "gain"]].sum(
        axis="columns"
    )
    drifts = _determined_drifts(study.tables["sensed"].set_index("recording"))
    doubted = study.doubted()
    for name, row in means.iterrows():
        drift: dict[str, Any] = {key: _known(value) for key, value in drifts.loc[name].items()}
        bias = "uncertain" if name in doubted else "sure"
        yield ErrorParts(recording=str(name), **row.to_dict(), sensor_bias=bias, **drift)


def _determined_drifts(sensed: pd.DataFrame) -> pd.DataFrame:
    """Return the drift of each sensor's bias, empty where its 95 % interval is too wide."""
    drifts, stds = ([f"{kind}_{axis}" for axis in "xyz"] for kind in ("drift", "drift_std"))
    errors = sensed[stds].astype(float)
    known = NORMAL95 * errors.to_numpy() <= MAX_DRIFT_ERROR
    return (
        sensed[drifts]
        .astype(float)
        .where(known)
        .assign(drift_std=errors.where(known).max(axis="columns"))
    )
