"""Verdicts on the arm's models: links, torque constants, friction and currents, motion."""

from dataclasses import replace
from typing import NamedTuple

import pandas as pd

from ur5lib.report.document import Number, Verdict
from ur5lib.report.formats import SMALLEST_DIFFERENCE
from ur5lib.report.results import Results
from ur5lib.report.sentences import say
from ur5lib.report.tables.models import STOP
from ur5lib.report.verdicts.baseline import HELD, AgainstBaseline, bars
from ur5lib.report.views.currents import unseen

LINKS, CONSTANTS = "Link model", "Torque constants"  # topics
CURRENTS, MOTION = "Friction and currents", "Motion"
CONSTANT = "a constant current"


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
    rows = rows[rows["recording"].isin([*filter(results.moving, rows["recording"].unique())])]
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


def judge_links(results: Results) -> Verdict:
    """Judge the link model that is best on most joints by its worst joint."""
    compared = compare(results)
    if compared is None:
        unknown = results.tables["torque_mae"].dropna(subset="mae").empty
        reason = "no torques" if unknown else "at rest"
        return Verdict(LINKS, "not determined", say(f"models.{reason}"))
    rows = compared.rows[compared.rows["model"] == compared.best[0]]
    against = AgainstBaseline(rows, "mae", "zero_mae", "Nm", 3)
    words = {"model": named(compared.best[0]), "unseen": compared.unseen}
    return Verdict(
        topic=LINKS,
        state=against.state(tested=compared.unseen),
        sentence=say("models.verdict", against=against, **words),
        evidence=say("models.evidence", against=against),
        drawing=against.drawing(),
        caption=say("error.bars", zero="zero torque"),
        numbers=against.numbers("mean absolute error"),
    )


def judge_constants(results: Results) -> Verdict | None:
    """Judge by the constants that the data determine; None where no friction was fitted."""
    rows = results.rows("friction", parameter="torque_constant")
    if len(results.rows("remarks", step=STOP)):
        return Verdict(CONSTANTS, "do not use", say("constants.contradicted"))
    if rows.empty:
        return None
    shares = rows.groupby("joint")["prior_share"].max()
    ratio = rows["value"] / rows["known"]
    farthest = rows.loc[ratio.where(ratio > 1, 1 / ratio).idxmax()]
    determined, refused = rows["determined"] == "yes", rows["contradicted"].notna()
    known, contradicted = ([*rows.loc[where, "joint"].unique()] for where in (determined, refused))
    return Verdict(
        topic=CONSTANTS,
        state="good" if determined.all() and not refused.any() else "usable",
        sentence=say("constants.verdict", known=known, refused=contradicted),
        evidence=say("constants.evidence", row=farthest),
        drawing=bars({str(joint): float(share) for joint, share in shares.items()}),
        caption=say("constants.caption"),
        numbers=(_number(farthest),),
    )


def _number(row: pd.Series) -> Number:
    constant = Number("torque constant", float(row["value"]), "Nm/A", f"joint {row['joint']}")
    return constant.within(row["low"], row["high"], "95 %").beside(
        row["known"], "the known constant"
    )


def judge_currents(results: Results) -> Verdict:
    """Judge the predicted currents by the worst joint, their band by the smallest coverage."""
    rows = unseen(results)
    rows = rows[rows["model"] == "fitted"]
    against = AgainstBaseline(rows, "rmse_2hz", "zero", "A", 2, zero=CONSTANT)
    if against.errors.empty:
        return Verdict(CURRENTS, "not determined", say(f"currents.{_reason(results)}"))
    least = rows.loc[rows["coverage95"].idxmin()]
    held = float(least["coverage95"])
    place = f"joint {least['joint']} on {least['recording']}"
    share = Number("least share in the 95 % band", 100 * held, "%", place)
    return Verdict(
        topic=CURRENTS,
        state=against.state(held),
        sentence=say("currents.verdict", against=against, hold=held >= HELD),
        evidence=say("currents.evidence", against=against, least=least),
        drawing=against.drawing(),
        caption=say("error.bars", zero=CONSTANT),
        numbers=(*against.numbers("RMSE below 2 Hz"), share),
    )


def _reason(results: Results) -> str:
    """Return the name of the sentence on why currents are not judged."""
    if results.tables["friction"].empty:
        return "no friction"
    return "no motion" if results.with_role("validate") else "no validate"


def judge_motion(results: Results) -> Verdict | None:
    """Judge the acceleration from encoders by its worst component; None without an IMU."""
    rows = results.rows("acceleration_mae", estimate="encoders")
    against = AgainstBaseline(rows, "mae", "zero_mae", "m/s²", 3, "component")
    if against.errors.empty:
        return None
    if str(against.worst.name).startswith("r"):
        against = replace(against, unit="rad/s²")
    return Verdict(
        topic=MOTION,
        state=against.state(),
        sentence=say("motion.verdict", against=against),
        evidence=say("motion.evidence", against=against),
        drawing=against.drawing(),
        caption=say("motion.caption"),
        numbers=against.numbers("mean absolute error"),
    )
