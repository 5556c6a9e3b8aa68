"""The page's table of estimators on simulated arms, from results/simulated_contacts.csv."""

import numpy as np
import pandas as pd

from benchmarks.estimators.ours import OURS
from benchmarks.harness.page import interval, markdown, number, share
from ur5lib.force.contact_figures import DRAWS, TAILS
from ur5lib.timeseries.arrays import Array

AT_FLANGE, ELBOW = ("flange", "tool"), ("elbow",)
COLUMNS = ["estimator", "causal", "latency", "RMSE [N]", "RMSE less ours [N]", "in band",
           "interval score [N]", "RMSE at the elbow [N]", "free, median [N]"]  # fmt: skip


def simulated_table(table: pd.DataFrame) -> str:
    """Return a row for each estimator, the smallest error first; intervals: resamples of seeds.

    Estimators that lack any seed are left out.
    """
    seeds = table["seed"].nunique()
    counts = table["estimator"].value_counts()
    names = [name for name in counts.index if counts[name] == seeds]
    drawn = draws(seeds)
    by_name = {name: table[table["estimator"] == name].sort_values("seed") for name in names}
    ours = rmse(by_name[OURS], AT_FLANGE, drawn)
    rows = pd.DataFrame([row(own, drawn, ours) for own in by_name.values()]).sort_values("rmse")
    return markdown(COLUMNS, [cells(own) for _, own in rows.iterrows()])


def draws(seeds: int) -> Array:
    """Return weights (DRAWS + 1, seeds) of resampled seeds; the first are all one."""
    random = np.random.default_rng(0)
    drawn = random.multinomial(seeds, np.full(seeds, 1 / seeds), size=DRAWS)
    return np.vstack([np.ones(seeds), drawn])


def pooled(own: pd.DataFrame, quantity: str, places: tuple[str, ...], drawn: Array) -> Array:
    """Return the mean of a quantity over the samples in contact, of all seeds and resamples."""
    total = sum(own[f"{place}_{quantity}"].to_numpy() for place in places)
    samples = sum(own[f"{place}_samples"].to_numpy() for place in places)
    return np.asarray((drawn @ total) / (drawn @ samples))


def rmse(own: pd.DataFrame, places: tuple[str, ...], drawn: Array) -> Array:
    """Return the RMSE [N] of the force vector in contact."""
    return np.sqrt(pooled(own, "square", places, drawn))


def row(own: pd.DataFrame, drawn: Array, ours: Array) -> dict[str, object]:
    """Return an estimator's figures, with 95 % intervals."""
    found: dict[str, object] = {name: own[name].iloc[0] for name in ("estimator", "causal")}
    found["latency_s"] = own["latency_s"].max()
    error = rmse(own, AT_FLANGE, drawn)
    known = {"rmse": error, "rmse_more": error - ours, "elbow": rmse(own, ELBOW, drawn)}
    if "flange_score" in own and own["flange_score"].notna().all():
        known["score"] = pooled(own, "score", AT_FLANGE, drawn)
        found["inside"] = pooled(own, "inside", AT_FLANGE, drawn)[0]
    for name, values in known.items():
        low, high = np.quantile(values[1:], TAILS)
        found |= {name: values[0], f"{name}_low": low, f"{name}_high": high}
    return found | {"free": own["free"].median()}


def cells(own: pd.Series) -> list[str]:
    """Return an estimator's cells."""
    latency = own["latency_s"]
    difference = "" if own["estimator"] == OURS else interval(own, "rmse_more", sign="+")
    return [
        own["estimator"],
        own["causal"],
        "" if pd.isna(latency) else f"{1000 * latency:.0f} ms",
        interval(own, "rmse"),
        difference,
        share(own.get("inside", np.nan)),
        interval(own, "score"),
        interval(own, "elbow"),
        number(own["free"]),
    ]
