"""Friction and motor currents: constants, prediction, cross-validation, payload."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.identification.currents import UNDETERMINED
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, names, say
from ur5lib.timeseries.segments import DEAD_ZONE

LEAST_KNOWN = 3  # parameters that the next recording is designed for
MOST_COMPARED = 12  # columns that fit on a page


def predicted(results: Results) -> list[str]:
    """Return the validate recordings whose currents were predicted."""
    rows = results.tables["current_rmse"]
    fitted = {*rows.loc[rows["model"] == "fitted", "recording"]}
    return results.shown([name for name in results.with_role("validate") if name in fitted])


def constants(results: Results) -> pd.DataFrame:
    """Return torque constants, offsets and friction, with the main source of each.

    moved: whether recordings can determine a parameter: offset and friction need motion.
    """
    rows = results.tables["friction"]
    moving = {robot: _moved(results, robot) for robot in rows["robot"].unique()}
    pairs = zip(rows["robot"], rows["joint"], strict=True)
    moved = np.array([joint in moving[robot] for robot, joint in pairs], dtype=bool)
    by_prior = np.where(rows["prior_share"] > UNDETERMINED, "prior", "undetermined")
    return rows.assign(
        moved=moved | (rows["parameter"] == "torque_constant"),
        source=np.where(rows["determined"] == "yes", "data", by_prior),
    )


def _moved(results: Results, robot: str) -> set[int]:
    """Return the joints of an arm that move on its fit recordings."""
    arms = results.arms()
    fitted = [name for name in results.with_role("fit") if arms[name] == robot]
    return set().union(*map(results.moving, fitted))


def remarks(results: Results) -> Iterator[Sentence]:
    """Return the remarks of the fit about joints."""
    rows = results.tables["remarks"].dropna(subset="joint")
    for (robot, remark), group in rows.groupby(["robot", "remark"], sort=False):
        yield say("currents.remark", robot=robot, numbers=group["joint"], remark=remark)


def reversals(results: Results) -> Iterator[Sentence]:
    """Report the error of Karnopp's friction relative to Dahl's on each arm."""
    for robot, rows in results.tables["friction_reversal"].groupby("robot", sort=False):
        least = rows.groupby(["model", "joint"])["rmse"].min()
        words = {
            "ratio": least["karnopp"] / least["dahl"],
            "chosen": [*rows.query("model == 'karnopp' and chosen == 'yes'")["joint"]],
        }
        yield say("currents.reversals", robot=robot, moving=DEAD_ZONE, **words)


def next_recordings(results: Results) -> Iterator[Sentence]:
    """Yield each arm's least determined parameters, and the command that designs a recording."""
    study, lab = results.study["study"], results.study.get("devices") or {}
    table = lab.get("table_m") or 0.0
    for robot, rows in results.tables["friction"].groupby("robot", sort=False):
        worst = rows.sort_values("prior_share", ascending=False)[:LEAST_KNOWN]
        parts = [say("currents.least known", row=row) for row in worst.itertuples()]
        words = {"robot": robot, "study": study, "table": f"{table:g}"}
        yield say("currents.next recording", parts=parts, **words)


def unseen(results: Results) -> pd.DataFrame:
    """Return the errors of moving joints on validate recordings without an undeclared load.

    zero: the error of a constant current, its standard deviation: R² = 1 − RMSE² / zero².
    """
    names = {*results.with_role("validate")} - {*loaded(results)["recording"]}
    rows = results.tables["current_rmse"]
    rows = rows[rows["recording"].isin(names)]
    moves = [row.joint in results.moving(row.recording) for row in rows.itertuples()]
    rows = rows[np.array(moves, dtype=bool)]
    return rows.assign(zero=rows["rmse_2hz"] / np.sqrt(1 - rows["r2"]))


def unseen_errors(results: Results) -> pd.DataFrame:
    """Return the means over validate recordings: of the fitted model and of the controller's."""
    rows = unseen(results)
    rows = rows[rows["model"].isin(["fitted", "i_target"])]
    means = rows.groupby(["joint", "model"])[["rmse_2hz", "zero", "coverage95"]].mean()
    return means.reset_index()


def prediction(results: Results, recording: str) -> pd.DataFrame:
    """Return the errors on a recording of the models that the report compares."""
    rows = results.rows("current_rmse", recording=recording)
    return rows[rows["model"].isin([*names("model")])]


def cross_validation(results: Results, robot: str) -> pd.DataFrame:
    """Return the RMSE, averaged over joints, of fits to one recording tested on each other.

    fitted_on: with the number under which the recording stands as a column.
    """
    rows = results.rows("cross_validation", robot=robot).dropna(subset="rmse_2hz")
    fitted = [*rows["fitted_on"].unique()][:MOST_COMPARED]
    if len(fitted) < 2:  # a fit tested on its own recording is no test
        return rows[:0]
    number = {name: i for i, name in enumerate(fitted, start=1)}
    rows = rows[rows["fitted_on"].isin(fitted) & rows["tested_on"].isin(fitted)]
    means = rows.groupby(["fitted_on", "tested_on"], sort=False)["rmse_2hz"].mean().reset_index()
    titles = [f"{number[name]} {name}" for name in means["fitted_on"]]
    return means.assign(fitted_on=titles, number=means["tested_on"].map(number))


def loaded(results: Results) -> pd.DataFrame:
    """Return the undeclared loads that are certain by the currents."""
    payload = results.tables["payload"]
    return payload[payload["taken"] == "yes"]
