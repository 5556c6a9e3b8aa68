"""The page's table of predicted currents, from results/current_prediction.csv."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from ur5lib.leaderboard.tables import markdown, number

OURS, LEAST_SQUARES, CONSTANT, FLOOR = "ours", "least squares", "constant", "repeats"
FIGAROH = {"ols": "FIGAROH", "wls": "FIGAROH, weighted"}
MODELS = [CONSTANT, LEAST_SQUARES, *FIGAROH.values(), OURS]
DIGITS = 3


def pooled(table: pd.DataFrame, keys: Sequence[str]) -> pd.Series:
    """Return the root of the mean square [A], each recording with its time, by keys."""
    weighted = table.assign(square=table["square"] * table["seconds"])
    sums = weighted.groupby([*keys], sort=False)[["square", "seconds"]].sum()
    return np.sqrt(sums["square"] / sums["seconds"])


def prediction_table(table: pd.DataFrame) -> str:
    """Return a row for each arm and joint: errors in motion, at rest, and between repeats."""
    models = [own for own in MODELS if own in {*table["model"]}]
    rest = [own for own in models if own != CONSTANT]
    figures = pooled(table, ["arm", "joint", "during", "model"]).sort_index()
    rows = []
    for arm, joint in table[["arm", "joint"]].drop_duplicates().itertuples(index=False):
        own = figures[arm, joint]
        cells = [own.get((during, model)) for during, names in (("motion", models), ("rest", rest))
                 for model in names]  # fmt: skip
        cells += [own.get(("repeat", model)) for model in (OURS, FLOOR)]
        rows.append([str(arm), str(joint), *(number(cell, DIGITS) for cell in cells)])
    columns = [*models, *(f"{own}, at rest" for own in rest), "ours, repeated paths", "floor"]
    return markdown(["arm", "joint", *columns], rows)


def prediction_findings(table: pd.DataFrame) -> Iterator[str]:
    """Yield, for each arm, on which joints another is lower, and how far the floor is."""
    for arm, own in table.groupby("arm", sort=False):
        paths = own[own["during"] != "repeat"]["path"].nunique()
        figures = {during: by_model(part) for during, part in own.groupby("during", sort=False)}
        parts = [beside(figures[during], when) for during, when in WHEN.items()]
        if "repeat" in figures:
            share = (figures["repeat"][FLOOR] / figures["repeat"][OURS]).mean()
            parts.append(f"What does not repeat is {share:.0%} of our error on repeated paths.")
        else:
            parts.append("No path was repeated.")
        yield f"{arm}, {paths} paths: {' '.join(parts)}"


def by_model(table: pd.DataFrame) -> pd.DataFrame:
    """Return the RMSE [A] of each joint, a column each model."""
    figures = pooled(table, ["joint", "model"]).reset_index(name="rmse")
    return figures.pivot_table("rmse", index="joint", columns="model")


WHEN = {"motion": "In motion", "rest": "At rest"}


def beside(figures: pd.DataFrame, when: str) -> str:
    """Return how ours compares with each other model; figures: RMSE [A] of joints by model."""
    parts = []
    for model in [own for own in (LEAST_SQUARES, *FIGAROH.values()) if own in figures]:
        ratio = figures[OURS] / figures[model]
        worse = [str(joint) for joint in ratio.index[ratio > 1]]
        where = f"higher on joint {', '.join(worse)}" if worse else "higher on no joint"
        parts.append(f"{ratio.mean():.0%} of {model} ({where})")
    return f"{when}, our error is {', '.join(parts)}."
