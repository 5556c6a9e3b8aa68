"""Published torque constants and offsets: rebuilt, and the same regression on other recordings."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say
from ur5lib.report.tables.friction import AS_PRINTED

PARAMETERS = {"torque_constant": "k", "offset": "b"}


def printed(results: Results) -> list[str]:
    """Return the recordings with printed torque constants."""
    return results.printed("torque_constants", "printed_offset")


def rebuilt(results: Results, recording: str) -> pd.DataFrame:
    """Return Equation 6.5: printed, rebuilt, and by this study's fit with all friction terms."""
    rows = _by_sign(results.rows("torque_constants", recording=recording, regression=AS_PRINTED))
    fitted = _fitted(results, recording)[["value", "std_error"]].add_prefix("fitted_")
    return rows.join(fitted, on=["joint", "parameter"])


def _by_sign(rows: pd.DataFrame) -> pd.DataFrame:
    """Return a row for k and for b of each row."""
    parts = [
        rows.assign(
            sign=sign,
            parameter=name,
            value=rows[name],
            std_error=rows[f"{name}_std_error"],
            printed=rows[f"printed_{name}"],
        )
        for name, sign in PARAMETERS.items()
    ]
    return pd.concat(parts)


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


def on_every_run(results: Results, recording: str) -> pd.DataFrame:
    """Return b and k of the doubted joint by both regressions on every recording in which it
    moves, in the order of its mean torque.
    """
    rows = results.rows("torque_constants", joint=doubted_joint(results, recording))
    return _by_sign(rows).sort_values(
        ["mean_torque", "recording", "sign", "regression"], ascending=[True, True, True, False]
    )


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
