"""Whether the recordings determine the motors' torque constants."""

import pandas as pd

from ur5lib.report.document import Number, State, Verdict
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say
from ur5lib.report.tables.models import STOP
from ur5lib.report.verdicts.drawings import bars

TOPIC = "Torque constants"


def verdict(results: Results) -> Verdict | None:
    """Judge by the constants that the data determine; None where no friction was fitted."""
    rows = results.rows("friction", parameter="torque_constant")
    if len(results.rows("remarks", step=STOP)):
        return Verdict(TOPIC, "do not use", say("constants.contradicted"))
    if rows.empty:
        return None
    shares = rows.groupby("joint")["prior_share"].max()
    farthest = rows.loc[_factor(rows).idxmax()]
    return Verdict(
        topic=TOPIC,
        state=_state(rows),
        sentence=say("constants.verdict", parts=_parts(rows)),
        evidence=say("constants.evidence", row=farthest),
        drawing=bars({str(joint): float(share) for joint, share in shares.items()}),
        caption=say("constants.caption"),
        numbers=(_number(farthest),),
    )


def _state(rows: pd.DataFrame) -> State:
    """Return good if the data determine every constant, and none contradicts the known value."""
    determined = (rows["determined"] == "yes").all()
    return "good" if determined and rows["contradicted"].isna().all() else "usable"


def _parts(rows: pd.DataFrame) -> list[Sentence]:
    """Return which constants come from the data, and on which joints the known ones are used."""
    refused = rows[rows["contradicted"].notna()]["joint"].unique()
    determined = rows[rows["determined"] == "yes"]["joint"].unique()
    parts = [say("constants.known", known=determined) if len(determined) else say("constants.none")]
    return [*parts, say("constants.refused", refused=refused)] if len(refused) else parts


def _factor(rows: pd.DataFrame) -> pd.Series:
    """Return the ratio of each constant to the known one, or its inverse if that is larger."""
    ratio = rows["value"] / rows["known"]
    return ratio.where(ratio > 1, 1 / ratio)


def _number(row: pd.Series) -> Number:
    return Number(
        name="torque constant",
        value=float(row["value"]),
        unit="Nm/A",
        place=f"joint {row['joint']}",
        low=float(row["low"]),
        high=float(row["high"]),
        interval="95 %",
        baseline=float(row["known"]),
        baseline_of="the known constant",
    )
