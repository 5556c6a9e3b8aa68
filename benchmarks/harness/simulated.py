"""The page's table of estimators on simulated arms, from results/simulated_contacts.csv."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.harness.markdown import markdown
from ur5lib.force.contact_figures import CONTACT_RESAMPLES, INTERVAL_ENDS
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimators.ours import OURS
from ur5rivals.tables import interval, number, share

LINK_6 = ("flange", "tool")  # places on the last link, where estimators assume contacts
COLUMNS = ["estimator", "causal", "latency", "RMSE at the flange [N]",
           "RMSE at the tool [N]", "in band", "interval score [N]",
           "RMSE at the elbow [N]", "free, median [N]"]  # fmt: skip


def simulated_table(table: pd.DataFrame) -> str:
    """Return a row for each estimator, the smallest error first."""
    return markdown(COLUMNS, [cells(own) for _, own in compared(table).iterrows()])


def better_than_ours(table: pd.DataFrame) -> Iterator[str]:
    """Yield the estimators that are significantly better than ours, by place."""
    rows = compared(table)
    for place in LINK_6:
        better = rows[rows[f"{place}_more_high"] < 0]
        named = [
            f"{own['estimator']} by {interval(own, f'{place}_more')} N"
            for _, own in better.iterrows()
        ]
        if named:
            yield f"at the {place}: {'; '.join(named)}"


def refused_on_some(table: pd.DataFrame) -> list[str]:
    """Return the estimators that ran on only some seeds, with the number of missing ones."""
    lack = table["flange_square"].isna().groupby(table["estimator"]).agg(["sum", "size"])
    some = lack[(lack["sum"] > 0) & (lack["sum"] < lack["size"])]
    return [f"{name} on {missing} of {seeds}" for name, missing, seeds in some.itertuples()]


def compared(table: pd.DataFrame) -> pd.DataFrame:
    """Return the figures of each estimator, the smallest error first.

    Intervals are from resamples of seeds. Estimators that lack any seed are left out.
    """
    seeds = table["seed"].nunique()
    table = table.dropna(subset="flange_square")
    counts = table["estimator"].value_counts()
    names = [name for name in counts.index if counts[name] == seeds]
    drawn = draws(seeds)
    by_name = {name: table[table["estimator"] == name].sort_values("seed") for name in names}
    ours = {place: rmse(by_name[OURS], place, drawn) for place in LINK_6}
    rows = pd.DataFrame([row(own, drawn, ours) for own in by_name.values()])
    return rows.sort_values("flange")


def draws(seeds: int) -> Array:
    """Return weights (CONTACT_RESAMPLES + 1, seeds) of resampled seeds; the first are all one."""
    random = np.random.default_rng(0)
    drawn = random.multinomial(seeds, np.full(seeds, 1 / seeds), size=CONTACT_RESAMPLES)
    return np.vstack([np.ones(seeds), drawn])


def pooled(own: pd.DataFrame, quantity: str, places: tuple[str, ...], drawn: Array) -> Array:
    """Return the mean of a quantity over the samples in contact, of all seeds and resamples."""
    total = sum(own[f"{place}_{quantity}"].to_numpy() for place in places)
    samples = sum(own[f"{place}_samples"].to_numpy() for place in places)
    return np.asarray((drawn @ total) / (drawn @ samples))


def rmse(own: pd.DataFrame, place: str, drawn: Array) -> Array:
    """Return the RMSE [N] of the force vector while a place is touched."""
    return np.sqrt(pooled(own, "square", (place,), drawn))


def row(own: pd.DataFrame, drawn: Array, ours: Mapping[str, Array]) -> dict[str, Any]:
    """Return an estimator's figures, with 95 % intervals."""
    found: dict[str, Any] = {name: own[name].iloc[0] for name in ("estimator", "causal")}
    found["latency_s"] = own["latency_s"].max()
    known = {"elbow": rmse(own, "elbow", drawn)}
    for place, reference in ours.items():
        known[place] = rmse(own, place, drawn)
        known[f"{place}_more"] = known[place] - reference
    if "flange_score" in own and own["flange_score"].notna().all():
        known["score"] = pooled(own, "score", LINK_6, drawn)
        found["inside"] = pooled(own, "inside", LINK_6, drawn)[0]
    for name, values in known.items():
        low, high = np.quantile(values[1:], INTERVAL_ENDS)
        found |= {name: values[0], f"{name}_low": low, f"{name}_high": high}
    return found | {"free": own["free"].median()}


def cells(own: pd.Series) -> list[str]:
    """Return an estimator's cells."""
    latency = own["latency_s"]
    return [
        own["estimator"],
        own["causal"],
        "" if pd.isna(latency) else f"{1000 * latency:.0f} ms",
        *(interval(own, place) for place in LINK_6),
        share(own.get("inside", np.nan)),
        interval(own, "score"),
        interval(own, "elbow"),
        number(own["free"]),
    ]
