"""Closed loop: errors of positions and velocities, and gains."""

from collections.abc import Iterator

import numpy as np

from ur5lib.report.reference import OLDER_MODEL
from ur5lib.report.results import Results
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
