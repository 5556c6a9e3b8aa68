"""Closed loop: errors of positions and velocities, and gains."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.report.cells import number, significant
from ur5lib.report.document import Cell
from ur5lib.report.reference import OLDER_MODEL
from ur5lib.report.results import Body, Results
from ur5lib.report.sentences import Sentence, say


def printed(results: Results) -> list[str]:
    """Return the recordings with printed errors of the closed loop."""
    return results.printed("closed_loop_mae")


def drawn(results: Results) -> list[str]:
    """Return the recordings whose closed loop is drawn."""
    recordings = [*results.tables["closed_loop_mae"]["recording"].unique()]
    validated = [name for name in results.with_role("validate") if name in recordings]
    return results.shown(printed(results)) or results.shown([*validated, *recordings], 1)


def older(results: Results) -> list[str]:
    """Return the recordings on which the closed loop of the older model is drawn."""
    return results.shown([*results.rows("torque_mae", model=OLDER_MODEL)["recording"]])


def positions(results: Results, recording: str) -> Body:
    """Return the positions of Table 5.5."""
    return _errors(results.rows("closed_loop_mae", recording=recording, quantity="q"), 5)


def velocities(results: Results, recording: str) -> Body:
    """Return the velocities of Table 5.5."""
    return _errors(results.rows("closed_loop_mae", recording=recording, quantity="qd"), 4)


def _errors(rows: pd.DataFrame, digits: int) -> Body:
    """Return printed and rebuilt errors, and those of the estimated gains and the targets."""
    part = rows.set_index(["model", "joint"])
    models = part.index.unique("model")
    printed = [model for model in models if part.loc[model, "printed"].notna().any()]
    header = [f"{model} {what}" for model in printed for what in ("printed", "rebuilt")]
    others = [model for model in models if model not in printed]
    body = []
    for joint in range(1, 7):
        line = [Cell(str(joint))]
        for model in printed:
            row = part.loc[(model, joint)]
            line += [number(row["printed"], 4), number(row["mae"], digits)]
        body.append(line + [number(part.loc[(model, joint), "mae"], digits) for model in others])
    return Body(["joint", *header, *others], body)


def gains(results: Results) -> Body:
    """Return the estimated gains of each recording."""
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


def contradictions(results: Results) -> Iterator[Sentence]:
    """Report the joints on which no gain lies in the ranges of all recordings of an arm."""
    ranges = results.tables["gains"].fillna({"low": 0.0, "high": np.inf})
    ranges["robot"] = ranges["recording"].map(results.arms())
    for (robot, gain), rows in ranges.groupby(["robot", "gain"], sort=False):
        by_joint = rows.groupby("joint")
        disjoint = by_joint["low"].max() > by_joint["high"].min()
        if disjoint.any():
            words = {"gain": gain, "robot": robot, "numbers": disjoint.index[disjoint]}
            yield say("loop.contradiction", **words)


def published_gains(results: Results) -> Iterator[Sentence]:
    """Report on how many joints and recordings published gains fit as well as the best."""
    published = results.tables["published_gains"]
    parts = [
        say("loop.fits", model=model, fits=int((rows["fits"] == "yes").sum()), count=len(rows))
        for model, rows in published.groupby("model", sort=False)
    ]
    if parts:
        yield say("loop.published", parts=parts)
