"""Link models, their torques compared with the controller's, and the verdict."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import pandas as pd

from ur5lib.records.quality import GIVEN_LOAD, MAX_SHARE_UNMODELLED
from ur5lib.report.page.document import Number, Verdict
from ur5lib.report.page.formats import VISIBLE_DIFFERENCE
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.arms import of_each_arm
from ur5lib.report.views.baseline import BETTER_RIVAL_RATIO, AgainstBaseline, Rival
from ur5lib.report.views.currents import (
    CONSTANTS,
    EXPLAINED,
    by_joint,
    contradicting,
    is_far,
    loaded,
)

LINKS_TOPIC = "Link model"  # topic
MIN_LINK_SKILL = 1 - MAX_SHARE_UNMODELLED  # least skill of a good link model


def compared(results: Results) -> list[str]:
    """Return recordings with a table of torques: printed errors, and validate recordings."""
    judged = [*results.tables["torque_mae"].dropna(subset="mae")["recording"].unique()]
    others = results.with_role("validate", judged)
    return results.shown([*results.printed("torque_mae"), *others]) or results.shown(judged, 1)


def mean_errors(results: Results) -> pd.DataFrame:
    """Return the means over recordings by joint, motion and model."""
    rows = results.tables["torque_mae"].dropna(subset="mae")
    groups = rows.groupby(["joint", "motion", "model"], sort=False, as_index=False)
    return groups[["mae", "zero_mae"]].mean()


def advice(results: Results) -> Iterator[str]:
    """Return advice on what to record to determine more of an arm."""
    for row in results.tables["excitation"].dropna(subset="advice").itertuples():
        yield say("models.advice", row=row)


def identified(results: Results) -> Iterator[str]:
    """Report how many parameters of an arm the recordings determine."""
    for robot, parameters in results.tables["parameters"].groupby("robot", sort=False):
        determined = int((parameters["determined"] == "yes").sum())
        words = {"determined": determined, "count": len(parameters)}
        measured = robot in results.placeholders
        yield say("models.identified", robot=robot, measured=measured, **words)
        if determined < len(parameters):
            yield say("models.undetermined")
        yield say("models.files", robot=robot)


class ModelComparison(NamedTuple):
    """Errors of the link models at one motion, on recordings in which the arm moves.

    rows: of torque_mae.csv; unseen: whether no fit has seen these recordings; ranked: the models,
    those that are closest, or hardly farther, on most joints first, of equal ones that with the
    least errors; best: the first of these that are equal; near: number of their joints; differ:
    number of joints on which the models differ.
    """

    rows: pd.DataFrame
    unseen: bool
    ranked: list[str]
    best: list[str]
    near: int
    differ: int


def compare(results: Results) -> ModelComparison | None:
    """Compare the link models, on unseen recordings if possible; None without a motion."""
    rows = results.rows("torque_mae").dropna(subset="mae")
    rows = rows[rows["recording"].isin([*filter(results.moving, rows["recording"].unique())])]
    if rows.empty:
        return None
    unseen = rows[~rows["recording"].isin(results.with_role("fit"))]
    rows = unseen if len(unseen) else rows
    rows = rows[rows["motion"] == rows["motion"].iloc[0]]
    mean = rows.pivot_table("mae_2hz", "joint", "model", aggfunc="mean")
    above = mean.sub(mean.min(axis="columns"), axis="index")
    equal = (above <= VISIBLE_DIFFERENCE) | (above <= (1 - BETTER_RIVAL_RATIO) * mean)
    close = equal[above.max(axis="columns") > VISIBLE_DIFFERENCE]
    counts = close.sum()
    ranked = sorted(counts.index, key=lambda model: (-counts[model], float(above[model].sum())))
    best = ranked[: int((counts == counts.max()).sum())]
    return ModelComparison(rows, len(unseen) > 0, ranked, best, int(counts.max()), len(close))


def named(model: str) -> str:
    """Return a model's name as used in sentences: Model C, the model “identified”."""
    return f"Model {model}" if model[0].isupper() else f"the model “{model}”"


def beside_zero(results: Results, compared: ModelComparison) -> AgainstBaseline:
    """Return the errors of the model that is closest on most joints, beside zero torque's."""
    rows = compared.rows[compared.rows["model"] == compared.best[0]]
    floors = results.floors("torque")
    return AgainstBaseline(rows, "mae_2hz", "zero_mae_2hz", "Nm", floors=floors)


def next_model(compared: ModelComparison) -> Rival | None:
    """Return the errors of the model that comes next, None without one: it is told beside a
    verdict, which it does not decide, as both may be right.
    """
    if len(compared.ranked) < 2:
        return None
    first, second = compared.ranked[:2]
    models = {first: "ours", second: "rival"}
    return Rival.beside(named(second), compared.rows, "mae_2hz", "joint", models)


def decided(results: Results) -> pd.DataFrame:
    """Return the errors by which the link model of each arm is judged, by joint, beside those of
    the model that comes next (`second`).
    """

    def of_arm(own: Results) -> pd.DataFrame:
        compared = compare(own)
        if compared is None:
            return pd.DataFrame()
        first, *others = compared.ranked
        means = compared.rows.pivot_table("mae_2hz", "joint", "model")
        table = beside_zero(own, compared).by_place().assign(model=first, second=None)
        return table.assign(second=others[0], second_mae=means[others[0]]) if others else table

    return of_each_arm(results, of_arm)


def without_targets(results: Results) -> Verdict:
    """Return the verdict where the controller told no torques to compare: links that were found
    from measured torques have no rival but in the torques that they predict.
    """
    found = results.rows("parameters", robot=[*results.placeholders])
    if found.empty:
        words, answers = say("models.no torques"), tuple(arm_itself(results))
        return Verdict(LINKS_TOPIC, "not determined", words, answers)
    determined = int((found["determined"] == "yes").sum())
    return Verdict(
        LINKS_TOPIC,
        "not determined",
        say("models.from measured torques", determined=determined, count=len(found)),
        numbers=(Number("base parameters determined", determined, f"of {len(found)}"),),
    )


def judge_links(results: Results) -> Verdict:
    """Judge the link model that is best on most joints by its worst joint, below 2 Hz: gravity,
    which is most of that, is known far better than by half.
    """
    compared = compare(results)
    if compared is None:
        if results.tables["torque_mae"].dropna(subset="mae").empty:
            return without_targets(results)
        return Verdict(LINKS_TOPIC, "not determined", say("models.at rest"))
    against = beside_zero(results, compared)
    rows = against.rows
    loads = results.rows("quality", finding=GIVEN_LOAD, recording=[*rows["recording"].unique()])
    words = {"model": named(compared.best[0]), "unseen": compared.unseen, "loads": loads}
    words["motion"] = rows["motion"].iloc[0].replace("_", " ")
    beside = replace(against, rival=next_model(compared))
    return Verdict(
        topic=LINKS_TOPIC,
        state=against.state(tested=compared.unseen and loads.empty, better=MIN_LINK_SKILL),
        sentence=beside.after(say("models.verdict", against=against, **words)),
        answers=tuple(arm_itself(results)),
        evidence=say("models.evidence", against=beside),
        numbers=against.numbers("mean absolute error below 2 Hz"),
    )


def arm_itself(results: Results) -> Iterator[str]:
    """Say whether gravity agrees with arm, mounting and payload: by the constants of the joints
    that bear it, beside the known ones, and by the load on the flange.
    """
    rows = by_joint(results)
    rows = rows[rows["parameter"].isin(CONSTANTS)]
    if rows.empty or results.stopped():
        return
    bearing = {joint for own in results.robots() for joint in results.bearing.get(own, ())}
    rows = rows.assign(off=(rows["value"] / rows["known"] - 1).abs())
    told = rows["joint"].isin(bearing) & rows["use"].isin(["yes", "far", "unlikely"])
    against = rows["joint"].isin(bearing) & rows["contradicted"].notna()
    far = told & is_far(rows) & ~against
    groups = {"near": told & ~far & ~against, "far": far, "against": against}
    untold = sorted({*rows["joint"]} - {*rows.loc[told | against, "joint"]})
    words: dict[str, Any] = {name: rows[which] for name, which in groups.items()}
    explained = {*results.rows("remarks", code=EXPLAINED)["joint"]}
    words["explained"] = not explained.isdisjoint(words["against"]["joint"])
    words["doubted"] = [j for j in contradicting(results) if j in untold and j not in explained]
    words |= {"declared": _declared_loads(results), "carrying": loaded(results)}
    yield say("models.arm", **words, untold=untold)


def _declared_loads(results: Results) -> pd.DataFrame:
    """Return the recordings without contact whose load is determined within what the arm carries:
    half of its 95 % interval [kg], and whether this holds the declared load.
    """
    names = [*results.with_role("fit"), *results.with_role("validate")]
    rows = results.rows("payload", taken="no", recording=names)
    rows = rows.assign(half=(rows["high"] - rows["low"]) / 2)
    rows = rows.assign(holds=(rows["low"] <= 0) & (rows["high"] >= 0))
    return rows[rows["half"] < max(results.loads.values(), default=0.0)]
