"""Friction and motor currents: constants, prediction, cross-validation, payload."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.identification.currents import UNDETERMINED
from ur5lib.report.cells import extremes, interval, number, with_error
from ur5lib.report.document import Cell
from ur5lib.report.results import NOTHING, Body, Column, Results, tabulated
from ur5lib.report.sentences import Sentence, say
from ur5lib.timeseries.segments import DEAD_ZONE

MODELS = {
    "fitted": "fitted",
    "least_squares": "Coulomb + viscous",
    "thesis": "thesis (6.2, 6.6)",
    "thesis_without_friction": "thesis (6.3)",
    "i_target": "target_current",
}


def predicted(results: Results) -> list[str]:
    """Return the validate recordings whose currents were predicted."""
    rows = results.tables["current_rmse"]
    fitted = {*rows.loc[rows["model"] == "fitted", "recording"]}
    return results.shown([name for name in results.with_role("validate") if name in fitted])


def constants(results: Results) -> Body:
    """Return torque constants, offsets and friction, with the thesis's values."""
    rows = results.tables["friction"]
    moved = {robot: _moved(results, robot) for robot in rows["robot"].unique()}
    body = [
        [
            Cell(row.robot),
            Cell(str(row.joint)),
            Cell(row.parameter.replace("_", " ")),
            *(_constant(row) if _is_known(row, moved[row.robot]) else REST),
        ]
        for row in rows.itertuples()
    ]
    header = ["arm", "joint", "parameter", "value", "95 %", "known", "prior share", "mainly from"]
    if not results.of_thesis:
        return Body(header, body)
    published = [number(value, 2) for value in rows["thesis"]]
    return Body([*header, "thesis"], [[*a, b] for a, b in zip(body, published, strict=True)])


SPOKEN = {
    "torque_constant": "torque constant",
    "coulomb": "Coulomb friction",
    "viscous": "viscous friction",
    "load": "load friction",
}
LEAST_KNOWN = 3  # parameters that the next recording is designed for
REST = [Cell("did not move"), *[Cell("–")] * 4]  # for parameters that only motion determines


def _moved(results: Results, robot: str) -> set[int]:
    """Return the joints of an arm that move on its fit recordings."""
    arms = results.arms()
    fitted = [name for name in results.with_role("fit") if arms[name] == robot]
    return set().union(*map(results.moving, fitted))


def _is_known(row: Any, moved: set[int]) -> bool:
    """Whether recordings can determine a parameter: offset and friction need motion."""
    return row.joint in moved or row.parameter == "torque_constant"


def _constant(row: Any) -> list[Cell]:
    """Return a constant, its interval, its prior, and its main source."""
    return [
        with_error(row.value, row.std_error, 3),
        Cell(interval(row.low, row.high, 2)),
        with_error(row.known, row.known_std, 2),
        Cell(f"{100 * row.prior_share:.0f} %"),
        Cell(_source(row)),
    ]


def _source(row: Any) -> str:
    """Return the main source of a parameter, "undetermined" if neither determines its sign."""
    if row.determined == "yes":
        return "data"
    return "prior" if row.prior_share > UNDETERMINED else "undetermined"


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
        parts = [
            say("currents.least known", name=SPOKEN.get(row.parameter, row.parameter), row=row)
            for row in worst.itertuples()
        ]
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


def unseen_errors(results: Results) -> Body:
    """Return the mean errors on validate recordings: fitted, the controller's, a constant."""
    rows = unseen(results)
    models = [model for model in ("fitted", "i_target") if model in {*rows["model"]}]
    if not models:
        return NOTHING
    mean = rows.pivot_table("rmse_2hz", "joint", "model", aggfunc="mean")
    fitted = rows[rows["model"] == "fitted"].groupby("joint")[["zero", "coverage95"]].mean()
    body = [
        [
            Cell(str(joint)),
            *(number(mean.loc[joint, model], 2) for model in models),
            number(fitted.loc[joint, "zero"], 2),
            number(100 * fitted.loc[joint, "coverage95"], 0),
        ]
        for joint in mean.index
    ]
    header = ["joint", *(MODELS[model] for model in models), "constant", "in 95 % band [%]"]
    return Body(header, body)


def prediction(results: Results, recording: str) -> Body:
    """Return the RMSE of each model on a recording that was not used for fitting."""
    rows = results.rows("current_rmse", recording=recording)
    errors = rows.set_index(["joint", "model"])["rmse_2hz"]
    models = [model for model in MODELS if model in {*rows["model"]}]
    fitted = rows[rows["model"] == "fitted"].set_index("joint")
    body = []
    for joint in range(1, 7):
        values = {model: errors[joint, model] for model in models}
        marks = extremes(values)
        line = [Cell(str(joint)), *(number(values[model], 3, marks[model]) for model in models)]
        r2, held = fitted.loc[joint, ["r2", "coverage95"]]
        body.append([*line, number(r2, 3), number(100 * held, 0)])
    header = ["joint", *(MODELS[model] for model in models), "R² of fitted", "in 95 % band [%]"]
    return Body(header, body)


def cross_validation(results: Results, robot: str) -> Body:
    """Return the RMSE, averaged over joints, of fits to one recording tested on each other."""
    rows = results.rows("cross_validation", robot=robot)
    mean = rows.pivot_table("rmse_2hz", "fitted_on", "tested_on", aggfunc="mean", sort=False)
    names = [*mean.index][:MOST_COMPARED]
    if len(names) < 2:  # a fit tested on its own recording is no test
        return NOTHING
    body = [
        [Cell(f"{i + 1} {name}")]
        + [number(mean.loc[name].get(other, float("nan")), 2) for other in names]
        for i, name in enumerate(names)
    ]
    return Body(["fitted on", *(str(i + 1) for i in range(len(names)))], body)


MOST_COMPARED = 12  # columns that fit on a page


def loaded(results: Results) -> pd.DataFrame:
    """Return the undeclared loads that are certain by the currents."""
    payload = results.tables["payload"]
    return payload[payload["taken"] == "yes"]


def payloads(results: Results) -> Body:
    """Return the mass on the flange in excess of the declared payload."""
    columns: dict[str, Column] = {
        "recording": "recording",
        "declared [kg]": lambda row: number(row.configured, 2),
        "additional [kg]": lambda row: with_error(row.mass, row.std_error, 2),
        "95 % [kg]": lambda row: interval(row.low, row.high, 2),
        "used in prediction": "taken",
    }
    return tabulated(results.tables["payload"].itertuples(), columns)
