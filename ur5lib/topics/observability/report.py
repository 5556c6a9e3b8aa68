"""The report's part on what can be observed: smallest pushes, and at which speeds bands hold."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results


def smallest_pushes(results: Results) -> pd.DataFrame:
    """Return the smallest pushes [N] that trials find, or did not find."""
    rows = results.rows("pushes")
    return rows[rows["value"].notna() | rows["bound"].eq(">")]


def tried(results: Results) -> Iterator[str]:
    """Say how long a trial push lasts, of which arms no push is stated, and of which those are that
    were tried on fit recordings alone.
    """
    rows = results.rows("pushes")
    for seconds in smallest_pushes(results)["seconds"].unique():
        yield say("observability.tried", seconds=seconds)
    rows = rows[rows["reason"].isin(["one_path", "fitted"])]
    for robot, reason in dict.fromkeys(zip(rows["robot"], rows["reason"], strict=True)):
        yield say(f"observability.{reason}", robot=robot)


def bands(results: Results, robot: str) -> Iterator[str]:
    """Say how many readings of an arm's resting joints the bands contain, by how much they are too
    wide, and at which speed of which joint they contain least.
    """
    observed = results.rows("observability", robot=robot)
    wider, held, factors = (
        _values(observed[observed["speed_low"] == 0], name)
        for name in ("band_at_rest", "friction_in_band", "rest_band_factor")
    )
    if len(wider):
        ends = {"least": factors.min(), "most": factors.max(), "wider": wider}
        yield say("observability.at rest", held=held, **ends)
    speeds = observed[observed["quantity"] == "friction_in_band"].dropna(subset="value")
    for row in speeds.sort_values("value", kind="stable")[:1].itertuples():
        yield say("observability.by speed", row=row)


def _values(rows: pd.DataFrame, quantity: str) -> pd.Series:
    """Return the known values of a quantity."""
    return rows.loc[rows["quantity"] == quantity, "value"].dropna().astype(float)
