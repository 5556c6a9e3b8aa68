"""What the health of joints adds to the steps: a fit to recordings after the largest change."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.results import Results
from ur5lib.report.stated import Step, day

TABLES = ("health_changes",)


def advice(results: Results) -> Iterator[Step]:
    """Ask for a fit to the recordings after the largest change."""
    rows = ranked(results)
    for row in rows[rows["share"] > 0][:1].itertuples():
        quantity = f"{_name(results, row.quantity)} of joint {row.joint}"
        since, changed = "the latest recordings", "drifts"
        if row.kind == "jump":
            since, changed = f"recordings since {day(row.last)}", "changed"
        sentence = f"Fit {row.robot} only to {since}: {quantity} {changed}."
        yield Step(sentence, "role: validate")


def ranked(results: Results) -> pd.DataFrame:
    """Return the changes, the largest relative to the value before first; offsets last."""
    rows = results.tables["health_changes"]
    share = (rows["size"] / rows["before"]).abs().mask(rows["quantity"] == "offset", 0.0)
    return rows.assign(share=share).sort_values("share", ascending=False, kind="stable")


def _name(results: Results, quantity: str) -> str:
    """Return a quantity of a joint in words."""
    names = {"coulomb": "Coulomb friction", "viscous": "viscous friction"}
    names |= {"noise": f"noise of the {results.effort.quantity}"}
    return names.get(quantity, quantity.replace("_", " "))
