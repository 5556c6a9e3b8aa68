"""Errors by joint or component, the state that follows from each, and which of them decides."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from ur5lib.judging.limits import (
    BETTER_RIVAL_RATIO,
    MAX_GOOD_FLOORS,
    MIN_DIFFERENCE,
    MIN_GOOD_BAND_FACTOR,
    MIN_GOOD_COVERAGE,
    MIN_GOOD_SKILL,
)
from ur5lib.judging.study import StudyTables
from ur5lib.records.verdicts import JudgedError, Reason, State, Verdict

STATES_BY_SEVERITY: list[State] = ["do not use", "usable", "good", "not determined"]


@dataclass(frozen=True)
class Conditions:
    """What decides whether an error of an estimate is good.

    unseen: whether no fit has used its recordings, which a good one needs; better: the skill that
    it must exceed; least: mean size of the measured quantity [its unit] up to which no error is
    judged; simple_rival: whether the rival is a simple method, which a good estimate beats.
    """

    unseen: bool = True
    better: float = MIN_GOOD_SKILL
    least: float = MIN_DIFFERENCE
    simple_rival: bool = True


def by_place(rows: pd.DataFrame, place: str) -> pd.DataFrame:
    """Return mean errors by joint or component, and the largest with its recording.

    rows: by recording and place, with `error` and `zero`.
    """
    rows = rows.dropna(subset=["error", "zero"])
    groups = rows.groupby(place, sort=False)
    table = groups["error"].agg(error="mean", low="min", high="max", recordings="size")
    table["zero"] = groups["zero"].mean()
    most = rows.loc[groups["error"].idxmax()].set_index(place)[["error", "recording", "zero"]]
    return table.join(most.set_axis(["largest", "recording", "largest_zero"], axis="columns"))


def with_floors(table: pd.DataFrame, study: StudyTables, quantity: str) -> pd.DataFrame:
    """Return errors by place with `floor`, the difference between repeated motions, and
    `in_floors`, the error on these motions as a multiple of it.
    """
    rows = study.rows("repetition", quantity=quantity)
    rows = rows.set_index("component" if quantity == "force" else "joint")
    return table.join(rows.assign(in_floors=rows["error"] / rows["floor"])[["floor", "in_floors"]])


def judged(
    question: str, robot: str, unit: str, table: pd.DataFrame, conditions: Conditions
) -> list[JudgedError]:
    """Return a `JudgedError` with state and reason for each row of a table of `by_place`, which may
    also have the columns of a rival.
    """
    place = str(table.index.name)
    found = []
    for name, row in table.iterrows():
        own = {key: value for key, value in row.items() if not _is_empty(value)}
        state, reason = state_of(row, conditions)
        about: dict[str, Any] = {"question": question, "robot": robot, "unit": unit}
        about |= {place: int(str(name)) if place == "joint" else name}
        own["recordings"] = int(own["recordings"])
        found.append(JudgedError(**about, **own, state=state, reason=reason))
    return found


def _is_empty(value: object) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def state_of(row: "pd.Series[Any]", conditions: Conditions) -> tuple[State, Reason]:
    """Return the state of an error and the reason why it is not better."""
    if not row["zero"] > conditions.least:
        return "not determined", "too_small"
    skill = 1 - row["error"] / row["zero"]
    if skill <= 0:
        return "do not use", "worse_than_zero"
    reason: Reason = next(_doubts(row, conditions), "")
    return ("usable" if reason else "good"), reason


def _doubts(row: "pd.Series[Any]", conditions: Conditions) -> Iterator[Reason]:
    """Yield why an error is not good, the gravest reason first."""
    if not conditions.unseen:
        yield "no_unseen"
    if row.get("coverage95", math.nan) < MIN_GOOD_COVERAGE:
        yield "undercovers"
    if conditions.simple_rival:
        yield from beaten(row["error"], row.get("rival_error", math.nan))
    if row["error"] > MIN_DIFFERENCE and row.get("in_floors", math.nan) > MAX_GOOD_FLOORS:
        yield "far_above_floor"
    if 1 - row["error"] / row["zero"] <= conditions.better:
        yield "large_error"
    if row.get("band_factor95", math.nan) < MIN_GOOD_BAND_FACTOR:
        yield "too_wide"


def beaten(error: float, rival: float) -> Iterator[Reason]:
    """Yield whether a rival's error is clearly less, or about the same."""
    if error - rival > MIN_DIFFERENCE and rival < BETTER_RIVAL_RATIO * error:
        yield "rival_better"
    elif error > MIN_DIFFERENCE and error >= BETTER_RIVAL_RATIO * rival:
        yield "rival_equal"


def verdicts(
    errors: Sequence[JudgedError], quantity: str, interval: str = "", **about: Any
) -> Iterator[Verdict]:
    """Yield the decisive error, the largest relative one if it is another, the largest on a
    recording, and the largest multiple of the repeatability.

    The error with the gravest state, then the gravest reason, decides. The relative error is
    error / zero. The largest on a recording includes errors that are not judged.
    """
    known = [one for one in errors if one.state != "not determined"]
    first = min(known, key=severity)
    worst = max(known, key=lambda one: one.error / one.zero)
    relative = f"{quantity}, relatively the largest"
    yield _verdict(first, 1, relative if first is worst else quantity, interval, **about)
    if worst is not first:
        yield _verdict(worst, 2, relative, interval, **about)
    yield _largest([one for one in errors if one.unit == worst.unit], quantity, **about)
    yield from _repeated(known, **about)


def _largest(errors: Sequence[JudgedError], quantity: str, **about: Any) -> Verdict:
    """Return the error on the worst recording."""
    most = max(errors, key=lambda one: one.largest)
    return Verdict(
        question=most.question,
        rank=3,
        sense="less",
        quantity=f"{'distance' if 'distance' in quantity else 'error'} on the worst recording",
        value=most.largest,
        unit=most.unit,
        joint=most.joint,
        axis=most.component,
        recording=most.recording,
        zero=most.largest_zero if most.largest_zero > MIN_DIFFERENCE else None,
        **about,
    )


def _repeated(errors: Sequence[JudgedError], **about: Any) -> Iterator[Verdict]:
    """Yield the error on repeated motions that is the largest multiple of their difference."""
    known = [(one, (one.in_floors or 0.0) * (one.floor or 0.0)) for one in errors]
    if known := [(one, error) for one, error in known if error > MIN_DIFFERENCE]:
        most, error = max(known, key=lambda pair: pair[0].in_floors or 0.0)
        yield Verdict(
            question=most.question,
            rank=8,
            quantity="error on repeated motions, largest multiple of the repeatability",
            sense="less",
            value=error,
            unit=most.unit,
            joint=most.joint,
            axis=most.component,
            floor=most.floor,
            **about,
        )


REASONS_BY_GRAVITY: list[Reason] = [
    "worse_than_zero",
    "no_unseen",
    "undercovers",
    "rival_better",
    "rival_equal",
    "far_above_floor",
    "large_error",
    "too_wide",
    "",
]


def severity(one: JudgedError) -> tuple[int, int, float]:
    """Return what sorts errors by state, then by reason, then by size, the gravest first."""
    state = STATES_BY_SEVERITY.index(one.state)
    worst = -one.error / one.zero
    if one.reason == "undercovers" and one.coverage95 is not None:
        worst = one.coverage95
    return state, REASONS_BY_GRAVITY.index(one.reason), worst


def _verdict(one: JudgedError, rank: int, quantity: str, interval: str, **about: Any) -> Verdict:
    spread = one.recordings > 1
    return Verdict(
        question=one.question,
        rank=rank,
        state=one.state if rank == 1 else None,
        reason=one.reason,
        quantity=quantity,
        sense="less",
        value=one.error,
        unit=one.unit,
        low=one.low if spread else None,
        high=one.high if spread else None,
        interval=interval if spread else "",
        joint=one.joint,
        axis=one.component,
        recording="" if spread else one.recording,
        zero=one.zero,
        rival=one.rival,
        rival_value=one.rival_error,
        **about,
    )


def severest(states: Iterable[State | None]) -> State:
    """Return the severest of several states: good only if all are good."""
    known = sorted((one for one in states if one), key=STATES_BY_SEVERITY.index)
    mixed = known[0] == "good" and known[-1] != "good"
    return "usable" if mixed else known[0]
