"""Torque constants and gains: how many may be used, their uncertainty, and their deviation."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import bdtr

from ur5lib.judging.limits import BELIEVED, MAX_LOAD_ERROR
from ur5lib.judging.study import StudyTables
from ur5lib.records.codes import Found
from ur5lib.records.quality import STOP
from ur5lib.records.verdicts import Reason, State, Verdict, reason_in

QUESTION = "constants"
CONSTANTS = ["torque_constant", "gain"]  # the parameter of currents and of measured torques


def constants(study: StudyTables) -> pd.DataFrame:
    """Return the rows of torque constants or gains."""
    return study.rows("friction", parameter=CONSTANTS)


def judge_constants(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Judge the constants by how many may be used; yield nothing without fitted friction."""
    rows = constants(study)
    if len(study.rows("remarks", step=STOP)):
        yield Verdict(question=QUESTION, arm=robot, state="do not use", reason="stopped")
    elif len(rows):
        yield from _counted(rows, robot)
        yield from _widest(rows, robot)
        yield from _farthest(rows, study, robot)
        yield _without_doubt(rows, robot)


def _counted(rows: pd.DataFrame, robot: str) -> Iterator[Verdict]:
    """Yield the number of joints with a usable constant, and the gravest reason against others."""
    use = rows["use"] == "yes"
    reason, row = _gravest(rows)
    state: State = "usable" if use.any() else "not determined"
    if rows["reason"].isin(["unlikely", "touched"]).any():
        state = "do not use"
    elif not reason:
        state = "good"
    yield Verdict(
        question=QUESTION,
        arm=robot,
        state=state,
        reason=reason,
        quantity="joints whose constant may be used",
        sense="more",
        count=int(use.sum()),
        of=len(rows),
        joint=None if row is None else int(row["joint"]),
    )


def _without_doubt(rows: pd.DataFrame, robot: str) -> Verdict:
    """Return the number of constants without a doubt."""
    return Verdict(
        question=QUESTION,
        arm=robot,
        rank=4,
        reason=_gravest(rows)[0],
        quantity="constants without a doubt",
        sense="more",
        count=int(rows["state"].eq("good").sum()),
        of=len(rows),
    )


REASONS_BY_GRAVITY: list[Reason] = [
    "unlikely",
    "touched",
    "contradicted",
    "unproven",
    "unknown_links",
    "undetermined",
    "prior_only",
    "far",
    "excludes",
    "imprecise",
    "one_path",
]


def _gravest(rows: pd.DataFrame) -> tuple[Reason, "pd.Series[Any] | None"]:
    """Return the gravest reason of any joint and that joint's row, or "" and None."""
    for reason in REASONS_BY_GRAVITY:
        if len(own := rows[rows["reason"] == reason]):
            return reason, own.iloc[0]
    return "", None


def _widest(rows: pd.DataFrame, robot: str) -> Iterator[Verdict]:
    """Yield the largest relative half-width of a usable constant's 95 % interval [%]."""
    usable = rows[rows["use"] == "yes"]
    if usable.empty:
        return
    half = usable[["low", "high"]].sub(usable["value"], axis="index").abs().max(axis="columns")
    shares = 100 * half / usable["value"].abs()
    row = usable.loc[shares.idxmax()]
    several = len(usable) > 1
    yield Verdict(
        question=QUESTION,
        arm=robot,
        rank=2,
        reason="one_path" if (usable["reason"] == "one_path").any() else "",
        quantity="widest 95 % interval of a usable constant, half of it",
        sense="less",
        value=float(shares.max()),
        unit="%",
        low=float(shares.min()) if several else None,
        high=float(shares.max()) if several else None,
        interval="range over joints" if several else "",
        joint=int(row["joint"]),
    )


DETERMINED = "determined constant"
BY_ITSELF = "constant that a joint alone would give, not used"


def _farthest(rows: pd.DataFrame, study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Yield the constant farthest from the documented one, in its standard deviations.

    Only determined constants count, and those that contradict the documented one.
    """
    refused = rows["contradicted"].notna()
    told = rows[(rows["determined"] == "yes") | refused].dropna(subset=["known", "known_std"])
    told = told[told["reason"] != "unknown_links"]
    if told.empty:
        return
    value = told["contradicted"].where(told["contradicted"].notna(), told["value"]).astype(float)
    row = told.loc[((value - told["known"]).abs() / told["known_std"]).idxmax()]
    stated = pd.isna(row["contradicted"])
    yield Verdict(
        question=QUESTION,
        arm=robot,
        rank=3,
        reason=reason_in(row["reason"]),
        quantity=f"{DETERMINED if stated else BY_ITSELF}, farthest from the known one",
        value=float(value[row.name]),
        unit=study.effort.constant_unit,
        low=float(row["low"]) if stated else None,
        high=float(row["high"]) if stated else None,
        interval="95 %" if stated else "",
        joint=int(row["joint"]),
        rival="known",
        rival_value=float(row["known"]),
    )


def judge_gravity(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Yield the relative deviation [%] from the documented constant of each joint that gravity
    loads: a large one means that arm, mounting or payload are not as described.
    """
    rows = constants(study)
    if rows.empty or study.stopped():
        return
    bears = rows["joint"].isin([*study.bearing.get(robot, ())])
    known = rows["use"].eq("yes") | rows["reason"].isin(["unlikely", "contradicted"])
    value = rows["contradicted"].where(rows["contradicted"].notna(), rows["value"]).astype(float)
    off = 100 * (value / rows["known"] - 1)
    order = np.argsort(-off[bears & known].abs(), kind="stable")
    for rank, row in enumerate(rows[bears & known].iloc[order].itertuples(), start=1):
        yield Verdict(
            question="gravity",
            arm=robot,
            rank=rank,
            reason=reason_in(row.reason),
            quantity="constant off the known one, at a joint that gravity loads",
            sense="change",
            value=float(off[row.Index]),
            unit="%",
            low=None if row.reason == "contradicted" else 100 * (row.low / row.known - 1),
            high=None if row.reason == "contradicted" else 100 * (row.high / row.known - 1),
            interval="" if row.reason == "contradicted" else "95 % of the fit alone",
            joint=int(row.joint),
        )


AGAINST_GRAVITY = ("far", "unlikely", "contradicted")  # reasons of constants, or a load is wrong


def _state_of_load(
    rows: pd.DataFrame, agree: "pd.Series[bool]", carried: float
) -> tuple[State, Reason]:
    """Return whether loads are the declared ones: of true ones, one in twenty intervals disagrees.

    agree: by row; carried: a load that the arm carries well [kg].
    """
    if (rows["taken"] == "yes").any():
        return "usable", "loaded"
    others = int((~agree).sum())
    if others and bdtr(others - 1, len(rows), 1 - BELIEVED) >= BELIEVED:  # P(fewer)
        return "usable", "disagrees"
    if rows["half"].max() > MAX_LOAD_ERROR * carried:
        return "not determined", "load_unsure"
    return "good", ""


def judge_load(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Yield the number of contact-free recordings on which the load's 95 % interval contains the
    declared load. Recordings with a half interval wider than the arm's load are not counted.
    """
    names = [*study.with_role("fit"), *study.with_role("validate")]
    rows = study.rows("payload", recording=names)
    rows = rows.assign(half=(rows["high"] - rows["low"]) / 2)
    rows = rows[rows["half"] < study.loads.get(robot, 0.0)]
    if rows.empty or study.stopped():
        return
    agree = (rows["low"] <= 0) & (rows["high"] >= 0)
    about: Any = {"question": "load", "arm": robot}
    meant = "that of the others" if robot in study.placeholders else "the declared one"
    state, reason = _state_of_load(rows, agree, study.loads[robot])
    if state == "good" and any(
        one.reason in AGAINST_GRAVITY for one in judge_gravity(study, robot)
    ):
        state, reason = "usable", "constant"
    if state == "good" and robot in study.placeholders:
        state, reason = "not determined", "unknown_links"
    yield Verdict(
        **about,
        state=state,
        reason=reason,
        quantity=f"recordings whose load agrees with {meant}",
        sense="more",
        count=int(agree.sum()),
        of=len(rows),
    )
    about |= {"unit": "kg"}
    yield Verdict(
        **about,
        rank=2,
        quantity="widest 95 % interval of such a load, half of it",
        sense="less",
        value=float(rows["half"].max()),
        recording=str(rows.loc[rows["half"].idxmax(), "recording"]),
    )
    for rank, shown in enumerate(_loads(rows, rows[~agree], meant), start=3):
        yield Verdict(**about, rank=rank, **shown)


def _loads(rows: pd.DataFrame, other: pd.DataFrame, meant: str) -> Iterator[dict[str, Any]]:
    """Yield the undeclared loads that are taken off, and the largest of the others that differ, as
    fields of verdicts.
    """
    for row in rows[rows["taken"] == "yes"].itertuples():
        yield _mass(row) | {"quantity": Found.UNDECLARED_LOAD.words, "sense": "less"}
    other = other[other["taken"] != "yes"].dropna(subset="mass")
    for row in other.loc[other["mass"].abs().nlargest(1).index].itertuples():
        yield _mass(row) | {"quantity": f"load farthest from {meant}, by", "sense": "change"}


def _mass(row: Any) -> dict[str, Any]:
    """Return a load [kg] with its interval; row: of payload.csv."""
    about = {"value": float(row.mass), "low": float(row.low), "high": float(row.high)}
    return about | {"interval": "95 %", "recording": row.recording}
