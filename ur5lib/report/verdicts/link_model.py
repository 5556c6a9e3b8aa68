"""How close a link model is to the controller's torques."""

from typing import NamedTuple

import pandas as pd

from ur5lib.report.cells import SMALLEST_DIFFERENCE
from ur5lib.report.document import Verdict
from ur5lib.report.results import Results
from ur5lib.report.sentences import say
from ur5lib.report.verdicts.errors import AgainstBaseline, by_joint, largest

TOPIC = "Link model"


class Comparison(NamedTuple):
    """Errors of the link models at one motion, on recordings in which the arm moves.

    rows: of torque_mae.csv; unseen: whether no fit has seen these recordings; best: the models
    that are closest on most joints; near: number of these joints; differ: number of joints on
    which the models differ.
    """

    rows: pd.DataFrame
    unseen: bool
    best: list[str]
    near: int
    differ: int


def compare(results: Results) -> Comparison | None:
    """Compare the link models, on unseen recordings if possible; None without a motion."""
    rows = results.rows("torque_mae").dropna(subset="mae")
    rows = rows[rows["recording"].map(lambda name: bool(results.moving(name)))]
    if rows.empty:
        return None
    unseen = rows[~rows["recording"].isin(results.with_role("fit"))]
    rows = unseen if len(unseen) else rows
    rows = rows[rows["motion"] == rows["motion"].iloc[0]]
    mean = rows.pivot_table("mae", "joint", "model", aggfunc="mean")
    close = near_the_best(mean)
    counts = close.sum()
    best = [*counts[counts == counts.max()].index]
    return Comparison(rows, len(unseen) > 0, best, int(counts.max()), len(close))


def near_the_best(mean: pd.DataFrame) -> pd.DataFrame:
    """Return whether a model (column) equals the best one, on joints (rows) where they differ."""
    above = mean.sub(mean.min(axis="columns"), axis="index")
    return above[above.max(axis="columns") > SMALLEST_DIFFERENCE] <= SMALLEST_DIFFERENCE


def named(model: str) -> str:
    """Return a model's name as used in sentences: Model C, the model “identified”."""
    return f"Model {model}" if model[0].isupper() else f"the model “{model}”"


def verdict(results: Results) -> Verdict:
    """Judge the best model by its worst joint."""
    compared = compare(results)
    if compared is None:
        return Verdict(TOPIC, "not determined", say(f"models.{_reason(results)}"))
    best = compared.best[0]
    rows = compared.rows[compared.rows["model"] == best]
    errors, most = by_joint(rows, "mae", "zero_mae"), largest(rows, "mae", "zero_mae")
    against = AgainstBaseline(errors, most, "Nm", 3)
    words = {"joint": against.worst, "percent": against.percent(), "shown": against.shown()}
    words |= {"model": named(best), "unseen": compared.unseen, "largest": against.largest_shown()}
    return Verdict(
        topic=TOPIC,
        state=against.state(tested=compared.unseen),
        sentence=say("models.verdict", **words),
        evidence=say("models.evidence", **words),
        drawing=against.drawing(),
        caption=say("error.bars", zero="zero torque"),
        numbers=against.numbers("mean absolute error"),
    )


def _reason(results: Results) -> str:
    """Return the name of the sentence on why no link model is judged."""
    unknown = results.tables["torque_mae"].dropna(subset="mae").empty
    return "no torques" if unknown else "at rest"
