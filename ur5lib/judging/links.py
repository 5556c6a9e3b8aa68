"""Link models and their torques, compared with the controller's."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import pandas as pd

from ur5lib.judging.errors import Conditions, by_place, judged, verdicts, with_floors
from ur5lib.judging.limits import (
    BETTER_RIVAL_RATIO,
    MIN_DIFFERENCE,
    MIN_LINK_SKILL,
    MIN_LINK_TORQUE,
)
from ur5lib.judging.study import StudyTables
from ur5lib.records.codes import Found
from ur5lib.records.verdicts import JudgedError, ModelError, Reason, Verdict

QUESTION = "links"


class ModelComparison(NamedTuple):
    """Errors of the link models at one motion, on recordings in which the arm moves.

    rows: of torque_mae.csv; unseen: whether no fit has used these recordings; ranked: the models,
    first those that are near on most joints (least error, or at most 5 % more), then by error;
    best: the models that are near on most joints; near: on how many; differ: number of joints on
    which the models differ, and which alone count.
    """

    rows: pd.DataFrame
    unseen: bool
    ranked: list[str]
    best: list[str]
    near: int
    differ: int


def compare(study: StudyTables) -> ModelComparison | None:
    """Compare the link models, on unseen recordings if possible; None without a motion."""
    rows = study.rows("torque_mae").dropna(subset="mae")
    rows = rows[rows["recording"].isin([*filter(study.moving, rows["recording"].unique())])]
    if rows.empty:
        return None
    unseen = rows[~rows["recording"].isin(study.with_role("fit"))]
    rows = unseen if len(unseen) else rows
    rows = rows[rows["motion"] == rows["motion"].iloc[0]]
    mean = rows.pivot_table("mae_2hz", "joint", "model", aggfunc="mean")
    above = mean.sub(mean.min(axis="columns"), axis="index")
    equal = (above <= MIN_DIFFERENCE) | (above <= (1 - BETTER_RIVAL_RATIO) * mean)
    close = equal[above.max(axis="columns") > MIN_DIFFERENCE]
    counts = close.sum()
    ranked = sorted(counts.index, key=lambda model: (-counts[model], float(above[model].sum())))
    best = ranked[: int((counts == counts.max()).sum())]
    return ModelComparison(rows, len(unseen) > 0, ranked, best, int(counts.max()), len(close))


def named(model: str) -> str:
    """Return a model's name as used in sentences: Model C, the model “identified”."""
    return f"Model {model}" if model[0].isupper() else f"the model “{model}”"


def errors(study: StudyTables, robot: str) -> list[JudgedError]:
    """Return by joint the errors below 2 Hz of the model that is closest on most joints, with the
    errors of the second model.
    """
    compared = compare(study)
    if compared is None:
        return []
    first, *others = compared.ranked
    rows = compared.rows.assign(error=compared.rows["mae_2hz"], zero=compared.rows["zero_mae_2hz"])
    table = by_place(rows[rows["model"] == first], "joint").assign(model=first)
    table = with_floors(table, study, "torque")
    if others:
        following = rows[rows["model"] == others[0]].groupby("joint")["error"].mean()
        table["rival"], table["rival_error"] = others[0], following.reindex(table.index)
    conditions = Conditions(compared.unseen, MIN_LINK_SKILL, MIN_LINK_TORQUE, simple_rival=False)
    return judged(QUESTION, robot, "Nm", table, conditions)


def judge_links(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Judge the link model that is closest on most joints, below 2 Hz.

    Gravity dominates there, so a good model needs more skill than other estimates.
    """
    every = errors(study, robot)
    found = [one for one in every if one.state != "not determined"]
    compared = compare(study)
    if not found or compared is None:
        yield from _without_targets(study, robot)
        return
    motion = f"{compared.rows['motion'].iloc[0]} motion".replace("_", " ")
    count = max(one.recordings for one in found)
    about: Any = {"arm": robot, "motion": motion, "basis": "unseen" if compared.unseen else "fit"}
    quantity = f"distance of {named(compared.best[0])} from the controller's torque below 2 Hz"
    rows = [*verdicts(every, quantity, f"range over {count} recordings", **about)]
    yield from _under_given_load(study, compared, rows)
    verb = "come" if compared.best[1:] else "comes"
    yield Verdict(
        question=QUESTION,
        arm=robot,
        rank=4,
        quantity=f"joints on which {' and '.join(map(named, compared.best))} {verb} closest, "
        "or at most 5 % farther",
        sense="more",
        count=compared.near,
        of=compared.differ,
    )


def _under_given_load(
    study: StudyTables, compared: ModelComparison, rows: list[Verdict]
) -> Iterator[Verdict]:
    """Yield the verdicts, "good" lowered to "usable" if the controller assumes a load that the
    study does not declare.
    """
    names = [*compared.rows["recording"].unique()]
    loads = study.rows("quality", code=Found.GIVEN_LOAD, recording=names)
    first, *others = rows
    if len(loads) and first.state == "good":
        first = replace(
            first, state="usable", reason="loaded", recording=loads["recording"].iloc[0]
        )
    yield from (first, *others)


def _without_targets(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Yield why links are not judged; for links fitted to measured torques, with the number of
    determined base parameters.
    """
    found = study.rows("parameters", robot=[*study.placeholders])
    if len(found):
        determined = int((found["determined"] == "yes").sum())
        about: Any = {
            "quantity": "base parameters determined",
            "sense": "more",
            "count": determined,
            "of": len(found),
        }
        yield Verdict(
            question=QUESTION, arm=robot, state="not determined", reason="unknown_links", **about
        )
        return
    recorded = len(study.tables["torque_mae"].dropna(subset="mae")) > 0
    reason: Reason = "no_motion" if recorded else "no_reference"
    if compare(study) is not None:
        reason = "too_small"
    yield Verdict(question=QUESTION, arm=robot, state="not determined", reason=reason)


def model_errors(study: StudyTables, robot: str) -> Iterator[ModelError]:
    """Yield the means over recordings by joint, motion and model."""
    rows = study.rows("torque_mae").dropna(subset="mae")
    groups = rows.groupby(["joint", "motion", "model"], sort=False, as_index=False)
    names = ["mae", "mae_2hz", "zero_mae", "zero_mae_2hz"]
    for row in groups[names].mean().to_dict("records"):
        yield ModelError(robot=robot, **{str(name): value for name, value in row.items()})
