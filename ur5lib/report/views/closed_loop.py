"""The closed loop: errors of positions and velocities, and gains."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.report.cells import joints, number, significant
from ur5lib.report.document import Cell
from ur5lib.report.results import Body, Results, shown


def printed(results: Results) -> list[str]:
    """Recordings with printed errors of the closed loop."""
    return results.printed("closed_loop_mae")


def drawn(results: Results) -> list[str]:
    """Recordings whose closed loop is drawn."""
    known = [*results.tables["closed_loop_mae"]["recording"].unique()]
    validated = [name for name in results.with_role("validate") if name in known]
    return shown(printed(results) or validated[:1] or known[:1])


def positions(results: Results, of: str) -> Body:
    """Table 5.5, positions."""
    return _errors(results.rows("closed_loop_mae", recording=of, quantity="q"), 5)


def velocities(results: Results, of: str) -> Body:
    """Table 5.5, velocities."""
    return _errors(results.rows("closed_loop_mae", recording=of, quantity="qd"), 4)


def _errors(rows: pd.DataFrame, digits: int) -> Body:
    """Printed and rebuilt, the estimated gains and the targets beside them."""
    part = rows.set_index(["model", "joint"])
    models = part.index.unique("model")
    known = [model for model in models if part.loc[model, "printed"].notna().any()]
    header = [f"{model} {what}" for model in known for what in ("printed", "rebuilt")]
    others = [model for model in models if model not in known]
    body = []
    for joint in range(1, 7):
        line = [Cell(str(joint))]
        for model in known:
            row = part.loc[(model, joint)]
            line += [number(row["printed"], 4), number(row["mae"], digits)]
        body.append(line + [number(part.loc[(model, joint), "mae"], digits) for model in others])
    return Body(["joint", *header, *others], body)


def gains(results: Results) -> Body:
    """The estimated gains of each recording."""
    rows = results.tables["gains"]
    body = [
        [Cell(recording), Cell(gain), *(_gain(row) for row in part.itertuples())]
        for (recording, gain), part in rows.groupby(["recording", "gain"], sort=False)
    ]
    return Body(["recording", "gain", *(f"joint {j}" for j in range(1, 7))], body)


def _gain(row: pd.Series) -> Cell:
    low, high = (significant(end, 2) for end in (row.low, row.high))
    if row.determined == "yes":
        return Cell(f"{significant(row.value, 2)} ({low}–{high})")
    if pd.isna(row.low) and pd.isna(row.high):
        return Cell("any")
    if pd.isna(row.high):
        return Cell(f"> {low}")
    if pd.isna(row.low):
        return Cell(f"< {high}")
    return Cell(f"{low}–{high}")


def contradictions(results: Results) -> Iterator[str]:
    """On which joints no one gain lies in the ranges of all recordings of an arm."""
    ranges = results.tables["gains"].fillna({"low": 0.0, "high": np.inf})
    arms = {each["name"]: each["robot"] for each in results.study["recordings"]}
    ranges["robot"] = ranges["recording"].map(arms)
    for (robot, gain), rows in ranges.groupby(["robot", "gain"], sort=False):
        each = rows.groupby("joint")
        apart = each["low"].max() > each["high"].min()
        if apart.any():
            yield (
                f"No one {gain} gain lies in the ranges of all recordings of {robot} on "
                f"{joints(apart.index[apart])}: its loop is not this one there."
            )


def published_gains(results: Results) -> Iterator[str]:
    """On how many joints of how many recordings published gains fit as well as the best."""
    published = results.tables["published_gains"]
    parts = [
        f"{model} on {int((rows['fits'] == 'yes').sum())} of {len(rows)}"
        for model, rows in published.groupby("model", sort=False)
    ]
    if parts:
        yield (
            "The published gains fit as well as the best ones do, counted over joints and "
            f"recordings: {', '.join(parts)}."
        )
