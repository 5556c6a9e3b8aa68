"""Whether the recordings determine the motors' torque constants."""

import pandas as pd

from ur5lib.report.cells import joints, rounded, sentence
from ur5lib.report.document import Number, State, Verdict
from ur5lib.report.results import Results
from ur5lib.report.tables.models import STOP
from ur5lib.report.verdicts.drawings import bars

TOPIC = "Torque constants"


def verdict(results: Results) -> Verdict | None:
    """Judge by the constants that the data determine; None where no friction was fitted."""
    rows = results.rows("friction", parameter="torque_constant")
    if len(results.rows("remarks", step=STOP)):
        return Verdict(TOPIC, "do not use", "The fitted constants contradict the known ones.")
    if rows.empty:
        return None
    shares = rows.groupby("joint")["prior_share"].max()
    farthest = rows.loc[_factor(rows).idxmax()]
    return Verdict(
        topic=TOPIC,
        state=_state(rows),
        sentence=sentence("; ".join(_parts(rows))),
        evidence=(
            f"Farthest from the known value: joint {farthest['joint']}, "
            f"{rounded(farthest['value'], 2)} ± {rounded(farthest['std_error'], 2)} Nm/A; known: "
            f"{rounded(farthest['known'], 2)} ± {rounded(farthest['known_std'], 2)} Nm/A."
        ),
        drawing=bars({str(joint): float(share) for joint, share in shares.items()}),
        caption="Share of prior knowledge by joint; with a full bar, the data say nothing.",
        numbers=(_number(farthest),),
    )


def _state(rows: pd.DataFrame) -> State:
    """Return good if the data determine every constant, and none contradicts what was known."""
    determined = (rows["determined"] == "yes").all()
    return "good" if determined and rows["contradicted"].isna().all() else "usable"


def _parts(rows: pd.DataFrame) -> list[str]:
    """Return which constants come from the data, and for which joints the known ones stand."""
    refused = rows[rows["contradicted"].notna()]["joint"].unique()
    known = rows[rows["determined"] == "yes"]["joint"].unique()
    parts = ["the recordings determine no torque constant"]
    if len(known):
        parts = [f"the recordings determine the torque constants of {joints(known)}"]
    if len(refused):
        parts.append(
            f"the currents of {joints(refused)} do not follow the torque, and the known constants "
            "are used there"
        )
    return parts


def _factor(rows: pd.DataFrame) -> pd.Series:
    """Return by which factor each constant is off the known one, the larger way round."""
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
