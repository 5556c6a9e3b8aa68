"""Link models: rotors, the identified model, and their torques compared with the controller's."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say


def compared(results: Results) -> list[str]:
    """Return recordings with a table of torques: printed errors, and validate recordings."""
    torque = results.tables["torque_mae"]
    recordings = [*torque.loc[torque["mae"].notna(), "recording"].unique()]
    others = [name for name in results.with_role("validate") if name in recordings]
    return results.shown([*results.printed("torque_mae"), *others]) or results.shown(recordings, 1)


def mean_errors(results: Results) -> pd.DataFrame:
    """Return the means over recordings by joint, motion and model."""
    rows = results.tables["torque_mae"]
    rows = rows[rows["mae"].notna() & (rows["motion"] != "closed_loop")]
    groups = rows.groupby(["joint", "motion", "model"], sort=False, as_index=False)
    return groups[["mae", "zero_mae"]].mean()


def printed_errors(results: Results, recording: str) -> pd.DataFrame:
    """Return the errors with printed ones, those that cannot be rebuilt first."""
    rows = results.rows("torque_mae", recording=recording, motion="closed_loop")
    rows = rows[rows["printed"].notna()]
    if rows["mae"].isna().all():
        return rows[:0]
    return rows.sort_values("mae", key=pd.Series.notna, kind="stable")


def advice(results: Results) -> Iterator[Sentence]:
    """Return advice on what to record to determine more of an arm."""
    for row in results.tables["excitation"].dropna(subset="advice").itertuples():
        yield say("models.advice", row=row)


def identified(results: Results) -> Iterator[Sentence]:
    """Report how many parameters of an arm the recordings determine."""
    for robot, parameters in results.tables["parameters"].groupby("robot", sort=False):
        determined = (parameters["determined"] == "yes").sum()
        words = {"robot": robot, "determined": int(determined), "count": len(parameters)}
        yield say("models.identified", **words)
        if determined < len(parameters):
            yield say("models.undetermined")
        yield say("models.files", robot=robot)
