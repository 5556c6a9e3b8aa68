"""Estimates compared with the truth of simulated recordings."""

import pandas as pd

from ur5lib.report.results import Results, with_zero
from ur5lib.report.sentences import names


def summary(results: Results) -> pd.DataFrame:
    """Return how many stated intervals contain the truth, by quantity."""
    stated = results.rows("truth").dropna(subset="within95")
    groups = stated.assign(inside=stated["within95"] == "yes").groupby("quantity", sort=False)
    return groups["inside"].agg(values="size", inside="sum").reset_index()


def fitted(results: Results) -> pd.DataFrame:
    """Return the values fitted to several recordings, without base parameters."""
    rows = _single(results)
    return rows[rows["recording"].isna() & (rows["quantity"] != "base_parameter")]


def clocks(results: Results) -> pd.DataFrame:
    """Return the devices' clocks."""
    rows = _single(results)
    return rows[rows["recording"].notna()]


def _single(results: Results) -> pd.DataFrame:
    rows = results.rows("truth")
    return rows[rows["quantity"].isin(names("truth"))]


def series(results: Results) -> pd.DataFrame:
    """Return the errors over time, those of an estimate of zero after the methods'."""
    rows = results.rows("truth")
    rows = rows[rows["recording"].notna()].assign(value=rows["estimate"])
    return with_zero(rows, "method", ["quantity", "index"])
