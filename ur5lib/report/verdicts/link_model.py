"""How close a link model is to the controller's torques."""

from typing import NamedTuple

import pandas as pd

from ur5lib.report.cells import SMALLEST_DIFFERENCE, sentence
from ur5lib.report.document import Verdict
from ur5lib.report.results import Results
from ur5lib.report.verdicts.drawings import bars
from ur5lib.report.verdicts.errors import (
    by_joint,
    largest,
    on_recording,
    percent,
    ratios,
    stated,
    stated_largest,
    with_range,
    worst,
)
from ur5lib.report.verdicts.states import state

TOPIC = "Link model"


class Comparison(NamedTuple):
    """Errors of the link models at one motion, on recordings in which the arm moves.

    rows: of torque_mae.csv; unseen: whether no fit has seen these recordings; best: the models
    that are closest on most joints; near: on how many of the joints where models differ.
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
        return Verdict(TOPIC, "not determined", _undetermined(results))
    best = compared.best[0]
    rows = compared.rows[compared.rows["model"] == best]
    errors = by_joint(rows, "mae", "zero_mae")
    joint, most = worst(errors), largest(rows, "mae", "zero_mae")
    where = "recordings that no fit has seen" if compared.unseen else "the fit recordings alone"
    judged = state(errors["error"][joint], errors["zero"][joint], tested=compared.unseen)
    return Verdict(
        topic=TOPIC,
        state=judged,
        sentence=sentence(
            f"{named(best)} differs from the controller's torques by {percent(errors, joint)} of "
            f"their mean size on joint {joint} (the worst), on {where}"
        ),
        evidence=f"Joint {joint}: {with_range(errors.loc[joint], 3, 'Nm')}. "
        f"{on_recording(most, 3, 'Nm', 'on joint')}",
        drawing=bars(ratios(errors)),
        caption="Error by joint; a full bar is the error of zero torque.",
        numbers=(
            stated(errors.loc[joint], "mean absolute error", "Nm", f"joint {joint}"),
            stated_largest(most, "Nm", f"joint {most['place']}"),
        ),
    )


def _undetermined(results: Results) -> str:
    if results.tables["torque_mae"].dropna(subset="mae").empty:
        return "No recording has the controller's torques (target_moment)."
    return "The arm rests in every recording, which does not tell link models apart."
