"""Published torque constants and offsets: rebuilt, and the same regression on other recordings."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.report.cells import number, with_error
from ur5lib.report.document import Cell
from ur5lib.report.results import Body, Results
from ur5lib.report.sentences import Sentence, say
from ur5lib.report.tables.friction import AS_PRINTED

PARAMETERS = {"torque_constant": "k", "offset": "b"}


def printed(results: Results) -> list[str]:
    """Return the recordings with printed torque constants."""
    return results.printed("torque_constants", "printed_offset")


def rebuilt(results: Results, recording: str) -> Body:
    """Return Equation 6.5: printed, rebuilt, and by this study's fit with all friction terms."""
    rows = results.rows("torque_constants", recording=recording, regression=AS_PRINTED)
    right = _fitted(results, recording)
    body = []
    for row in rows.to_dict("records"):
        line = [Cell(str(row["joint"]))]
        for name in PARAMETERS:
            fitted = right.loc[(row["joint"], name)]
            line += [
                number(row[f"printed_{name}"], 3),
                with_error(row[name], row[f"{name}_std_error"], 3),
                with_error(fitted["value"], fitted["std_error"], 2),
            ]
        body.append(line)
    header = [f"{sign} {what}" for sign in PARAMETERS.values() for what in KINDS]
    return Body(["joint", *header], body)


KINDS = ("printed", "rebuilt", "fitted here")


def _fitted(results: Results, recording: str) -> pd.DataFrame:
    """Return the parameters fitted to the arm of a recording, by joint and parameter."""
    rows = results.rows("friction", robot=results.arms()[recording])
    return rows.set_index(["joint", "parameter"])


def doubted_joint(results: Results, recording: str) -> int:
    """Return the joint whose printed offset is furthest from this study's fit."""
    rows = results.rows("torque_constants", recording=recording, regression=AS_PRINTED)
    here = _fitted(results, recording).xs("offset", level="parameter")["value"]
    away = (rows.set_index("joint")["printed_offset"] - here).abs()
    return int(away.idxmax())


def on_every_run(results: Results, recording: str) -> Body:
    """Return k and b of the doubted joint by both regressions on every recording in which it
    moves, in the order of its mean torque.
    """
    rows = results.rows("torque_constants", joint=doubted_joint(results, recording))
    body = []
    for (_, recording), pair in rows.groupby(["mean_torque", "recording"]):
        lines = pair.set_index("regression")
        forward, reverse = (lines.loc[name] for name in (AS_PRINTED, "current_on_torque"))
        body.append([
            Cell(recording),
            number(forward["mean_torque"], 1),
            *(with_error(line[name], line[f"{name}_std_error"], 1)
              for name in reversed(PARAMETERS) for line in (forward, reverse)),
        ])  # fmt: skip
    columns = [
        f"{sign}, {way}"
        for sign in ("b", "k")
        for way in ("torque on current", "current on torque")
    ]
    return Body(["recording", "mean torque [Nm]", *columns], body)


def follows_the_mean(results: Results, recording: str) -> Iterator[Sentence]:
    """Report that offsets follow the mean torque from run to run, beside the printed offset."""
    rows = results.rows("torque_constants", regression=AS_PRINTED)
    joint = doubted_joint(results, recording)
    doubted = rows[rows["joint"] == joint]
    fitted = _fitted(results, recording).loc[(joint, "offset")]
    (printed,) = doubted.loc[doubted["recording"] == recording, "printed_offset"]
    correlation = [
        np.corrcoef(part["offset"], part["mean_torque"])[0, 1] for _, part in rows.groupby("joint")
    ]
    words = {"joint": joint, "printed": printed, "offsets": doubted["offset"], "fitted": fitted}
    yield say("constants.follow the mean", correlation=correlation, **words)


def linear(results: Results, recording: str) -> Iterator[Sentence]:
    """Report how current and torque are correlated, without and with the printed friction."""
    rows = results.rows("torque_constants", recording=recording, regression=AS_PRINTED)
    without, friction = rows["correlation_without_friction"], rows["correlation"]
    yield say("constants.linear", recording=recording, without=without, friction=friction)
